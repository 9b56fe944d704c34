"""Laws of files made from BVH."""

import contextlib
import io

import numpy as np
import pytest
from bvh_files import MIXED, check_against_oracle, clip_of, write_bvh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdGeom, UsdSkel, UsdValidation
from real_files import SHARED
from rigs import read

from geomstats_anim.kinematics import world_pose
from usd_tools.bvh.reader import read_bvh
from usd_tools.skel.joint_names import joint_paths, unique
from usd_tools.skel.new_file import ANIMATION, SKELETON
from usd_tools.skel.resampling import animation_of

BVH = SHARED / "bvh"
REAL = {  # frames, joints, frames a second
    "02_08": (1501, 31, 120),
    "124_01": (644, 31, 120),
    "12_01_walk_pybvh": (524, 31, 120),
    "131_03_bvh11": (1102, 31, 120),
    "14_08": (2626, 31, 120),
    "90_02": (782, 31, 120),
    "animateddrawings_dab": (339, 27, 30),
    "animateddrawings_jumping": (654, 27, 120000 / 1001),
    "animateddrawings_jumping_jacks": (125, 31, 30),
    "animateddrawings_zombie": (779, 27, 30),
}
needs_data = pytest.mark.skipif(not BVH.is_dir(), reason=f"the real files are not there: {BVH}")


@pytest.fixture
def converted(tmp_path, run):
    """Convert a file, and open the result."""

    def call(path, *arguments, out="out.usda"):
        code, _, err = run("from_bvh", path, "-o", tmp_path / out, *arguments)
        assert (code, err) == (0, "")
        return Usd.Stage.Open(str(tmp_path / out))

    return call


@pytest.mark.parametrize("out", ["out.usda", "out.usdc", "out.usd", "out.usdz"])
def test_joints_and_ends_are_where_the_numbers_put_them(tmp_path, converted, out):
    text = write_bvh(tmp_path / "in.bvh", n_frames=20)
    check_against_oracle(converted(tmp_path / "in.bvh", out=out), text, 0.01)


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_every_order_of_rotations(tmp_path, converted, order):
    channels = " ".join(f"{axis}rotation" for axis in order)
    text = MIXED.replace("Zrotation Xrotation Yrotation", channels).replace("Xrotation Yrotation Zrotation", channels)
    text = write_bvh(tmp_path / "in.bvh", text=text)
    check_against_oracle(converted(tmp_path / "in.bvh", "--scale", 2), text, 2.0)


@needs_data
@pytest.mark.parametrize("name", REAL)
def test_real_files(converted, name):
    n_frames, n_joints, rate = REAL[name]
    stage = converted(BVH / f"{name}.bvh", "--scale", 0.056444, out="out.usdc")
    clip = clip_of(stage)
    assert (len(clip.codes), len(clip.joints), stage.GetTimeCodesPerSecond()) == (n_frames, n_joints, rate)
    assert clip.notes == ()
    check_against_oracle(stage, (BVH / f"{name}.bvh").read_text(), 0.056444)


@needs_data
def test_no_real_file_is_forgotten():
    assert {path.stem for path in BVH.glob("*.bvh")} == set(REAL)


def test_what_the_file_says_of_itself(tmp_path, converted):
    write_bvh(tmp_path / "in.bvh")
    stage = converted(tmp_path / "in.bvh", "--up", "Z", "--scale", "0.0254")
    layer = stage.GetRootLayer()
    root = layer.pseudoRoot
    assert (layer.defaultPrim, layer.timeCodesPerSecond, layer.framesPerSecond) == ("Character", 30, 30)
    assert (layer.startTimeCode, layer.endTimeCode) == (0, 4)
    assert (root.GetInfo("upAxis"), root.GetInfo("metersPerUnit")) == ("Z", 0.0254)
    made_by = layer.customLayerData["geomstats_anim"]
    assert made_by["tool"] == "usd_tools.from_bvh"
    assert made_by["settings"] == {"source": "in.bvh", "scale": 0.0254, "up": "Z"}


def test_output_is_valid(tmp_path, converted):
    write_bvh(tmp_path / "in.bvh")
    stage = converted(tmp_path / "in.bvh")
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    with contextlib.redirect_stderr(io.StringIO()):
        errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [error.GetMessage() for error in errors] == []
    root = UsdSkel.Root.Get(stage, "/Character")
    pose = world_pose(animation_of(clip_of(stage)))
    points = np.concatenate([pose.origins, pose.ends], axis=1) / 0.01
    np.testing.assert_allclose(
        np.array(root.GetExtentAttr().Get()), [points.min((0, 1)), points.max((0, 1))], 1e-5, 1e-5
    )


def test_skeleton(tmp_path, converted):
    write_bvh(tmp_path / "in.bvh")
    stage = converted(tmp_path / "in.bvh")
    skeleton = UsdSkel.Skeleton.Get(stage, SKELETON)
    assert list(skeleton.GetJointsAttr().Get()) == [
        "Hips",
        "Hips/Spine",
        "Hips/Spine/Head",
        "Hips/Spine/Arm",
        "Hips/Leg",
    ]
    rest, bind = (np.array(skeleton.GetPrim().GetAttribute(f"{name}Transforms").Get()) for name in ("rest", "bind"))
    assert rest[:, 3, :3].tolist() == [[1, 2, 3], [0, 10, 0], [0, 5, 1], [4, 3, 0], [-1, -8, 0]]
    assert bind[:, 3, :3].tolist() == [[1, 2, 3], [1, 12, 3], [1, 17, 4], [5, 15, 3], [0, -6, 3]]
    ends = clip_of(stage).skeleton.bone_ends / 0.01
    assert np.round(ends, 9).tolist() == [[-0.5, 1, 0], [2, 4, 0.5], [1, 4, -2], [7, 1, 0], [-1, -8, 0]]


def test_samples(tmp_path, converted):
    """All channels at the same times, one a frame; quaternions of length 1 without sign flips."""
    write_bvh(tmp_path / "in.bvh", n_frames=30)
    converted(tmp_path / "in.bvh")
    codes, rotations = read(tmp_path / "out.usda", prim=ANIMATION)
    assert codes == list(range(30)) == read(tmp_path / "out.usda", "translations", ANIMATION)[0]
    rotations = np.array(rotations, dtype=np.float64)
    np.testing.assert_allclose(np.linalg.norm(rotations, axis=-1), 1.0, atol=1e-6)
    assert (np.sum(rotations[1:] * rotations[:-1], axis=-1) >= 0.0).all()
    codes, scales = read(tmp_path / "out.usda", "scales", ANIMATION)
    assert (codes, scales) == ([], [])


def test_translations_that_are_constant_are_one_value(tmp_path, converted):
    text = write_bvh(tmp_path / "in.bvh")
    head, rows = text[: text.index("MOTION")], text.splitlines()[-5:]
    fixed = np.array([row.split() for row in rows])
    fixed[:, [0, 1, 2, 7, 9, 11]] = "1.5"  # position channels that do not move
    (tmp_path / "in.bvh").write_text(
        f"{head}MOTION\nFrames: 5\nFrame Time: 0.1\n" + "\n".join(" ".join(row) for row in fixed)
    )
    stage = converted(tmp_path / "in.bvh")
    attribute = UsdSkel.Animation.Get(stage, ANIMATION).GetTranslationsAttr()
    assert attribute.GetTimeSamples() == []
    assert np.array(attribute.Get()).tolist() == [[1.5] * 3, [1.5] * 3, [0, 5, 1], [4, 3, 0], [-1, -8, 0]]
    assert UsdSkel.Animation.Get(stage, ANIMATION).GetRotationsAttr().GetNumTimeSamples() == 5


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.lower(),
        lambda text: text.upper(),
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace(" ", "\t"),
        lambda text: text.replace("\n", "\n \n"),
        lambda text: text.replace("\n  {", " {").replace("\n{", "{"),
        lambda text: "\ufeff" + text.rstrip("\n"),
        lambda text: text.replace("Frames:", "Frames :").replace("Time: ", "Time:"),
        lambda text: text.replace("OFFSET 1 2 3", "OFFSET +1. 20e-1 3.0"),
        lambda text: text.replace("End Site", "End Site Tip"),
    ],
    ids=["lower", "upper", "crlf", "cr", "tabs", "blank", "braces", "bom", "colons", "numbers", "named ends"],
)
def test_spelling_makes_no_difference(tmp_path, change):
    text = write_bvh(tmp_path / "in.bvh")
    (tmp_path / "other.bvh").write_bytes(change(text).encode())
    given, other = read_bvh(tmp_path / "in.bvh"), read_bvh(tmp_path / "other.bvh")
    assert [name.lower() for name in other.names] == [name.lower() for name in given.names]
    for name in ("parents", "offsets", "bone_ends", "rotations", "translations", "rate"):
        np.testing.assert_array_equal(getattr(other, name), getattr(given, name))


def test_skip_first(tmp_path, converted):
    write_bvh(tmp_path / "in.bvh")
    converted(tmp_path / "in.bvh", out="all.usda")
    stage = converted(tmp_path / "in.bvh", "--skip-first")
    codes, values = read(tmp_path / "out.usda", prim=ANIMATION)
    assert (codes, stage.GetEndTimeCode()) == ([0, 1, 2, 3], 3)
    # The signs of quaternions are chosen from the first frame on.
    both = np.array([values, read(tmp_path / "all.usda", prim=ANIMATION)[1][1:]])
    np.testing.assert_array_equal(*np.abs(both))


def test_fps_plays_the_same_frames_at_another_rate(tmp_path, converted):
    write_bvh(tmp_path / "in.bvh")
    converted(tmp_path / "in.bvh", out="30.usda")
    stage = converted(tmp_path / "in.bvh", "--fps", 59.94)
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 60000 / 1001
    codes, values = read(tmp_path / "out.usda", prim=ANIMATION)
    assert codes == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal(values, read(tmp_path / "30.usda", prim=ANIMATION)[1])


def test_one_frame(tmp_path, converted):
    write_bvh(tmp_path / "in.bvh", n_frames=1)
    stage = converted(tmp_path / "in.bvh")
    assert UsdSkel.Animation.Get(stage, ANIMATION).GetRotationsAttr().GetTimeSamples() == [0]


@pytest.mark.parametrize("out", ["out.usda", "out.usdc", "out.usdz"])
def test_same_input_same_bytes(tmp_path, converted, out):
    write_bvh(tmp_path / "in.bvh")
    both = []
    for _ in range(2):
        converted(tmp_path / "in.bvh", out=out)
        both.append((tmp_path / out).read_bytes())
    assert both[0] == both[1]


def test_names(tmp_path, converted):
    text = MIXED.replace("ROOT Hips", "ROOT mixamorig:Hips").replace("Head", "left arm").replace("Arm", "left-arm")
    write_bvh(tmp_path / "in.bvh", text=text.replace("Leg", "Längs"))
    stage = converted(tmp_path / "in.bvh")
    skeleton = UsdSkel.Skeleton.Get(stage, SKELETON)
    assert [str(joint).split("/")[-1] for joint in skeleton.GetJointsAttr().Get()] == [
        "mixamorig_Hips",
        "Spine",
        "left_arm",
        "left_arm_1",
        "Längs",
    ]
    assert list(skeleton.GetJointNamesAttr().Get()) == ["mixamorig:Hips", "Spine", "left arm", "left-arm", "Längs"]


@given(st.lists(st.text(max_size=3) | st.sampled_from(["a", "a_1", "a_1_1", "A"]), min_size=1, max_size=8))
@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_names_make_valid_paths(names):
    paths = joint_paths(names, range(-1, len(names) - 1))
    assert all(Sdf.Path.IsValidPathString(path)[0] for path in paths)
    assert len(set(paths[-1].split("/"))) == len(names)
    assert UsdSkel.Topology(paths).GetParentIndices() == list(range(-1, len(names) - 1))
    told_apart = unique(names)
    assert len(set(told_apart)) == len(names)
    assert all(
        new == name for i, (new, name) in enumerate(zip(told_apart, names, strict=True)) if name not in names[:i]
    )


def test_what_is_said(tmp_path, run):
    write_bvh(tmp_path / "in.bvh")
    code, out, err = run("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "out.usda")
    assert (code, err) == (0, "")
    assert out.replace(f"{tmp_path}/", "").splitlines() == [
        "in.bvh: 5 joints, 0.35 m high at rest; 5 frames.",
        "Wrote out.usda (30 time codes per second). Blender ignores this rate; set the scene's frame rate to 30.",
    ]


def test_upsample_goes_on_from_there(tmp_path, run, inspected):
    write_bvh(tmp_path / "in.bvh")
    run("from_bvh", tmp_path / "in.bvh", "-o", tmp_path / "in.usda")
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 4, "--alpha", 4)
    assert code == 0 and "is slerped" not in err
    assert inspected(tmp_path / "out.usda")["animations"][0]["samples"] == 17
    assert UsdGeom.GetStageMetersPerUnit(Usd.Stage.Open(str(tmp_path / "out.usda"))) == 0.01
