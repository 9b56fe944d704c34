"""One command for every verb, and what it costs to open the door."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from rigs import make_rig

from geomstats_anim import __version__
from usd_tools.__main__ import VERBS, main

ROOT = Path(__file__).resolve().parents[2]
HEAVY = {"numpy", "pxr", "numba", "scipy", "rich", "geomstats", "matplotlib", "plotly", "ray", "viser"}


def heavy_after(statement):
    """Run Python in a process of its own; give the heavy modules that it imported."""
    code = f"import sys\ntry:\n    {statement}\nexcept SystemExit:\n    pass\nprint('\\n' + ' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {name for name in done.stdout.splitlines()[-1].split() if name in HEAVY}


def test_every_verb_is_listed(capsys):
    modules = {path.stem for path in (ROOT / "usd_tools").glob("*.py")} - {"__init__", "__main__"}
    assert set(VERBS) == modules
    assert main(["--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for verb, line in VERBS.items():
        assert any(each.split(maxsplit=1) == [verb, line] for each in lines)


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_knows_how_it_was_called(verb, capsys):
    with pytest.raises(SystemExit) as stop:
        main([verb, "--help"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: geomstats-anim {verb} [-h]")
    with pytest.raises(SystemExit):
        import_module(f"usd_tools.{verb}").main(["--help"])
    assert capsys.readouterr().out.startswith(f"usage: python -m usd_tools.{verb} [-h]")


def test_runs_a_verb(tmp_path, capsys):
    make_rig(tmp_path / "in.usda")
    assert main(["upsample", str(tmp_path / "in.usda"), "-o", str(tmp_path / "out.usda"), "--factor", "2"]) == 0
    assert (tmp_path / "out.usda").exists() and "4 -> 7 samples" in capsys.readouterr().out
    assert main(["inspect", str(tmp_path / "nothing.usda")]) == 1


def test_version_and_unknown_words(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"geomstats-anim {__version__}\n"
    for word, sentence in {
        "upsampel": "error: unknown verb upsampel; did you mean upsample?",
        "xyz": "error: unknown verb xyz.",
        "--versoin": "error: unknown option --versoin; did you mean --version?",
    }.items():
        assert main([word]) == 2
        assert capsys.readouterr().err.splitlines()[0] == sentence


def test_as_a_module():
    done = subprocess.run([sys.executable, "-m", "usd_tools"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("usage: python -m usd_tools VERB")


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["upsampel"]])
def test_the_door_is_light(arguments):
    assert heavy_after(f"from usd_tools.__main__ import main; main({arguments})") == set()


@pytest.mark.parametrize("verb", VERBS)
def test_help_and_usage_errors_are_light(verb):
    incomplete = [] if verb == "demo" else [[]]  # which needs no arguments
    for arguments in (["--help"], ["--nonsense"], *incomplete):
        assert heavy_after(f"from usd_tools.__main__ import main; main({[verb, *arguments]})") == set()


@pytest.mark.slow
def test_numba_still_finds_blas():
    code = (
        "import geomstats_anim.kernels.compilation, numba, numpy as np; f = numba.njit(lambda a: np.cov(a) + a @ a);"
        "a = np.eye(3); assert np.allclose(f(a), np.cov(a) + a @ a)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def modules_after(verb, *arguments):
    """Run a verb in a process of its own; give every module that it imported."""
    words = [verb, *map(str, arguments)]
    code = f"import sys\nfrom usd_tools.__main__ import main\nassert main({words}) == 0\nprint(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split())


def test_inspect_imports_what_it_needs(tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(6))
    names = modules_after("inspect", tmp_path / "in.usda")
    assert not {name.partition(".")[0] for name in names} & {"numba", "scipy", "geomstats", "matplotlib"}
    assert not [name for name in names if name.startswith("geomstats_anim.learning")]


def test_upsample_imports_what_it_needs(tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(6))
    names = modules_after("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert not {name.partition(".")[0] for name in names} & {"geomstats", "matplotlib", "rich", "ray"}
    assert not {name for name in names if name.startswith("scipy.") and name.count(".") == 1 and name[6] != "_"} - {
        "scipy.version"
    }
    assert not [name for name in names if name.startswith("geomstats_anim.learning")]
