"""BVH as other programs write it: what Blender reads of it is what comes out."""

import re

import numpy as np
import pytest
from bvh_files import MIXED, check_against_oracle, clip_of, write_bvh
from pxr import Usd
from real_files import real_file

from geomstats_anim.kinematics import world_pose
from usd_tools.bvh.reader import read_bvh
from usd_tools.skel.resampling import animation_of


@pytest.fixture
def converted(tmp_path, run):
    """Convert a file; give the stage and what is said on stderr."""

    def call(path, *arguments):
        code, _, err = run("from_bvh", path, "-o", tmp_path / "out.usda", *arguments)
        assert code == 0, err
        return Usd.Stage.Open(str(tmp_path / "out.usda")), err.replace(f"{path.parent}/", "")

    return call


@pytest.mark.parametrize("said", [4, 6])
def test_a_row_more_or_less_than_frames_says(tmp_path, converted, said):
    text = write_bvh(tmp_path / "in.bvh").replace("Frames: 5", f"Frames: {said}")
    (tmp_path / "in.bvh").write_text(text)
    stage, err = converted(tmp_path / "in.bvh")
    check_against_oracle(stage, text, 0.01)
    assert err == f"warning: in.bvh, line 40: Frames says {said}, but the file has 5; all 5 are read.\n"


def test_no_row_is_no_motion(tmp_path, refuse):
    text = write_bvh(tmp_path / "in.bvh", n_frames=1)
    (tmp_path / "in.bvh").write_text(text.rstrip("\n").rpartition("\n")[0])
    sentence = refuse("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "out.usda")
    assert sentence == "in.bvh, line 41: the file ends after 0 of the 1 frames of line 40; correct one of them."


@pytest.mark.parametrize("line", ["Frame Time: 0\n", "Frame Time:\n", "frame  time : 1/30\n", "Frame Time: nan\n", ""])
def test_frame_time_is_not_needed_where_the_rate_is_given(tmp_path, line):
    text = write_bvh(tmp_path / "in.bvh")
    (tmp_path / "other.bvh").write_text(text.replace("Frame Time: 0.0333333\n", line))
    other = read_bvh(tmp_path / "other.bvh", rate=25.0)
    assert other.rate == 25
    np.testing.assert_array_equal(other.rotations, read_bvh(tmp_path / "in.bvh").rotations)


TREE = MIXED[MIXED.index("ROOT") : MIXED.index("MOTION")]
OTHER_TREE = re.sub("(ROOT|JOINT) ", r"\1 Other", TREE).replace("OFFSET 1 2 3", "OFFSET 9 0 1")


def test_several_roots(tmp_path, converted):
    text = MIXED.replace("MOTION", f"{OTHER_TREE}MOTION")
    rows = np.random.default_rng(3).uniform(-170, 170, (4, 36))
    lines = "\n".join(" ".join(f"{number:.6f}" for number in row) for row in rows)
    text = text.replace("{frames}", "4").replace("{time}", "0.04").replace("{rows}", lines)
    (tmp_path / "in.bvh").write_text(text)
    stage, err = converted(tmp_path / "in.bvh")
    assert err == ""
    clip = clip_of(stage)
    assert clip.skeleton.parents.tolist() == [-1, 0, 1, 1, 0, -1, 5, 6, 6, 5]
    check_against_oracle(stage, text, 0.01)


def test_joints_without_channels(tmp_path, converted):
    """They stay as they are at rest, and those below them still move."""
    given = write_bvh(tmp_path / "in.bvh").splitlines()
    rows = [row.split() for row in given[-5:]]
    text = "\n".join(
        [line for line in given[:-5] if "Yrotation Zposition" not in line]  # the Spine's six, columns 6 to 11
        + [" ".join(row[:6] + row[12:]) for row in rows]
    )
    (tmp_path / "in.bvh").write_text(text)
    stage, err = converted(tmp_path / "in.bvh")
    assert err == ""
    check_against_oracle(stage, text, 0.01)
    spine = read_bvh(tmp_path / "in.bvh")
    np.testing.assert_array_equal(spine.rotations[:, 1], [[0, 0, 0, 1]] * 5)
    np.testing.assert_array_equal(spine.translations[:, 1], [[0, 10, 0]] * 5)


def test_no_joint_has_channels(tmp_path, refuse):
    head = MIXED[: MIXED.index("MOTION")].splitlines()
    text = "\n".join([line for line in head if "CHANNELS" not in line] + ["MOTION", "Frames: 1", "Frame Time: 1", "0"])
    (tmp_path / "in.bvh").write_text(text)
    sentence = refuse("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "out.usda")
    assert sentence == "in.bvh, line 37: 1 numbers for 0 channels; repair the file."


def test_one_more(converted):
    stage, err = converted(real_file("strangers/frames_one_more.bvh"))
    assert len(clip_of(stage).codes) == 20
    assert err == "warning: frames_one_more.bvh, line 17: Frames says 19, but the file has 20; all 20 are read.\n"


def test_frame_time_zero(converted):
    stage, err = converted(real_file("strangers/frame_time_zero.bvh"), "--fps", 30)
    assert (len(clip_of(stage).codes), stage.GetTimeCodesPerSecond(), err) == (20, 30, "")


def test_two_roots(converted):
    path = real_file("strangers/two_roots.bvh")
    stage, err = converted(path)
    clip = clip_of(stage)
    assert (len(clip.codes), clip.joints, err) == (20, ("Hips", "Hips/Spine", "Hips2", "Hips2/Spine2"), "")
    check_against_oracle(stage, path.read_text(), 0.01)
    origins = world_pose(animation_of(clip)).origins
    np.testing.assert_array_equal(origins[:, :2], origins[:, 2:])  # the two move alike


def test_decimal_comma(tmp_path, refuse):
    sentence = refuse("from_bvh", real_file("strangers/decimal_comma.bvh"), "-o", tmp_path / "out.usda")
    assert sentence.endswith(
        "decimal_comma.bvh, line 18: 0,0333333 has a decimal comma; replace the commas of numbers with points."
    )


def test_decimal_commas_in_rows(tmp_path, refuse):
    """The rate from the command line does not hide them."""
    sentence = refuse("from_bvh", real_file("strangers/decimal_comma.bvh"), "-o", tmp_path / "out.usda", "--fps", 30)
    assert "line 19: 0,0000 has a decimal comma" in sentence
