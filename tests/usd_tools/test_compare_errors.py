"""Bad input to compare: one sentence, an exit code, nothing written, the input untouched."""

import subprocess
import sys
from functools import partial

import pytest
from rigs import make_rig, random_rotations

from usd_tools import compare
from usd_tools.console.errors import ToolError


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
    assert sentence == "None of the 2 files can be compared; the warnings say why."


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
        ("geodesic:full", "the family of geodesic must be diagonal or spd, as in geodesic:spd, not 'full'."),
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


def test_out_holds_the_input(tmp_path, clip, refused):
    (tmp_path / "out" / "usd").mkdir(parents=True)
    (tmp_path / "out" / "results.json").write_text('{"tool": "usd_tools.compare"}')
    make_rig(tmp_path / "out" / "usd" / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    sentence = refused(tmp_path / "out" / "usd" / "in.usda", "-o", tmp_path / "out")
    assert sentence == "--out out holds the input out/usd/in.usda and would be replaced; choose another name."


def test_nothing_is_left_when_drawing_fails(tmp_path, clip, out, refused, monkeypatch):
    def broken(*_):
        raise ToolError("out of paint.")

    monkeypatch.setattr(compare, "write_report", broken)
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
