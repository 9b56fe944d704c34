"""The command `study`: a blind page, and what its answers say."""

import json

import pytest
from chromium import opened
from rigs import make_rig, random_rotations

from usd_tools import study
from usd_tools.console.errors import UsageError


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study of a small clip."""
    there = tmp_path_factory.mktemp("study")
    make_rig(there / "walk <b>.usda", codes=range(24), rotations=random_rotations(24, 3, size=0.8))
    result = study.study(
        there / "walk <b>.usda", there / "out", study.StudyOptions(rate=0.3, schemes=["linear", "slerp"])
    )
    assert result.questions == 2 and result.schemes == ("linear", "slerp")
    return there / "out"


def answers(path, person, given, name="abc"):
    document = {"format": "geomstatsAnimAnswers", "version": 1, "study": name, "person": person, "answers": given}
    path.write_text(json.dumps(document))
    return path


def answer(preferred, other, question="nearer"):
    return {
        "clip": "walk",
        "question": question,
        "preferred": preferred,
        "other": other,
        "side": "left",
        "seconds": 2.5,
    }


def test_the_page_needs_nothing_and_runs_nothing_of_the_file(folder):
    text = (folder / "index.html").read_text(encoding="utf-8")
    assert "default-src 'none'" in text and "http" not in text.partition("<script")[0].replace("http-equiv", "")
    assert "<b>" not in text and "walk__b_" in text


def test_the_same_seed_gives_the_same_page(folder, tmp_path):
    options = study.StudyOptions(rate=0.3, schemes=["linear", "slerp"])
    study.study(folder.parent / "walk <b>.usda", tmp_path / "again", options)
    assert (tmp_path / "again" / "index.html").read_bytes() == (folder / "index.html").read_bytes()


def test_results_are_a_table(run, tmp_path):
    first = answers(tmp_path / "1.json", "p1", [answer("ours", "slerp")] * 25 + [answer("slerp", "ours")] * 5)
    twice = answers(tmp_path / "2.json", "p1", [answer("ours", "slerp")] * 25 + [answer("slerp", "ours")] * 5)
    other = answers(tmp_path / "3.json", "p2", [answer("ours", "slerp", "natural")] * 4)
    code, out, err = run("study", "--results", first, twice, other)
    assert code == 0 and err == ""
    assert "25 of 30" in out and "65 to 94 %" in out and "preferred" in out
    assert "4 of 4" in out and "too few answers" in out and "There are no scores yet" in out


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", "cannot be read as answers"),
        ('{"format": "other"}', "has no answers"),
        ('{"format": "geomstatsAnimAnswers", "version": 1, "answers": []}', "does not name its study"),
        (
            '{"format": "geomstatsAnimAnswers", "version": 1, "study": "s", "person": "p", "answers": [{"clip": 1}]}',
            "an answer that does not name",
        ),
    ],
)
def test_answers_of_strangers_are_checked(run, tmp_path, text, sentence):
    (tmp_path / "answers.json").write_text(text)
    code, out, err = run("study", "--results", tmp_path / "answers.json")
    assert code == 1 and out == "" and sentence in err and err.count("\n") == 1


def test_answers_to_two_studies_are_not_mixed(run, tmp_path):
    paths = [answers(tmp_path / f"{name}.json", name, [answer("a", "b")], name) for name in ("one", "two")]
    code, _, err = run("study", "--results", *paths)
    assert code == 1 and "different studies" in err


def test_wrong_usage(run, tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(6))
    assert run("study")[0] == 2
    assert run("study", tmp_path / "in.usda")[0] == 2
    assert run("study", tmp_path / "in.usda", "--results", tmp_path / "in.usda")[0] == 2
    assert run("study", tmp_path / "in.usda", "-o", tmp_path / "out", "--schemes", "slerp")[0] == 2
    with pytest.raises(UsageError, match="--rate"):
        study.StudyOptions(rate=2)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_people_answer(run, folder, tmp_path):
    with opened((folder / "index.html").as_uri()) as (tab, problems):
        for number in range(2):
            tab.get_by_text(f"{number + 1} of 2").wait_for()
            names = tab.locator("#names span")
            names.first.wait_for()
            assert "slerp" not in tab.inner_text("main") and "linear" not in tab.inner_text("main")
            stage = tab.locator("#stage")
            frames = set()
            for _ in range(40):
                frames.add(stage.get_attribute("data-frame"))
                tab.wait_for_timeout(100)
                if len(frames - {None}) > 2:
                    break
            assert len(frames - {None}) > 2
            tab.keyboard.press("ArrowLeft")
        tab.reload()  # the answers are still there
        with tab.expect_download() as download:
            tab.get_by_text("Download the answers").click()
        download.value.save_as(tmp_path / "answers.json")
        assert problems == []
    given = json.loads((tmp_path / "answers.json").read_text())["answers"]
    assert [each["question"] for each in given] != [] and len(given) == 2
    assert {each["preferred"] for each in given} <= {"linear", "slerp"}
    assert run("study", "--results", tmp_path / "answers.json")[0] == 0
