"""A tolerance is about the points that are asked for: the skin through UsdSkel, a shell by the turns that it sees."""

import json

import numpy as np
import pytest
from pxr import Usd
from real_files import needs_shared, real_file
from rigs import ANIMATION, SKELETON, make_rig, read
from scipy.spatial.transform import Rotation
from skinning import skinned

from usd_tools import downsample
from usd_tools.downsample import DownsampleOptions


def rebuilt(tmp_path, run, source, *options):
    sparse, back = tmp_path / "sparse.usda", tmp_path / "back.usda"
    code, _, err = run("downsample", source, "-o", sparse, *options, "--report", tmp_path / "report.json")
    assert code == 0
    assert run("upsample", sparse, "-o", back, "--times", "source")[0] == 0
    return json.loads((tmp_path / "report.json").read_text()), err


@needs_shared
@pytest.mark.parametrize("tolerance", [1.0, 0.2])
def test_skin_stays_within_the_tolerance(tmp_path, run, tolerance):
    source = real_file("strangers/sword_skin.usda")
    codes = range(1, 41)
    rebuilt(tmp_path, run, source, "--tolerance", tolerance)
    loose = np.linalg.norm(skinned(tmp_path / "back.usda", codes) - skinned(source, codes), axis=-1)
    assert loose.max() > tolerance  # a blade is longer than its bone
    report, err = rebuilt(tmp_path, run, source, "--tolerance", tolerance, "--measure", "skin")
    distances = np.linalg.norm(skinned(tmp_path / "back.usda", codes) - skinned(source, codes), axis=-1)
    assert 0.3 * tolerance < distances.max() <= tolerance
    assert report["settings"]["measure"] == "skin" and "twists" not in err


def make_twisting(path):
    """A leaf that turns about its own bone alone, there and back."""
    turns = np.tile(np.float32([0, 0, 0, 1]), (21, 3, 1))
    turns[:, 2] = Rotation.from_rotvec(np.sin(np.arange(21) / 4.0)[:, None] * [0.0, 1.0, 0.0]).as_quat()
    return make_rig(path, codes=range(21), rotations=turns, translations=None)


@pytest.mark.parametrize("shell", [3.0, 0.5])
def test_twists_stay_within_a_shell(tmp_path, run, shell):
    make_twisting(tmp_path / "in.usda")
    options = ["--tolerance", 0.1, "--scheme", "slerp"]
    _, err = rebuilt(tmp_path, run, tmp_path / "in.usda", *options, "--measure", "ends")
    assert "twists barely move bone ends; use --measure shell" in err
    assert len(read(tmp_path / "sparse.usda")[0]) == 2
    _, err = rebuilt(tmp_path, run, tmp_path / "in.usda", *options, *([] if shell == 3.0 else ["--shell", shell]))
    assert "twists" not in err
    turns = [
        Rotation.from_quat(np.array(read(path)[1])[:, 2]) for path in (tmp_path / "in.usda", tmp_path / "back.usda")
    ]
    chord = 2.0 * shell * np.sin((turns[0].inv() * turns[1]).magnitude() / 2.0)
    assert 0.02 < chord.max() <= 0.1 + 1e-6
    assert 2 < len(read(tmp_path / "sparse.usda")[0]) < 21


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"rate": 0.5, "measure": "shell"}, "--measure shell goes with --tolerance or --kind max"),
        ({"rate": 0.5, "shell": 2.0}, "--shell goes with --tolerance and --measure shell"),
        ({"tolerance": 1.0, "measure": "ends", "shell": 2.0}, "--shell goes with --tolerance and --measure shell"),
        ({"tolerance": 1.0, "measure": "skin", "shell": 2.0}, "--shell goes with --tolerance and --measure shell"),
    ],
)
def test_options_that_do_not_go_together(options, sentence):
    with pytest.raises(Exception, match=sentence):
        DownsampleOptions(**options)


def test_the_largest_error_of_a_number_of_keys_is_measured_too(tmp_path):
    make_twisting(tmp_path / "in.usda")
    options = {"keys": 6, "kind": "max", "scheme": "slerp"}
    errors = []
    for measure in ("ends", "shell"):
        out = tmp_path / f"{measure}.usda"
        result = downsample.downsample(tmp_path / "in.usda", out, DownsampleOptions(**options, measure=measure))
        errors.append(result.animations[0].largest_rotation_error["degrees"])
    assert errors[1] < errors[0]
    stage = Usd.Stage.Open(str(tmp_path / "shell.usda"))
    assert stage.GetPrimAtPath(ANIMATION) and stage.GetPrimAtPath(SKELETON)
