"""Bad input to compare: one sentence, an exit code, nothing written, the input untouched."""

import json
import subprocess
import sys
from functools import partial

import pytest
from rigs import make_rig, random_rotations

from usd_tools.comparison import run as comparison_run
from usd_tools.console.errors import ToolError
from usd_tools.files.folders import check_folder, made_beside


@pytest.fixture
def refused(refuse):
    """Run compare and check that it is refused politely; give the sentence."""
    return partial(refuse, "compare")


@pytest.fixture
def clip(tmp_path):
    """A good file."""
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    return tmp_path / "in.usda"


@pytest.fixture
def out(tmp_path):
    return ["-o", tmp_path / "out"]


def test_no_such_file(tmp_path, out, refused):
    assert refused(tmp_path / "no.usda", *out) == "no.usda: there is no such file."


def test_no_animation_in_any(tmp_path, out, refused):
    for name in ("a", "b"):
        make_rig(tmp_path / f"{name}.usda", codes=range(2))
    sentence = refused(tmp_path / "a.usda", tmp_path / "b.usda", *out)
    assert sentence == "None of the 2 files can be compared; see the warnings."


def test_one_bad_file_is_named_and_skipped(tmp_path, clip, out, run):
    (tmp_path / "bad.usda").write_text("nonsense")
    words = ["--rates", ".4", "--schemes", "slerp"]
    code, _, err = run("compare", tmp_path / "bad.usda", clip, *out, *words)
    assert code == 0 and "warning: skipped:" in err and "bad.usda cannot be read as USD" in err
    assert '"file": "bad.usda"' in (tmp_path / "out" / "results.json").read_text()


def test_no_out(clip, refused):
    assert "-o" in refused(clip, exit_code=2)


@pytest.mark.parametrize(
    ("word", "sentence"),
    [
        (
            "bezier",
            "must be constant, linear, slerp, squad, rotation-spline, geodesic or geodesic-spline, not 'bezier'.",
        ),
        ("slerp:spd", "slerp has no metric, so it has no family; write slerp alone"),
        ("geodesic:full", "the family of geodesic must be diagonal, spd or plain, as in geodesic:spd, not 'full'."),
    ],
)
def test_schemes(clip, out, refused, word, sentence):
    assert sentence in refused(clip, *out, "--schemes", word, exit_code=2)


@pytest.mark.parametrize("rate", ["0", "1", "a"])
def test_rates(clip, out, refused, rate):
    assert "must be a number above 0 and below 1" in refused(clip, *out, "--rates", rate, exit_code=2)


def test_out_is_a_file(tmp_path, clip, refused):
    (tmp_path / "out").write_text("mine")
    assert refused(clip, "-o", tmp_path / "out") == "--out out is a file; name a folder."


def test_out_is_a_link(tmp_path, clip, refused):
    (tmp_path / "there").mkdir()
    (tmp_path / "out").symlink_to("there")
    assert refused(clip, "-o", tmp_path / "out") == "--out out is a link; name a folder."


def test_out_without_parent(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "no" / "out")
    assert sentence == "--out no/out: there is no folder no; make it first."


def test_out_holds_something_else(tmp_path, clip, refused):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    sentence = refused(clip, "-o", tmp_path / "out")
    assert sentence == "--out out holds notes.txt, which usd_tools.compare did not write; choose another name."


def test_out_looks_like_ours_but_is_not(tmp_path, clip, refused):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "results.json").write_text("[1, 2]")
    sentence = refused(clip, "-o", tmp_path / "out")
    assert sentence == "--out out holds results.json, which usd_tools.compare did not write; choose another name."


@pytest.mark.parametrize("manifest", ["[]", "{", '{"tool": "other", "files": ["usd/mine.usda"]}', '{"tool": 1}'])
def test_out_with_a_manifest_of_others(tmp_path, clip, refused, manifest):
    (tmp_path / "out" / "usd").mkdir(parents=True)
    (tmp_path / "out" / "usd" / "mine.usda").write_text("mine")
    (tmp_path / "out" / "manifest.json").write_text(manifest)
    sentence = refused(clip, "-o", tmp_path / "out")
    assert sentence == "--out out holds manifest.json, which usd_tools.compare did not write; choose another name."


OTHER_PLACES = ("notes.txt", "figures/deep/er/notes.txt", "usd/link")


@pytest.mark.parametrize(
    "place", ["usd/in/notes.txt", *(pytest.param(each, marks=pytest.mark.slow) for each in OTHER_PLACES)]
)
def test_files_of_others_in_any_depth_stay(tmp_path, clip, run, refused, place):
    words = ["compare", clip, "-o", tmp_path / "out", "--rates", ".4", "--schemes", "slerp"]
    assert run(*words)[0] == 0
    assert run(*words)[0] == 0  # nothing there but ours
    mine = tmp_path / "out" / place
    mine.parent.mkdir(parents=True, exist_ok=True)
    if place.endswith("link"):
        mine.symlink_to(tmp_path)
    else:
        mine.write_text("mine")
    sentence = refused(*words[1:])
    assert sentence == f"--out out holds {place}, which usd_tools.compare did not write; choose another name."


def test_files_that_come_during_the_work_move_along(tmp_path):
    def fill(text, late=()):
        with made_beside(tmp_path / "out", "tool") as folder:
            (folder / "a").mkdir()
            (folder / "a" / "ours.txt").write_text(text)
            for name in late:
                (tmp_path / "out" / name).parent.mkdir(exist_ok=True)
                (tmp_path / "out" / name).write_text("mine")

    fill("one")
    fill("two", ["a/b/mine.txt", "mine.txt"])
    found = {path.relative_to(tmp_path / "out").as_posix(): path.read_text() for path in tmp_path.rglob("*.txt")}
    assert found == {"a/ours.txt": "two", "a/b/mine.txt": "mine", "mine.txt": "mine"}
    with pytest.raises(ToolError, match="mine.txt, which tool did not write"):
        check_folder(tmp_path / "out", "tool", ())
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_out_holds_the_input(tmp_path, clip, refused):
    (tmp_path / "out" / "usd").mkdir(parents=True)
    make_rig(tmp_path / "out" / "usd" / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    manifest = {"tool": "usd_tools.compare", "files": ["manifest.json", "usd/in.usda"]}
    (tmp_path / "out" / "manifest.json").write_text(json.dumps(manifest))
    sentence = refused(tmp_path / "out" / "usd" / "in.usda", "-o", tmp_path / "out")
    assert sentence == "--out out holds the input out/usd/in.usda and would be replaced; choose another name."


def test_nothing_is_left_when_drawing_fails(tmp_path, clip, out, refused, monkeypatch):
    def broken(*_):
        raise ToolError("out of paint.")

    monkeypatch.setattr(comparison_run, "write_report", broken)
    assert refused(clip, *out, "--rates", ".4", "--schemes", "slerp") == "out of paint."
    assert [path.name for path in tmp_path.iterdir()] == ["in.usda"]


def test_no_cluster(clip, out, refused):
    pytest.importorskip("ray")
    sentence = refused(clip, *out, "--rates", ".4", "--schemes", "slerp", "--address", "127.0.0.1:1")
    assert sentence.startswith("There is no Ray cluster at 127.0.0.1:1")


def test_help_imports_nothing_heavy():
    heavy = "{'matplotlib', 'plotly', 'geomstats', 'ray', 'jinja2'}"
    code = (
        "import sys\nfrom usd_tools import compare\n"
        "try:\n compare.main(['--help'])\nexcept SystemExit:\n pass\n"
        f"assert not {heavy} & set(sys.modules), {heavy} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
