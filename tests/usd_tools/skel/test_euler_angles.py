"""Euler angles beside the quaternions."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from rigs import ANIMATION, make_rig, random_rotations, read

from geomstats_anim import rotations as quat
from usd_tools.skel.euler_angles import ANGLES, ORDER


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
@pytest.mark.parametrize("verb", [["upsample", "--factor", 8], ["resample", "--fps", 200, "--retime"]])
def test_angles_are_those_of_the_transform_op_and_never_jump(tmp_path, run, order, verb):
    t = np.arange(60)[:, None]
    turns = np.array([[0.3, 0.1, 0.2], [0.0, 0.35, 0.0], [0.1, -0.2, 0.3]])[None] * t[..., None]
    make_rig(tmp_path / "in.usda", range(60), quat.exp(turns).astype(np.float32))
    code, _, err = run(verb[0], tmp_path / "in.usda", "-o", tmp_path / "out.usda", *verb[1:], "--euler", order)
    assert code == 0 and "error" not in err
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    prim = stage.GetPrimAtPath(ANIMATION)
    codes, values = read(tmp_path / "out.usda")
    assert prim.GetAttribute(ANGLES).GetTimeSamples() == codes and prim.GetAttribute(ORDER).Get() == order
    degrees = np.array([prim.GetAttribute(ANGLES).Get(code) for code in codes])
    assert np.abs(np.diff(degrees, axis=0)).max() < 180.0
    assert np.ptp(degrees, axis=0).max() > 720.0
    scratch = Usd.Stage.CreateInMemory()
    op = UsdGeom.Xform.Define(scratch, "/X").AddXformOp(getattr(UsdGeom.XformOp, f"TypeRotate{order}"))
    for frame in range(0, len(codes), 23):
        for joint in range(3):
            op.Set(Gf.Vec3f(*map(float, degrees[frame, joint])))
            shown = op.GetOpTransform(Usd.TimeCode.Default()).ExtractRotationQuat()
            turned = np.array([*shown.GetImaginary(), shown.GetReal()])
            assert quat.distance(turned, quat.normalize(values[frame][joint].astype(float))) < 1e-5


def test_blocks_stay_and_other_orders_are_refused(tmp_path, run, refuse):
    rotations = list(random_rotations(6, 3))
    rotations[3] = None
    make_rig(tmp_path / "in.usda", range(6), rotations, translations=None)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--euler", "ZYX")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute(ANGLES)
    assert attribute.Get(3.0) is None and attribute.Get(2.0) is not None
    assert "XYX" in refuse("upsample", tmp_path / "in.usda", "--factor", 2, "--euler", "XYX", exit_code=2)
