"""Sparse files that are edited, learned from, or beside others: what they remember is still told right, or refused."""

import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt
from rigs import ANIMATION, SKELETON, bits, make_rig, random_rotations, read, set_samples
from scipy.spatial.transform import Rotation

SLERP = ["--rate", ".3", "--scheme", "slerp"]


@pytest.fixture
def sparse(tmp_path, run):
    """Nine of thirty samples, from frame 1001 on."""
    offsets = np.full((30, 3, 3), 10.0, np.float32)
    make_rig(tmp_path / "in.usda", codes=range(1001, 1031), rotations=random_rotations(30, 3), translations=offsets)
    assert run("downsample", tmp_path / "in.usda", "-o", tmp_path / "sparse.usda", *SLERP)[0] == 0
    return tmp_path / "sparse.usda"


def restored(run, path):
    """Time codes of what comes back, and what is said."""
    code, out, err = run("upsample", path, "-o", path.with_name("back.usda"), "--times", "source")
    assert code == 0, err
    return read(path.with_name("back.usda"))[0], out, err


def test_inspect_tells_that_a_file_is_sparse(sparse, run):
    out = run("inspect", sparse)[1]
    assert "9 samples from sparse.usda" in out
    assert "30 samples; usd_tools.upsample --times source restores them" in out
    restored(run, sparse)
    out = run("inspect", sparse.with_name("back.usda"))[1]
    assert "30 samples from back.usda" in out and "source had" not in out


def test_a_trimmed_animation_keeps_its_times(sparse, run):
    layer = Sdf.Layer.FindOrOpen(str(sparse))
    codes = layer.ListTimeSamplesForPath(f"{ANIMATION}.rotations")
    for code in codes[:2]:
        layer.EraseTimeSample(f"{ANIMATION}.rotations", code)
    layer.Save()
    assert restored(run, sparse)[0] == list(range(int(codes[2]), 1031))


def test_an_extended_animation_keeps_its_times(sparse, run):
    stage = Usd.Stage.Open(str(sparse))
    set_samples(stage, "rotations", [1040], random_rotations(1, 3))
    stage.Save()
    assert restored(run, sparse)[0] == [*range(1001, 1031), 1040]


def test_layer_offset_moves_the_times(sparse, run):
    stage = Usd.Stage.CreateNew(str(sparse.with_name("shot.usda")))
    stage.SetTimeCodesPerSecond(24)
    stage.GetRootLayer().subLayerPaths.append("./sparse.usda")
    stage.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(-500.0, 0.5)
    stage.Save()
    np.testing.assert_allclose(restored(run, sparse.with_name("shot.usda"))[0], 0.5 + 0.5 * np.arange(30), atol=1e-9)


def test_samples_that_were_moved(sparse, run, refuse):
    layer = Sdf.Layer.FindOrOpen(str(sparse))
    path = f"{ANIMATION}.rotations"
    codes = layer.ListTimeSamplesForPath(path)
    for code in codes[1:-1]:
        layer.SetTimeSample(path, code + 0.3, layer.QueryTimeSample(path, code))
        layer.EraseTimeSample(path, code)
    layer.Save()
    sentence = refuse("upsample", sparse, "-o", sparse.with_name("out.usda"), "--times", "source")
    assert sentence == (
        f"--times source: 2 of the {len(codes)} samples of {ANIMATION} are where usd_tools.downsample left them; "
        "list time codes instead."
    )


@pytest.mark.parametrize("command", [["learn", "--rate", ".5"], ["downsample", *SLERP]], ids=["learn", "downsample"])
def test_learning_from_what_is_sparse(sparse, run, command):
    verb, *options = command
    words = f"{ANIMATION} is downsampled to 9 of 30 samples"
    assert words in run(verb, sparse, "-o", sparse.with_name("out.usda"), *options)[2]
    restored(run, sparse)
    again = run(verb, sparse.with_name("back.usda"), "-o", sparse.with_name("out.usda"), *options)
    assert again[0] == 0, again[2]
    assert "is downsampled" not in again[2]


def test_animation_beside_a_sparse_one(tmp_path, run):
    """A face that was not chosen, and keeps its samples."""
    stage = make_rig(tmp_path / "in.usda", codes=range(30), rotations=random_rotations(30, 3))
    face = UsdSkel.Animation.Define(stage, "/Rig/Face")
    face.CreateBlendShapesAttr(["smile"])
    face.CreateBlendShapeWeightsAttr()
    set_samples(stage, "blendShapeWeights", [0, 9, 29], [[[0.0]], [[1.0]], [[0.0]]], "/Rig/Face")
    stage.Save()
    words = ["-o", tmp_path / "sparse.usda", *SLERP, "--prim", ANIMATION]
    assert run("downsample", tmp_path / "in.usda", *words)[0] == 0
    codes, out, err = restored(run, tmp_path / "sparse.usda")
    assert codes == list(range(30)) and "/Rig/Face" not in out
    assert err == "warning: /Rig/Face does not store the time codes of its source; it is left unchanged.\n"
    before, after = (read(tmp_path / name, "blendShapeWeights", "/Rig/Face") for name in ("in.usda", "back.usda"))
    assert after[0] == [0, 9, 29] and bits(after[1]) == bits(before[1])


def test_channels_that_were_kept_whole_are_told_apart(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(30), rotations=random_rotations(30, 3), scales=None)
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    UsdSkel.Animation(stage.GetPrimAtPath(ANIMATION)).CreateScalesAttr()
    set_samples(stage, "scales", range(30), np.linspace(1.0, 2.0, 30)[:, None, None] * np.ones((30, 3, 3)))
    stage.Save()
    assert run("downsample", tmp_path / "in.usda", "-o", tmp_path / "sparse.usda", *SLERP)[0] == 0
    out = restored(run, tmp_path / "sparse.usda")[1]
    assert "9 -> 30 samples of rotations and translations, 30 -> 30 samples of scales, 3 joints" in out


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_tolerance_holds_in_the_largest_skeleton(tmp_path, run, scale):
    """Two skeletons share an animation; the bones, or the world, of the second are larger."""
    turns = 0.8 * np.sin(np.arange(40)[:, None, None] / 6.0 + np.arange(9).reshape(3, 3))
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(40, 3, 4)
    stage = make_rig(tmp_path / "in.usda", codes=range(40), rotations=rotations)
    Sdf.CopySpec(stage.GetRootLayer(), SKELETON, stage.GetRootLayer(), "/Rig/Giant")
    giant = stage.GetPrimAtPath("/Rig/Giant")
    if scale == 1.0:
        rest = np.array(giant.GetAttribute("restTransforms").Get())
        rest[:, 3, :3] *= 4.0
        giant.GetAttribute("restTransforms").Set(Vt.Matrix4dArray.FromNumpy(rest))
    else:
        UsdGeom.Xformable(giant).AddScaleOp().Set(Gf.Vec3f(scale))
    stage.Save()
    code, _, err = run(
        "downsample", tmp_path / "in.usda", "-o", tmp_path / "sparse.usda", "--tolerance", "1",
        "--measure", "ends", "--report", tmp_path / "report.json",
    )  # fmt: skip
    sizes = "drives skeletons of different sizes; lengths are measured on the largest, /Rig/Giant."
    assert code == 0 and err == f"warning: {ANIMATION} {sizes}\n"
    restored(run, tmp_path / "sparse.usda")
    before, after = (_end_of_arm(tmp_path / name, 40.0 if scale == 1.0 else 10.0) for name in ("in.usda", "back.usda"))
    distances = np.linalg.norm(after - before, axis=-1)
    (arm,) = (
        joint["centimetres"]["largest"]
        for joint in json.loads((tmp_path / "report.json").read_text())["animations"][0]["joints"]
        if joint["joint"].endswith("arm")
    )
    assert distances.max() == pytest.approx(arm, rel=1e-4) and 0.1 < arm <= 1.0


def _end_of_arm(path, length):
    """Return where the end of the giant's last bone is, in centimetres, as OpenUSD places it."""
    stage = Usd.Stage.Open(str(path))
    giant = stage.GetPrimAtPath("/Rig/Giant")
    cache = UsdSkel.Cache()
    query = cache.GetSkelQuery(UsdSkel.Skeleton(giant))
    assert query.GetAnimQuery()
    to_world = UsdGeom.Imageable(giant).ComputeLocalToWorldTransform(0)
    poses = [query.ComputeJointSkelTransforms(float(code))[2] for code in range(40)]
    return np.array([(pose * to_world).Transform(Gf.Vec3d(0.0, length, 0.0)) for pose in poses])
