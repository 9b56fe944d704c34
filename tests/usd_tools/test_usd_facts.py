"""What OpenUSD does, line by line as in the notes that the readers and writers rely on."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Ts, Usd, UsdGeom, UsdSkel, Vt
from rigs import ANIMATION, SKELETON, bits, make_rig, random_rotations, read, set_samples
from scipy.spatial.transform import Rotation

from geomstats_anim import rotations as quat
from usd_tools.skel.channels import CHANNELS
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations


def clip_of(path):
    return read_clip(find_animations(Usd.Stage.Open(str(path)))[0])


def test_numpy_sees_quaternions_scalar_last():
    kind = CHANNELS["rotations"]
    assert (
        kind.to_numpy(Vt.QuatfArray([Gf.Quatf(0.1, 0.2, 0.3, 0.4)])).tolist()
        == np.float32([[0.2, 0.3, 0.4, 0.1]]).tolist()
    )
    values = random_rotations(1, 5)[0]
    assert kind.to_numpy(kind.to_usd(values)).tobytes() == values.tobytes()


@pytest.mark.parametrize(("degrees", "shown"), [(170, 170), (190, -170), (270, -90), (350, -10)])
def test_a_turn_of_more_than_half_cannot_be_represented(tmp_path, run, inspected, degrees, shown):
    """Signs say nothing: USD goes the shorter way, and so do we; what is near to half a turn is named."""
    turn = Rotation.from_rotvec([[0, 0, 0], [0, 0, np.radians(degrees)]]).as_quat()
    half = np.radians(degrees) / 2
    turn[1] = [0, 0, np.sin(half), np.cos(half)]
    make_rig(tmp_path / "in.usda", codes=(0, 1), joints=["a"], rotations=turn[:, None].astype(np.float32))
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    middle = Rotation.from_quat(read(tmp_path / "out.usda")[1][1][0]).as_rotvec(degrees=True)
    np.testing.assert_allclose(middle, [0, 0, shown / 2], atol=1e-4)
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    viewer = Rotation.from_quat(np.array(stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").Get(0.5))[0])
    np.testing.assert_allclose(viewer.as_rotvec(degrees=True), middle, atol=1e-3)
    beyond = "a file cannot store which way a turn beyond 180 degrees went"
    named = f"warning: {ANIMATION}: joint a turns {abs(shown):.1f} degrees from time code 0 to 1; {beyond}"
    assert (code, err) == (0, f"{named}, so the shorter way is used.\n" if abs(shown) > 120 else "")
    told = inspected(tmp_path / "in.usda")
    assert told["warnings"] == ([f"{named.removeprefix('warning: ')}."] if abs(shown) > 120 else [])
    assert told["animations"][0]["sign_flips"] == (degrees > 180)


def test_many_wide_steps_are_one_sentence(tmp_path, run):
    turns = np.zeros((5, 1, 4), dtype=np.float32)
    turns[:, 0, 2:] = [(np.sin(a), np.cos(a)) for a in np.radians([0, 65, 0, 70, 0])]
    make_rig(tmp_path / "in.usda", codes=range(5), joints=["a"], rotations=turns)
    call = ["upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2]
    err = run(*call)[2]
    assert err.count("\n") == 1 and "turns 140.0 degrees" in err and ", and 3 other steps are over 120; " in err
    assert run(*call, "-v")[2].count("warning: ") == 4


def test_nothing_is_written_outside_of_the_samples(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=(5, 6, 7))
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(100)
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 48)
    assert read(tmp_path / "out.usda")[0] == [5, 5.5, 6, 6.5, 7]


def test_blocked_animation_is_a_value_block_for_good(tmp_path, run, refuse):
    """`BlockAnimation` in a stronger layer hides all samples below, and leaves the default."""
    make_rig(tmp_path / "weak.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "in.usda"))
    stage.GetRootLayer().subLayerPaths.append("./weak.usda")
    for name in ("rotations", "translations"):
        stage.GetPrimAtPath(ANIMATION).GetAttribute(name).BlockAnimation()
    stage.Save()
    sentence = refuse("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence.endswith(f"at least two samples: {ANIMATION} has 0.")


def test_animation_that_has_no_joint_of_its_skeleton(tmp_path, run):
    make_rig(tmp_path / "in.usda", anim_joints=["tail", "tail/tip", "ear"])
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert (code, err) == (
        0,
        f"warning: {ANIMATION} has no joint of {SKELETON}, which it drives, so nothing moves in viewers; "
        "tail is not one of hips, spine, arm.\n",
    )
    assert len(read(tmp_path / "out.usda")[0]) == 7


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_any_axis_is_up(tmp_path, run, axis):
    stage = make_rig(tmp_path / "in.usda")
    stage.SetMetadata("upAxis", axis)
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    make_rig(tmp_path / "plain.usda")
    run("upsample", tmp_path / "plain.usda", "-o", tmp_path / "plain2.usda", "--factor", 2)
    assert Usd.Stage.Open(str(tmp_path / "out.usda")).GetMetadata("upAxis") == axis
    assert bits(read(tmp_path / "out.usda")[1]) == bits(read(tmp_path / "plain2.usda")[1])


@pytest.mark.parametrize(
    ("units", "scale", "metres"),
    [
        (1.0, (1, 1, 1), 1.0),
        (0.01, (1, 1, 1), 0.01),
        (1.0, (0.01,) * 3, 0.01),
        (0.01, (100,) * 3, 1.0),
        (1, (1, 8, 1), 2),
    ],
)
def test_lengths_are_metres_in_the_world(tmp_path, units, scale, metres):
    """A file of Blender says metersPerUnit 1 and scales the armature by 0.01."""
    stage = make_rig(tmp_path / "in.usda")
    UsdGeom.SetStageMetersPerUnit(stage, units)
    xform = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig"))
    xform.AddTranslateOp().Set((3.0, 0.0, 0.0))
    xform.AddRotateZOp().Set(40.0)
    xform.AddScaleOp().Set(Gf.Vec3f(*scale))
    stage.Save()
    clip = clip_of(tmp_path / "in.usda")
    np.testing.assert_allclose(clip.world_scale, metres, rtol=1e-6)
    np.testing.assert_allclose(clip.skeleton.rest_translations, [[0, 10 * metres, 0]] * 3, rtol=1e-6)


@pytest.mark.parametrize(("codes", "frames", "rate"), [(None, None, 24), (None, 30, 30), (60, 30, 60), (60, None, 60)])
def test_seconds_come_from_time_codes_and_only_then_from_frames(tmp_path, inspected, codes, frames, rate):
    make_rig(tmp_path / "in.usda")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "in.usda"))
    layer.ClearTimeCodesPerSecond()
    if codes is not None:
        layer.timeCodesPerSecond = codes
    if frames is not None:
        layer.framesPerSecond = frames
    layer.Save()
    told = inspected(tmp_path / "in.usda")
    assert (told["time_codes_per_second"], told["frames_per_second"]) == (rate, frames)
    np.testing.assert_allclose(told["animations"][0]["seconds"], [0, 3 / rate])


def test_sublayers_are_stretched_to_the_rate_of_the_root(tmp_path, run):
    """And an override that forgot to copy the rate up would play a source of 30 a second at 24."""
    make_rig(tmp_path / "weak.usda", rate=30)
    root = Sdf.Layer.CreateNew(str(tmp_path / "in.usda"))
    root.subLayerPaths = ["./weak.usda"]
    root.subLayerOffsets[0] = Sdf.LayerOffset(100.0, 2.0)
    root.timeCodesPerSecond = 24
    root.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    codes, values = read(tmp_path / "out.usda")
    np.testing.assert_allclose(codes, 100 + 2 * 24 / 30 * np.arange(7) / 2)
    assert bits(values[::2]) == bits(read(tmp_path / "weak.usda")[1])
    assert Usd.Stage.Open(str(tmp_path / "out.usda")).GetTimeCodesPerSecond() == 24


def test_quaternions_of_any_length_stay_at_samples_and_are_unit_between(tmp_path, run, inspected):
    rotations = random_rotations(5, 3)
    lengths = np.float32([1e-3, 0.5, 1.0, 3.0, 1e3])[:, None, None] * np.float32([1, -1, 1])[:, None]
    make_rig(tmp_path / "in.usda", codes=range(5), rotations=rotations * lengths)
    make_rig(tmp_path / "unit.usda", codes=range(5), rotations=rotations)
    for name in ("in", "unit"):
        run("upsample", tmp_path / f"{name}.usda", "-o", tmp_path / f"{name}2.usda", "--factor", 3, "--alpha", 2)
    found, unit = (np.array(read(tmp_path / f"{name}2.usda")[1], dtype=np.float64) for name in ("in", "unit"))
    assert bits(found[::3].astype(np.float32)) == bits(rotations * lengths)
    between = np.arange(13) % 3 > 0
    np.testing.assert_allclose(np.linalg.norm(found[between], axis=-1), 1.0, atol=1e-6)
    assert quat.distance(found[between], quat.normalize(unit[between])).max() < 2e-6
    assert inspected(tmp_path / "in.usda")["animations"][0]["not_unit_quaternions"] == 12


def test_default_is_passed_through_and_hides_nothing(tmp_path, run):
    """One sample or a default in a stronger layer hides all weaker samples, so the override has all of them."""
    stage = make_rig(tmp_path / "in.usda", translations=None)
    stage.GetPrimAtPath(ANIMATION).GetAttribute("translations").Set([(1, 2, 3)] * 3)
    stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").Set([Gf.Quatf(1)] * 3)  # beside the samples
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "out.usda"))
    assert not layer.GetAttributeAtPath(f"{ANIMATION}.translations")
    assert layer.GetNumTimeSamplesForPath(f"{ANIMATION}.rotations") == 7
    stage = Usd.Stage.Open(layer)  # kept: prims die with their stage
    animation = UsdSkel.Animation.Get(stage, ANIMATION)
    assert np.array(animation.GetTranslationsAttr().Get(1)).tolist() == [[1, 2, 3]] * 3
    assert animation.GetRotationsAttr().Get() == [Gf.Quatf(1)] * 3


def test_scales_are_copied_in_their_half_precision(tmp_path, run):
    scales = np.random.default_rng(0).uniform(1e-3, 1e3, (4, 3, 3)).astype(np.float16)
    make_rig(tmp_path / "in.usda", scales=scales)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert bits(read(tmp_path / "out.usda", "scales")[1][::2]) == bits(scales)


def test_weights_of_blend_shapes_go_into_the_same_output(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["smile"])
    set_samples(stage, "blendShapeWeights", (0, 1.5, 3), np.float32([[[0]], [[1]], [[0]]]))
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--scheme", "squad")
    codes, weights = read(tmp_path / "out.usda", "blendShapeWeights")
    assert codes == read(tmp_path / "out.usda")[0]
    np.testing.assert_allclose(np.ravel(weights), np.interp(codes, [0, 1.5, 3], [0, 1, 0]), atol=1e-7)


def test_curves_cannot_be_authored_for_skeletons():
    for name in ("rotations", "translations", "scales"):
        assert not Ts.Spline.IsSupportedValueType(CHANNELS[name].value_type.type)
