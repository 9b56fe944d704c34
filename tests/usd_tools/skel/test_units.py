"""A unit of a file in metres: the stage's unit times the scale of the skeleton in the world."""

import pytest
from pxr import Gf, UsdGeom
from rigs import make_rig


@pytest.mark.parametrize("units", [0.01, 0.0254, 1.0, 100.0])
@pytest.mark.parametrize("scale", [0.01, 1.0, 2.5])
def test_inspect_tells_both(tmp_path, inspected, units, scale):
    stage = make_rig(tmp_path / "in.usda")
    UsdGeom.SetStageMetersPerUnit(stage, units)
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddScaleOp().Set(Gf.Vec3f(scale))
    stage.GetRootLayer().Save()
    found = inspected(tmp_path / "in.usda")
    assert found["meters_per_unit"] == pytest.approx(units, rel=1e-12)
    (animation,) = found["animations"]
    assert animation["meters_per_unit"] == pytest.approx(units * scale, rel=1e-6)


def test_a_file_that_does_not_say_is_in_centimetres(tmp_path, inspected):
    stage = make_rig(tmp_path / "in.usda")
    stage.ClearMetadata("metersPerUnit")
    stage.GetRootLayer().Save()
    found = inspected(tmp_path / "in.usda")
    assert found["meters_per_unit"] == found["animations"][0]["meters_per_unit"] == pytest.approx(0.01)
