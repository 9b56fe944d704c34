"""Transforms that move a character as a whole get its samples; those that move more do not, and are named."""

import json

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdSkel
from real_files import real_file
from rigs import ANIMATION, SKELETON, make_rig, random_rotations
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, Skeleton, interpolate

COUNT, FACTOR = 8, 4
CODES = np.arange(COUNT)
DENSE = np.arange(FACTOR * (COUNT - 1) + 1) / FACTOR
WAVES = np.sin(0.7 * CODES[:, None] + [0.0, 1.0, 2.0])
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def rig(path, add, prim="/Rig"):
    """A moving rig, to one of whose prims `add` adds transform ops."""
    stage = make_rig(path, codes=CODES, rotations=random_rotations(COUNT, 3))
    add(UsdGeom.Xformable(stage.GetPrimAtPath(prim)))
    stage.GetRootLayer().Save()
    return stage


def set_samples(op, values):
    for code, value in zip(CODES.tolist(), values, strict=True):
        op.Set(value, code)


def upsampled(run, folder, *words):
    """Upsample, and give the stage, the animation's report and stderr."""
    report = folder / "report.json"
    names = [folder / "in.usda", "-o", folder / "out.usda", "--report", report]
    code, _, err = run("upsample", *names, "--factor", FACTOR, *words)
    assert code == 0, err
    return Usd.Stage.Open(str(folder / "out.usda")), json.loads(report.read_text())["animations"][0], err


def samples(stage, name, prim="/Rig"):
    attribute = stage.GetPrimAtPath(prim).GetAttribute(name)
    codes = attribute.GetTimeSamples()
    return np.array(codes), [attribute.Get(code) for code in codes]


def check_keys(stage, source, name, prim="/Rig"):
    """Samples at all times of the animation, those of the source bit for bit."""
    codes, values = samples(stage, name, prim)
    source_codes, source_values = samples(source, name, prim)
    np.testing.assert_array_equal(codes, DENSE)
    assert [values[FACTOR * k] for k in range(len(source_codes))] == source_values
    return values


def expected_turns(rotations, scheme):
    """Return what the scheme makes of the turns of one joint."""
    one = Skeleton(["xform"], [-1], np.zeros((1, 3)), [[0.0, 0.0, 0.0, 1.0]])
    keys = Animation(one, CODES / 24.0, rotations.as_quat()[:, None], np.zeros((COUNT, 1, 3)))
    return Rotation.from_quat(interpolate(keys, DENSE / 24.0, scheme).rotations[:, 0])


@pytest.mark.parametrize("prim", ["/Rig", SKELETON])
@pytest.mark.parametrize("precision", [UsdGeom.XformOp.PrecisionDouble, UsdGeom.XformOp.PrecisionFloat])
def test_translations_are_carried_as_the_scheme_carries_them(tmp_path, run, prim, precision):
    points = 50.0 * WAVES
    make = Gf.Vec3d if precision == UsdGeom.XformOp.PrecisionDouble else Gf.Vec3f

    def add(xform):
        set_samples(xform.AddTranslateOp(precision), [make(*point) for point in points.tolist()])

    source = rig(tmp_path / "in.usda", add, prim)
    for scheme, expected in (
        ("squad", CubicSpline(CODES, points)(DENSE)),
        ("slerp", np.stack([np.interp(DENSE, CODES, column) for column in points.T], axis=-1)),
    ):
        stage, report, _ = upsampled(run, tmp_path, "--scheme", scheme)
        values = check_keys(stage, source, "xformOp:translate", prim)
        np.testing.assert_allclose(np.array(values), expected, atol=1e-4)
        name = f"{prim}.xformOp:translate"
        assert report["xforms"] == [{"attribute": name, "samples_before": COUNT, "samples_after": len(DENSE)}]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("offset", [0.0, 350.0])
def test_euler_angles_turn_as_the_scheme_turns(tmp_path, run, order, offset):
    degrees = 60.0 * WAVES + offset

    def add(xform):
        set_samples(getattr(xform, f"AddRotate{order}Op")(), [Gf.Vec3f(*row) for row in degrees.tolist()])

    source = rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    values = np.array(check_keys(stage, source, f"xformOp:rotate{order}"))
    assert np.abs(np.diff(values, axis=0)).max() < 45.0
    # OpenUSD itself says what turn the angles are
    matrices = np.array([UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).GetLocalTransformation(c) for c in DENSE])
    at_keys = Rotation.from_matrix(matrices[::FACTOR, :3, :3].swapaxes(1, 2))
    turned = Rotation.from_matrix(matrices[:, :3, :3].swapaxes(1, 2))
    errors = (turned * expected_turns(at_keys, "geodesic-spline").inv()).magnitude()
    assert errors.max() < 1e-5


def test_wrapped_angles_do_not_spin_back(tmp_path, run):
    degrees = (40.0 * CODES + 200.0) % 360.0

    def add(xform):
        set_samples(xform.AddRotateYOp(), degrees.tolist())

    source = rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    values = np.array(check_keys(stage, source, "xformOp:rotateY"))
    np.testing.assert_allclose((values - 40.0 * DENSE - 200.0 + 180.0) % 360.0, 180.0, atol=1e-3)


@pytest.mark.parametrize("op", ["RotateZ", "RotateXYZ"])
def test_full_turns_are_made(tmp_path, run, op):
    degrees = 250.0 * CODES

    def add(xform):
        spins = degrees.tolist() if op == "RotateZ" else [Gf.Vec3f(0.0, 0.0, spin) for spin in degrees]
        set_samples(getattr(xform, f"Add{op}Op")(), spins)

    source = rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    values = np.array(check_keys(stage, source, f"xformOp:{op[0].lower()}{op[1:]}")).reshape(len(DENSE), -1)[:, -1]
    np.testing.assert_allclose(values, 250.0 * DENSE, atol=1e-2)


def test_another_name_of_the_same_turn_is_not_gone_to(tmp_path, run):
    degrees = 20.0 * WAVES
    degrees[4:] = np.stack([degrees[4:, 0] + 180.0, 180.0 - degrees[4:, 1], degrees[4:, 2] - 180.0], axis=-1)

    def add(xform):
        set_samples(xform.AddRotateXYZOp(), [Gf.Vec3f(*row) for row in degrees.tolist()])

    rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    matrices = np.array([UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).GetLocalTransformation(c) for c in DENSE])
    turned = Rotation.from_matrix(matrices[:, :3, :3].swapaxes(1, 2))
    steps = (turned[1:] * turned[:-1].inv()).magnitude()
    assert steps.max() < np.radians(12.0)


@pytest.mark.parametrize("make", [Gf.Quath, Gf.Quatf, Gf.Quatd])
def test_quaternions_keep_their_type_and_signs(tmp_path, run, make):
    precision = {Gf.Quath: "Half", Gf.Quatf: "Float", Gf.Quatd: "Double"}[make]
    keys = Rotation.from_rotvec(1.2 * WAVES).as_quat()
    keys[3] *= -1.0

    def add(xform):
        op = xform.AddOrientOp(getattr(UsdGeom.XformOp, f"Precision{precision}"))
        set_samples(op, [make(w, x, y, z) for x, y, z, w in keys.tolist()])

    source = rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    values = check_keys(stage, source, "xformOp:orient")
    assert {type(value) for value in values} == {make}
    found = np.array([[*value.imaginary, value.real] for value in values], dtype=np.float64)
    errors = (Rotation.from_quat(found) * expected_turns(Rotation.from_quat(keys), "geodesic-spline").inv()).magnitude()
    assert errors.max() < (5e-3 if make is Gf.Quath else 1e-6)


def test_matrices_that_are_exact_are_taken_apart(tmp_path, run):
    turns, sizes = Rotation.from_rotvec(WAVES), 1.0 + 0.3 * WAVES
    matrices = np.tile(np.eye(4), (COUNT, 1, 1))
    matrices[:, :3, :3] = sizes[..., None] * turns.as_matrix().swapaxes(1, 2)
    matrices[:, 3, :3] = 20.0 * WAVES

    def add(xform):
        set_samples(xform.AddTransformOp(), [Gf.Matrix4d(*matrix.ravel()) for matrix in matrices])

    source = rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path, "--scheme", "squad")
    values = np.array(check_keys(stage, source, "xformOp:transform"))
    np.testing.assert_allclose(values[:, 3, :3], CubicSpline(CODES, 20.0 * WAVES)(DENSE), atol=1e-9)
    linear = np.stack([np.interp(DENSE, CODES, column) for column in sizes.T], axis=-1)
    np.testing.assert_allclose(np.linalg.norm(values[:, :3, :3], axis=-1), linear, atol=1e-9)
    turned = Rotation.from_matrix((values[:, :3, :3] / linear[..., None]).swapaxes(1, 2))
    assert (turned * expected_turns(turns, "squad").inv()).magnitude().max() < 1e-7


@pytest.mark.parametrize("fault", ["shear", "mirror", "nothing"])
def test_other_matrices_are_named_and_left(tmp_path, run, fault):
    matrices = np.tile(np.eye(4), (COUNT, 1, 1))
    matrices[:, 3, :3] = 20.0 * WAVES
    matrices[4, 0, :3] = {"shear": [1.0, 0.2, 0.0], "mirror": [-1.0, 0.0, 0.0], "nothing": [0.0, 0.0, 0.0]}[fault]

    def add(xform):
        set_samples(xform.AddTransformOp(), [Gf.Matrix4d(*matrix.ravel()) for matrix in matrices])

    source = rig(tmp_path / "in.usda", add)
    stage, report, err = upsampled(run, tmp_path)
    assert report["xforms"] == [] and "/Rig.xformOp:transform keeps its 8 samples: its matrices are not" in err
    assert samples(stage, "xformOp:transform")[1] == samples(source, "xformOp:transform")[1]


def test_scales_are_linear_and_what_stays_stays(tmp_path, run):
    sizes = 1.0 + 0.5 * WAVES
    sizes[3] = sizes[2]
    points = np.round(30.0 * WAVES)
    points[3] = points[2]

    def add(xform):
        set_samples(xform.AddScaleOp(), [Gf.Vec3f(*row) for row in sizes.tolist()])
        set_samples(xform.AddTranslateOp(), [Gf.Vec3d(*row) for row in points.tolist()])

    source = rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    values = np.array(check_keys(stage, source, "xformOp:scale"))
    expected = np.stack([np.interp(DENSE, CODES, column) for column in sizes.T], axis=-1)
    np.testing.assert_allclose(values, expected, atol=1e-6)
    moved = check_keys(stage, source, "xformOp:translate")
    assert set(moved[2 * FACTOR : 3 * FACTOR + 1]) == {Gf.Vec3d(*points[2].tolist())}


def test_a_root_that_teleports_is_held(tmp_path, run):
    points = np.zeros((COUNT, 3))
    points[:, 0] = CODES
    points[4:, 2] = 500.0

    def add(xform):
        set_samples(xform.AddTranslateOp(), [Gf.Vec3d(*point) for point in points.tolist()])

    rig(tmp_path / "in.usda", add)
    for words, held in (((), True), (("--no-cuts",), False), (("--cut", "4"), True), (("--cut", "2"), False)):
        stage, _, _ = upsampled(run, tmp_path, *words)
        heights = np.array(samples(stage, "xformOp:translate")[1])[:, 2]
        assert (set(heights.tolist()) == {0.0, 500.0}) == held


def test_two_samples_are_enough(tmp_path, run):
    def add(xform):
        op = xform.AddTranslateOp()
        op.Set(Gf.Vec3d(0.0), 0)
        op.Set(Gf.Vec3d(7.0), 7)

    rig(tmp_path / "in.usda", add)
    stage, _, _ = upsampled(run, tmp_path)
    codes, values = samples(stage, "xformOp:translate")
    np.testing.assert_array_equal(codes, DENSE)
    np.testing.assert_allclose(np.array(values), np.tile(DENSE[:, None], 3), atol=1e-12)


def test_no_xforms_leaves_them(tmp_path, run):
    def add(xform):
        set_samples(xform.AddTranslateOp(), [Gf.Vec3d(*point) for point in WAVES.tolist()])

    rig(tmp_path / "in.usda", add)
    stage, report, err = upsampled(run, tmp_path, "--no-xforms")
    assert len(samples(stage, "xformOp:translate")[0]) == COUNT and report["xforms"] == [] and "keeps" not in err


def world(path, add_other=None, moving="/World"):
    """A rig below a group that moves."""
    make_rig(path.with_name("rig.usda"), codes=CODES, rotations=random_rotations(COUNT, 3))
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetTimeCodesPerSecond(24.0)
    UsdGeom.Xform.Define(stage, "/World")
    UsdGeom.Xform.Define(stage, "/World/Place").GetPrim().GetReferences().AddReference("./rig.usda", "/Rig")
    if add_other:
        add_other(stage)
    set_samples(
        UsdGeom.Xformable(stage.GetPrimAtPath(moving)).AddTranslateOp(), [Gf.Vec3d(*row) for row in WAVES.tolist()]
    )
    stage.GetRootLayer().Save()


def test_groups_of_one_character_alone_move_with_it(tmp_path, run):
    world(tmp_path / "in.usda")
    stage, report, _ = upsampled(run, tmp_path)
    assert [each["attribute"] for each in report["xforms"]] == ["/World.xformOp:translate"]
    np.testing.assert_array_equal(samples(stage, "xformOp:translate", "/World")[0], DENSE)


@pytest.mark.parametrize(
    "add_other",
    [
        lambda stage: UsdGeom.Cube.Define(stage, "/World/Cube"),
        lambda stage: UsdGeom.Camera.Define(stage, "/World/Camera"),
        lambda stage: UsdSkel.Skeleton.Define(stage, "/World/Place/Other"),
    ],
    ids=["prop", "camera", "character"],
)
def test_groups_that_hold_more_are_named_and_left(tmp_path, run, add_other):
    world(tmp_path / "in.usda", add_other)
    stage, report, err = upsampled(run, tmp_path)
    assert report["xforms"] == []
    assert "/World.xformOp:translate keeps its 8 samples: it also moves prims that" in err
    assert len(samples(stage, "xformOp:translate", "/World")[0]) == COUNT


def test_instances_are_named_and_left(tmp_path, run):
    def add(xform):
        set_samples(xform.AddTranslateOp(), [Gf.Vec3d(*row) for row in WAVES.tolist()])

    rig(tmp_path / "rig.usda", add, SKELETON)
    stage = Usd.Stage.CreateNew(str(tmp_path / "in.usda"))
    prim = UsdGeom.Xform.Define(stage, "/One").GetPrim()
    prim.GetReferences().AddReference("./rig.usda", "/Rig")
    prim.SetInstanceable(True)
    stage.GetRootLayer().Save()
    _, report, err = upsampled(run, tmp_path)
    assert report["xforms"] == [] and "keeps its 8 samples: it is inside an instance" in err


def test_what_resets_the_stack_ends_it(tmp_path, run):
    def reset(stage):
        UsdGeom.Xformable(stage.GetPrimAtPath("/World/Place")).SetResetXformStack(True)

    world(tmp_path / "in.usda", reset)
    _, report, err = upsampled(run, tmp_path)
    assert report["xforms"] == [] and "xformOp" not in err


def test_an_edit_target_gets_them_too(tmp_path):
    from usd_tools.upsample import UpsampleOptions, upsample_stage

    def add(xform):
        set_samples(xform.AddTranslateOp(), [Gf.Vec3d(*row) for row in WAVES.tolist()])

    stage = rig(tmp_path / "in.usda", add)
    stage.SetEditTarget(stage.GetSessionLayer())
    upsample_stage(stage, UpsampleOptions(factor=FACTOR))
    np.testing.assert_array_equal(samples(stage, "xformOp:translate")[0], DENSE)
    assert stage.GetRootLayer().GetNumTimeSamplesForPath("/Rig.xformOp:translate") == COUNT
    assert len(stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples()) == len(DENSE)


def test_a_jump_of_a_real_stranger_gets_its_arc(tmp_path, run):
    code, _, err = run(
        "upsample", real_file("strangers/root_motion_on_skelroot.usda"), "-o", tmp_path / "out.usda", "--factor", 4
    )
    assert code == 0, err
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    codes, values = samples(stage, "xformOp:translate", "/Root")
    np.testing.assert_array_equal(codes, np.arange(1.0, 42.0))
    height = np.array(values)[:, 1]
    time = (codes - 1.0) / 24.0
    truth = np.polyval(np.polyfit(time[::4], height[::4], 2), time)
    straight = np.interp(time, time[::4], height[::4])
    assert np.abs(height - truth).max() < 0.4 * np.abs(straight - truth).max()
