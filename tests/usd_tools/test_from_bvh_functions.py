"""`from_bvh` as a function, and on open stages."""

import doctest

import numpy as np
import pytest
from bvh_files import MIXED, placed, write_bvh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel
from rigs import read

from usd_tools import from_bvh as module
from usd_tools.console.errors import ToolError, UsageError
from usd_tools.from_bvh import FromBvhOptions, from_bvh, from_bvh_stage
from usd_tools.skel.new_file import ANIMATION, ROOT, SKELETON

Y_TO_Z = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # rows are what the axes become


def stage_with(up="Z", metres=1.0, rate=60.0):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    stage.SetTimeCodesPerSecond(rate)
    return stage


def world_origins(stage, seconds, skeleton=SKELETON):
    """Joints in the world as OpenUSD shows them, in metres, shape=[F, B, 3]."""
    cache, found = UsdSkel.Cache(), UsdSkel.Skeleton.Get(stage, skeleton)
    cache.Populate(UsdSkel.Root(stage.GetPrimAtPath(Sdf.Path(skeleton).GetParentPath())), Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(found)
    codes = seconds * stage.GetTimeCodesPerSecond()
    matrices = [query.ComputeJointWorldTransforms(UsdGeom.XformCache(Usd.TimeCode(code))) for code in codes]
    return np.array(matrices)[:, :, 3, :3] * UsdGeom.GetStageMetersPerUnit(stage)


@pytest.mark.parametrize("rate", [25.0, 60.0, 24.0])
@pytest.mark.parametrize(("own", "up", "turn"), [("Y", "Z", Y_TO_Z), ("Z", "Y", Y_TO_Z.T), ("Z", "Z", np.eye(3))])
@pytest.mark.parametrize("metres", [0.01, 1.0])
def test_a_character_fits_the_stage(tmp_path, rate, own, up, turn, metres):
    text = write_bvh(tmp_path / "in.bvh", time="0.04")
    stage = stage_with(up, metres, rate)
    result = from_bvh_stage(tmp_path / "in.bvh", stage, FromBvhOptions(scale=0.0254, up=own))
    places = 0.0254 * placed(text)[1] @ turn
    found = world_origins(stage, np.arange(5) / 25)
    np.testing.assert_allclose(found, places, rtol=0, atol=1e-5 * np.abs(places).max())
    assert (result.path, result.prim, result.rate, result.frames) == (None, str(ROOT), 25, 5)
    assert (stage.GetTimeCodesPerSecond(), UsdGeom.GetStageMetersPerUnit(stage)) == (rate, metres)
    extent = np.array(UsdGeom.Boundable.Get(stage, ROOT).GetExtentAttr().Get())
    box = Gf.BBox3d(
        Gf.Range3d(*map(Gf.Vec3d, extent.tolist())),
        UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(ROOT)),
    )
    inside = box.ComputeAlignedRange()
    assert (places / metres >= np.array(inside.GetMin()) - 1e-3).all()
    assert (places / metres <= np.array(inside.GetMax()) + 1e-3).all()


def test_a_stage_of_the_same_units_gets_what_the_file_has(tmp_path):
    write_bvh(tmp_path / "in.bvh")
    from_bvh(tmp_path / "in.bvh", tmp_path / "out.usda")
    stage = stage_with("Y", 0.01, 30)
    from_bvh_stage(tmp_path / "in.bvh", stage)
    characters = []
    for source in (Sdf.Layer.FindOrOpen(str(tmp_path / "out.usda")), stage.GetRootLayer()):
        character = Sdf.Layer.CreateAnonymous(".usda")
        Sdf.CopySpec(source, ROOT, character, ROOT)
        characters.append(character.ExportToString())
    assert characters[0] == characters[1]


def test_names_that_are_taken(tmp_path):
    write_bvh(tmp_path / "in.bvh")
    stage = stage_with()
    paths = [from_bvh_stage(tmp_path / "in.bvh", stage).prim for _ in range(3)]
    assert paths == ["/Character", "/Character_1", "/Character_2"]
    binding = UsdSkel.BindingAPI(stage.GetPrimAtPath("/Character_1/Skeleton"))
    assert binding.GetAnimationSource().GetPath() == "/Character_1/Animation"


@pytest.mark.parametrize("knows_offset", [True, False])
def test_edit_targets_with_an_offset(tmp_path, knows_offset):
    """What is seen on the stage is the same, whatever layer holds it."""
    text = write_bvh(tmp_path / "in.bvh", time="0.04")
    stage, layer = stage_with("Y", 0.01, 50), Sdf.Layer.CreateAnonymous(".usda")
    layer.timeCodesPerSecond = 50
    root = stage.GetRootLayer()
    root.subLayerPaths.append(layer.identifier)
    root.subLayerOffsets[0] = Sdf.LayerOffset(10, 2)
    stage.SetEditTarget(stage.GetEditTargetForLocalLayer(layer) if knows_offset else Usd.EditTarget(layer))
    from_bvh_stage(tmp_path / "in.bvh", stage)
    assert not root.GetPrimAtPath(ROOT)
    assert layer.ListTimeSamplesForPath(ANIMATION.AppendProperty("rotations")) == [-5, -4, -3, -2, -1]
    places = 0.01 * placed(text)[1]
    found = world_origins(stage, np.arange(5) / 25)
    np.testing.assert_allclose(found, places, rtol=0, atol=1e-5 * np.abs(places).max())


@pytest.mark.parametrize("broken", ["no file", "broken file", "locked layer"])
def test_a_stage_is_left_as_it_was(tmp_path, broken):
    stage = stage_with()
    before = stage.GetRootLayer().ExportToString()
    if broken != "no file":
        write_bvh(tmp_path / "in.bvh", text=MIXED if broken == "locked layer" else MIXED.replace("JOINT Leg", "LEG"))
    stage.GetRootLayer().SetPermissionToEdit(broken != "locked layer")
    with pytest.raises(ToolError):
        from_bvh_stage(tmp_path / "in.bvh", stage)
    assert stage.GetRootLayer().ExportToString() == before


def test_results_warnings_and_progress(tmp_path, capfd):
    (tmp_path / "in.bvh").write_text(write_bvh(tmp_path / "in.bvh").replace("Frames: 5", "Frames: 4"))
    told, shown = [], []
    result = from_bvh(
        str(tmp_path / "in.bvh"),
        str(tmp_path / "out.usda"),
        FromBvhOptions(fps=23.98, skip_first=True, scale=0.1),
        progress=lambda *state: shown.append(state),
        warn=told.append,
    )
    assert (result.path, result.prim) == (tmp_path / "out.usda", "/Character")
    assert (result.joints, result.frames, result.rate) == (5, 4, 24000 / 1001)
    assert result.height_metres == pytest.approx(3.5)
    assert len(told) == 1 and result.warnings == tuple(told)
    assert [done for done, total, _ in shown] == [1, 2, 3] and {total for _, total, _ in shown} == {3}
    assert len(read(tmp_path / "out.usda", prim=ANIMATION)[0]) == 4
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"scale": 0}, "--scale must be a positive number, not 0"),
        ({"fps": -1}, "--fps must be a positive number, not -1"),
        ({"up": "X"}, "--up must be Y or Z, not 'X'"),
        ({"usd_format": "usdz"}, "--usdFormat must be usda or usdc, not 'usdz'"),
    ],
)
def test_options_that_are_not_allowed(options, sentence):
    with pytest.raises(UsageError, match=sentence):
        FromBvhOptions(**options)


def test_examples_in_docstrings():
    result = doctest.testmod(module)
    assert result.attempted > 10 and result.failed == 0
