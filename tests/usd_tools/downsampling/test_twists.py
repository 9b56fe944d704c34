"""Twists about a bone's own axis, which no bone end shows."""

import json

import numpy as np
import pytest
from rigs import ANIMATION, JOINTS, make_rig
from scipy.spatial.transform import Rotation


@pytest.fixture
def twisting(tmp_path):
    """Forty samples of an arm that turns about its own axis by up to 70 degrees, and of nothing else."""
    turns = np.zeros((40, 3, 3))
    turns[:, 2, 1] = 70.0 * np.sin(np.arange(40) / 5.0)
    rotations = Rotation.from_euler("xyz", turns.reshape(-1, 3), degrees=True).as_quat().reshape(40, 3, 4)
    translations = np.tile(np.float32([0.0, 10.0, 0.0]), (40, 3, 1))
    make_rig(tmp_path / "in.usda", codes=range(40), rotations=rotations.astype(np.float32), translations=translations)
    return tmp_path / "in.usda"


def test_a_twist_that_no_bone_end_shows_is_told(tmp_path, twisting, run):
    report, out = tmp_path / "report.json", tmp_path / "out.usda"
    code, said, err = run(
        "downsample", twisting, "-o", out, "--tolerance", ".1", "--measure", "ends", "--report", report
    )
    animation = json.loads(report.read_text())["animations"][0]
    worst = animation["largest_rotation_error"]
    assert code == 0 and animation["rebuilt"]["centimetres"]["largest"] <= 0.1
    assert worst["joint"] == JOINTS[2] and worst["degrees"] == animation["rebuilt"]["degrees"]["largest"] > 10.0
    where = f"{worst['degrees']:.3g} degrees, joint arm at time code {worst['time_code']:g}"
    assert f"Largest rotation error, rebuilt: {where}." in said
    assert err.count("warning: ") == 1
    twist = f"joint arm is off by {worst['degrees']:.3g} degrees at time code {worst['time_code']:g}"
    assert f"{ANIMATION}: bone ends are within 0.1 cm, but {twist}, since twists barely move bone ends" in err
    assert err.strip().removeprefix("warning: ") in json.loads(report.read_text())["warnings"]


def test_what_the_warning_of_a_twist_suggests_helps(tmp_path, twisting, run):
    ends = ["--tolerance", ".1", "--measure", "ends"]
    for arguments in (["--keys", "12", "--kind", "rot"], [*ends, "--keep", "4,8,12,16,20,24,28,32,36"], ends[:2]):
        report = tmp_path / "report.json"
        _, _, err = run("downsample", twisting, "-o", tmp_path / "out.usda", "--report", report, *arguments)
        assert err == ""
        assert json.loads(report.read_text())["animations"][0]["largest_rotation_error"]["degrees"] < 10.0
