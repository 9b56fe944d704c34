"""Usage errors of every verb: the sentence first, then the usage, and the word that was meant."""

import subprocess
import sys

import pytest
from rigs import make_rig

USAGE = {
    "upsample": ["in.usda", "-o", "out.usda", "--factor", "2"],
    "downsample": ["in.usda", "-o", "out.usda", "--rate", ".3"],
    "learn": ["in.usda", "-o", "out.usda"],
    "compare": ["in.usda", "-o", "out"],
    "inspect": ["in.usda"],
    "from_bvh": ["in.bvh", "-o", "out.usda"],
}


@pytest.fixture
def usage_error(run):
    """Run a verb and check that it ends as a usage error does; give the sentence."""

    def call(verb, *arguments):
        code, out, err = run(verb, *arguments)
        sentence, usage = err.split("\n", 1)
        assert (code, out) == (2, "")
        assert sentence.startswith("error: ") and sentence.endswith((".", "?"))
        assert usage.startswith("usage: ")
        return sentence.removeprefix("error: ")

    return call


@pytest.mark.parametrize(
    ("verb", "arguments", "sentence"),
    [
        ("upsample", ["--factr", "4"], "unknown option --factr; did you mean --factor?"),
        ("downsample", ["--tolerence=1"], "unknown option --tolerence; did you mean --tolerance?"),
        ("learn", ["--purposes", "predict"], "unknown option --purposes; did you mean --purpose?"),
        ("compare", ["--scheme=slerp", "--rats", ".3"], "unknown option --rats; did you mean --rates?"),
        ("inspect", ["--jason"], "unknown option --jason; did you mean --json?"),
        ("from_bvh", ["--skipfirst"], "unknown option --skipfirst; did you mean --skip-first?"),
        ("inspect", ["--zzzz"], "unknown option --zzzz."),
    ],
)
def test_unknown_options_are_named_before_what_they_leave_missing(usage_error, verb, arguments, sentence):
    assert usage_error(verb, *arguments) == sentence
    assert usage_error(verb, *USAGE[verb], *arguments) == sentence


@pytest.mark.parametrize(
    ("verb", "arguments", "sentence"),
    [
        (
            "upsample",
            ["--scheme", "geodsic"],
            "--scheme: must be constant, linear, slerp, squad, rotation-spline, geodesic, geodesic-spline or "
            "learned, not 'geodsic'; did you mean geodesic?",
        ),
        (
            "upsample",
            ["--invariance", "rihgt"],
            "--invariance: must be left or right, not 'rihgt'; did you mean right?",
        ),
        ("learn", ["--family", "SPD"], "--family: must be diagonal or spd, not 'SPD'; did you mean spd?"),
        ("from_bvh", ["--up", "X"], "--up: must be Y or Z, not 'X'."),
        (
            "upsample",
            ["--joint", "arm:alhpa=2"],
            "--joint: 'alhpa=2' in 'arm:alhpa=2' must set alpha, beta, invariance, tension, "
            "translation-tension or axes; did you mean alpha?",
        ),
        (
            "compare",
            ["--schemes", "slerpp"],
            "--schemes: must be constant, linear, slerp, squad, rotation-spline, geodesic or geodesic-spline, not "
            "'slerpp'; did you mean slerp?",
        ),
        (
            "compare",
            ["--schemes", "geodesic:diag"],
            "--schemes: the family of geodesic must be diagonal, spd or plain, as in geodesic:spd, not 'diag'; did you "
            "mean diagonal?",
        ),
    ],
)
def test_unknown_values(usage_error, verb, arguments, sentence):
    assert usage_error(verb, *USAGE[verb], *arguments) == sentence


@pytest.mark.parametrize("verb", USAGE)
def test_controls_in_arguments_are_escaped(usage_error, verb):
    assert usage_error(verb, *USAGE[verb], "--x\x1b[2Jy\nz\x07") == r"unknown option --x\x1b[2Jy\nz\x07."


@pytest.mark.parametrize("verb", ["upsample", "downsample"])
def test_options_may_be_shortened(run, verb):
    code, _, err = run(verb, "missing.usda", "-o", "out.usda", "--fac=2" if verb == "upsample" else "--rat=.5")
    assert code == 1 and err.startswith("error: missing.usda")


def test_the_parser_costs_nothing():
    heavy = "{'pxr', 'numpy', 'numba', 'scipy', 'rich', 'geomstats'}"
    code = f"import usd_tools.console.parser, sys; assert not {heavy} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("pattern", ["hipps*", "Spin", "arms"])
def test_the_joint_that_was_meant(tmp_path, refuse, pattern):
    make_rig(tmp_path / "in.usda")
    words = ["--factor", 2, "--joint", f"{pattern}:alpha=2"]
    sentence = refuse("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", *words)
    meant = {"hipps*": "hips", "Spin": "spine", "arms": "arm"}[pattern]
    assert sentence == f"--joint {pattern} matches no joint; did you mean {meant}?"
