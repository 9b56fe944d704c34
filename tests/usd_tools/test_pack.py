"""Laws of packed files: within the tolerance as read back, and unpacked at the samples of the source."""

import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt
from rigs import ANIMATION, SKELETON, bits, make_rig, random_rotations, read, set_samples

from geomstats_anim import rotations as quat
from geomstats_anim.markers import Markers, world_errors
from usd_tools.pack import PackOptions, pack, pack_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.packed import PACKED
from usd_tools.skel.resampling import animation_of
from usd_tools.unpack import unpack, unpack_stage

N = 30


def motion(path):
    return animation_of(read_clip(find_animations(Usd.Stage.Open(str(path)))[0]))


def largest_error(path, source):
    """In centimetres, of joints, bone ends and shell in the world."""
    truth = motion(source)
    return 100.0 * world_errors(motion(path), truth, Markers.of_shell(truth)).max()


@pytest.fixture
def source(tmp_path):
    codes = np.arange(N)
    rotations = random_rotations(N, 3)
    make_rig(tmp_path / "in.usda", codes=codes, rotations=rotations)
    return tmp_path / "in.usda"


@pytest.mark.parametrize("name", ["out.usdc", "out.usda", "out.usdz"])
def test_packed_file_keeps_the_tolerance_and_reports_what_is_measured(source, tmp_path, run, name):
    report = tmp_path / "report.json"
    code, text, err = run("pack", source, "-o", tmp_path / name, "--tolerance", 0.5, "--report", report)
    assert (code, err) == (0, "")
    (told,) = json.loads(report.read_text())["animations"]
    largest = largest_error(tmp_path / name, source)
    assert 0.2 < largest <= 0.5
    assert told["errors"]["centimetres"]["largest"] == pytest.approx(largest, rel=1e-9)
    stage = Usd.Stage.Open(str(tmp_path / name))
    attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute(PACKED)
    assert attribute.IsCustom() and attribute.GetVariability() == Sdf.VariabilityUniform
    assert attribute.GetTypeName() == ("string" if name.endswith("a") else "uchar[]")
    assert len(attribute.Get()) == told["bytes_packed"] * (5 / 4 if name.endswith("a") else 1) or name.endswith("a")
    assert f"{told['bytes_packed']} bytes" in text and "nanoseconds" in text


@pytest.mark.parametrize("preview", [0, 5])
def test_unpacked_file_is_what_packed_file_reads_as(source, tmp_path, run, preview):
    packed, back = tmp_path / "packed.usdc", tmp_path / "back.usdc"
    run("pack", source, "-o", packed, "--tolerance", 1, "--preview", preview)
    assert run("unpack", packed, "-o", back)[0] == 0
    left = read(packed)
    assert len(left[0]) == (preview or 2)
    assert not Usd.Stage.Open(str(back)).GetPrimAtPath(ANIMATION).HasAttribute(PACKED)
    clip = read_clip(find_animations(Usd.Stage.Open(str(packed)))[0])
    for channel in ("rotations", "translations"):
        codes, values = read(back, channel)
        assert codes == list(range(N))
        assert bits(values) == bits(clip.channels[channel].values)
    if preview:
        place = dict(zip(*read(source), strict=True))
        assert bits(left[1]) == bits([place[code] for code in left[0]])
    else:
        assert bits(left[1]) == bits([read(source)[1][0]] * 2)


def test_packing_again_gives_the_same_stream(source, tmp_path, run):
    streams = []
    run("pack", source, "-o", tmp_path / "a.usdc", "--tolerance", 1)
    run("unpack", tmp_path / "a.usdc", "-o", tmp_path / "b.usda")
    run("pack", tmp_path / "b.usda", "-o", tmp_path / "c.usda", "--tolerance", 1)
    run("pack", tmp_path / "a.usdc", "-o", tmp_path / "d.usdc", "--tolerance", 1)
    for name in ("a.usdc", "c.usda", "d.usdc"):
        stage = Usd.Stage.Open(str(tmp_path / name))
        (found,) = find_animations(stage)
        from usd_tools.skel.packed import read_packed

        clip = read_clip(found)
        streams.append(read_packed(found.prim, clip.channels).stream)
    assert streams[0] == streams[1] == streams[2]


def test_blocks_cuts_uneven_times_and_attributes_of_their_own_survive(tmp_path, run):
    codes = np.sort(np.random.default_rng(1).choice(np.arange(0, 60, 0.25), N, replace=False))
    rotations = list(random_rotations(N, 3))
    rotations[10] = rotations[11] = None
    moved = np.array([[[0, 10, 0], [0, 10, 0], [0, 10 + k, 0]] for k in range(3)], dtype=np.float32)
    stage = make_rig(tmp_path / "in.usda", codes=codes, rotations=rotations, translations=None)
    set_samples(stage, "translations", codes[[0, 15, N - 1]], moved)
    stage.GetRootLayer().Save()
    for preview in (0, 4):
        packed = tmp_path / f"packed{preview}.usdc"
        code, _, err = run("pack", tmp_path / "in.usda", "-o", packed, "--tolerance", 0.5, "--preview", preview)
        assert (code, err) == (0, "")
        run("unpack", packed, "-o", tmp_path / "back.usda")
        now, values = read(tmp_path / "back.usda")
        assert now == codes.tolist()
        assert [value is None for value in values] == [value is None for value in rotations]
        live = [k for k in range(N) if rotations[k] is not None]
        truth = quat.normalize(np.array([rotations[k] for k in live], dtype=np.float64))
        ours = quat.normalize(np.array([values[k] for k in live], dtype=np.float64))
        assert quat.distance(ours, truth).max() < np.radians(20.0)
        # translations have samples wherever rotations have them, on the lines between their own
        now, values = read(tmp_path / "back.usda", "translations")
        assert now == codes.tolist()
        expected = np.interp(codes, codes[[0, 15, N - 1]], moved[:, 2, 1])
        np.testing.assert_allclose(np.array(values)[:, 2, 1], expected, atol=1.0)
        # in a block, viewers see nothing, as in the source
        for path in (packed, tmp_path / "back.usda"):
            assert Usd.Stage.Open(str(path)).GetPrimAtPath(ANIMATION).GetAttribute("rotations").Get(codes[10]) is None


@pytest.mark.parametrize("rate", [24.0, 30.0])
def test_layer_offsets_move_packed_motion(source, tmp_path, run, rate):
    run("pack", source, "-o", tmp_path / "packed.usda", "--tolerance", 1, "--preview", 3)
    layer = Sdf.Layer.CreateNew(str(tmp_path / "over.usda"))
    layer.timeCodesPerSecond = rate
    layer.subLayerPaths = ["./packed.usda"]
    layer.subLayerOffsets[0] = Sdf.LayerOffset(100.0, 2.0)
    layer.Save()
    for stage in (Usd.Stage.Open(layer), Usd.Stage.Open(Usd.Stage.Open(layer).Flatten())):
        clip = read_clip(find_animations(stage)[0])
        np.testing.assert_allclose(clip.codes, 100.0 + 2.0 * np.arange(N) * rate / 24.0, rtol=1e-15)


def test_samples_over_packed_motion_count(source, tmp_path, run):
    run("pack", source, "-o", tmp_path / "packed.usda", "--tolerance", 1)
    run("upsample", tmp_path / "packed.usda", "-o", tmp_path / "up.usda", "--factor", 2)
    assert read(tmp_path / "up.usda")[0] == np.arange(0, N - 0.5, 0.5).tolist()
    assert len(motion(tmp_path / "up.usda").times) == 2 * N - 1
    layer = Sdf.Layer.CreateNew(str(tmp_path / "stranger.usda"))  # which knows nothing of packed motion
    layer.subLayerPaths = ["./packed.usda"]
    stage = Usd.Stage.Open(layer)
    set_samples(stage, "rotations", [0, 7], random_rotations(2, 3, seed=5))
    assert read_clip(find_animations(stage)[0]).channels["rotations"].codes.tolist() == [0, 7]


def test_scales_and_weights_are_packed_within_their_tolerances(tmp_path, run):
    codes = np.arange(N)
    scales = (1.0 + 0.3 * np.sin(codes[:, None, None] / 5.0 + np.arange(9).reshape(3, 3))).astype(np.float16)
    stage = make_rig(tmp_path / "in.usda", codes=codes, rotations=random_rotations(N, 3), scales=scales)
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.CreateAttribute("blendShapes", Sdf.ValueTypeNames.TokenArray).Set(["smile", "blink"])
    weights = np.stack([np.sin(codes / 4.0), np.cos(codes / 7.0)], axis=-1)
    attribute = prim.CreateAttribute("blendShapeWeights", Sdf.ValueTypeNames.FloatArray)
    for code, row in zip(codes, weights, strict=True):
        attribute.Set(Vt.FloatArray(row.tolist()), float(code))
    stage.GetRootLayer().Save()
    options = ["--tolerance", 0.5, "--weights-tolerance", 0.002]
    code, text, err = run("pack", tmp_path / "in.usda", "-o", tmp_path / "packed.usdc", *options)
    assert (code, err) == (0, "") and "blendShapeWeights" in text
    assert largest_error(tmp_path / "packed.usdc", tmp_path / "in.usda") <= 0.5
    run("unpack", tmp_path / "packed.usdc", "-o", tmp_path / "back.usda")
    off = np.abs(np.array(read(tmp_path / "back.usda", "blendShapeWeights")[1])[..., 0] - weights).max()
    assert 1e-4 < off <= 0.002
    assert np.abs(np.array(read(tmp_path / "back.usda", "scales")[1], dtype=float) - scales).max() < 2e-3


def test_faces_without_joints_are_packed(tmp_path, run, inspected):
    stage = make_rig(tmp_path / "in.usda", codes=[0], anim_joints=[], translations=None, scales=None)
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.RemoveProperty("rotations")
    prim.CreateAttribute("blendShapes", Sdf.ValueTypeNames.TokenArray).Set(["smile"])
    attribute = prim.CreateAttribute("blendShapeWeights", Sdf.ValueTypeNames.FloatArray)
    weights = np.sin(np.arange(N) / 4.0)
    for code in range(N):
        attribute.Set(Vt.FloatArray([float(weights[code])]), float(code))
    stage.GetRootLayer().Save()
    code, text, err = run("pack", tmp_path / "in.usda", "-o", tmp_path / "packed.usdc", "--tolerance", 1)
    assert (code, err) == (0, "") and "Largest error of blendShapeWeights" in text
    (told,) = inspected(tmp_path / "packed.usdc")["animations"]
    assert told["samples"] == N and f": {told['packed_bytes']} bytes" in text
    run("unpack", tmp_path / "packed.usdc", "-o", tmp_path / "back.usda")
    off = np.abs(np.array(read(tmp_path / "back.usda", "blendShapeWeights")[1])[:, 0, 0] - weights).max()
    assert 1e-4 < off <= 0.01


def test_transforms_above_the_skeleton_stay_where_it_is_asked_for(source, tmp_path, run):
    stage = Usd.Stage.Open(str(source))
    op = UsdGeom.Xformable(stage.GetPrimAtPath(SKELETON)).AddTranslateOp()
    for code in range(N):
        op.Set(Gf.Vec3d(code, 0.0, 0.0), code)
    stage.GetRootLayer().Save()
    words = ["--tolerance", 1, "--effort", "fast", "--no-xforms"]
    assert run("pack", source, "-o", tmp_path / "packed.usda", *words)[::2] == (0, "")
    stage = Usd.Stage.Open(str(tmp_path / "packed.usda"))
    kept = stage.GetAttributeAtPath(f"{SKELETON}.xformOp:translate")
    assert kept.GetTimeSamples() == list(range(N)) and kept.Get(7) == Gf.Vec3d(7.0, 0.0, 0.0)


def test_world_centimetres_count_what_is_above_the_skeleton(source, tmp_path, run):
    sizes = {}
    for factor in (1.0, 10.0):
        stage = Usd.Stage.Open(str(source))
        xform = UsdGeom.Xformable(stage.GetPrimAtPath(SKELETON))
        op = xform.GetOrderedXformOps()[0] if xform.GetOrderedXformOps() else xform.AddScaleOp()
        op.Set(Gf.Vec3f(factor))
        path = tmp_path / f"in{factor:g}.usda"
        stage.GetRootLayer().Export(str(path))
        run("pack", path, "-o", tmp_path / "out.usdc", "--tolerance", 1)
        assert 0.4 < largest_error(tmp_path / "out.usdc", path) <= 1.0
        (found,) = find_animations(Usd.Stage.Open(str(tmp_path / "out.usdc")))
        sizes[factor] = len(found.prim.GetAttribute(PACKED).Get())
    assert sizes[10.0] > 1.2 * sizes[1.0]


def test_open_stages_are_packed_and_unpacked(source):
    stage = Usd.Stage.Open(str(source))
    truth = animation_of(read_clip(find_animations(stage)[0]))
    stage.SetEditTarget(stage.GetSessionLayer())
    pack_stage(stage, PackOptions(tolerance=1.0))
    assert len(stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples()) == 2
    ours = animation_of(read_clip(find_animations(stage)[0]))
    assert world_errors(ours, truth, Markers.of_shell(truth)).max() <= 0.01
    unpack_stage(stage)
    assert stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples() == list(range(N))
    assert stage.GetPrimAtPath(ANIMATION).GetAttribute(PACKED).Get() is None


def test_files_are_the_same_bytes_each_time_and_in_place(source, tmp_path):
    for name in ("a.usdc", "b.usdc"):
        pack(source, tmp_path / name, PackOptions(tolerance=1.0))
    assert (tmp_path / "a.usdc").read_bytes() == (tmp_path / "b.usdc").read_bytes()
    before = motion(tmp_path / "a.usdc")
    result = unpack(tmp_path / "a.usdc", tmp_path / "c.usdc")
    assert result.animations[0].samples == N
    pack(tmp_path / "c.usdc", None, PackOptions(tolerance=1.0, in_place=True))
    after = motion(tmp_path / "c.usdc")
    assert np.array_equal(before.rotations, after.rotations)


def test_what_cannot_be_packed_is_refused(source, tmp_path, refuse):
    out = ["-o", tmp_path / "out.usda"]
    assert "--tolerance" in refuse("pack", source, *out, exit_code=2)
    assert "at least 2" in refuse("pack", source, *out, "--tolerance", 1, "--preview", 1, exit_code=2)
    assert refuse("unpack", source, *out) == "in.usda has no packed animation; usd_tools.pack makes files that have."
    assert "moves no skinned mesh" in refuse("pack", source, *out, "--tolerance", 1, "--measure", "skin")
    make_rig(tmp_path / "still.usda", codes=[0])
    sentence = refuse("pack", tmp_path / "still.usda", *out, "--tolerance", 1)
    assert sentence == "still.usda has no skeletal animation with at least two samples."
    make_rig(tmp_path / "loose.usda", bind=False)
    assert "no skeleton" in refuse("pack", tmp_path / "loose.usda", *out, "--tolerance", 1)
