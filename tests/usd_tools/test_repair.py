"""Laws of repaired files: what is found is rebuilt on the spline, everything else stays bit for bit."""

import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom
from real_files import real_file
from rigs import ANIMATION, bits, make_rig, read, set_samples

from geomstats_anim import Animation, Skeleton, interpolate
from geomstats_anim import rotations as quat
from usd_tools.repair import RepairOptions, repair, repair_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

N = 60


def swinging(seed=0):
    """Rotations of three joints that swing about once a second, float32."""
    rng = np.random.default_rng(seed)
    phase, speed = rng.uniform(0.0, 6.0, (3, 3)), rng.uniform(0.15, 0.3, (3, 3))
    return quat.exp(0.5 * np.sin(speed * np.arange(N)[:, None, None] + phase)).astype(np.float32)


def turned(values, start, stop, joint, degrees=120.0):
    turn = quat.exp(np.radians(degrees) * np.array([[0.0, 0.6, 0.8]]))
    values[start:stop, joint] = quat.multiply(
        values[start:stop, joint].astype(np.float64), np.repeat(turn, stop - start, axis=0)
    )


def faulty(seed=0):
    """Rotations of three joints with a fault of each kind, and which samples are of faults."""
    clean = swinging(seed)
    values, bad = clean.copy(), np.zeros((N, 3), dtype=bool)
    values[10:13, 0] = np.nan
    values[20:22, 1] = 0.0
    turned(values, 30, 32, 2)
    values[40:46, 1] = values[39, 1]
    bad[10:13, 0] = bad[20:22, 1] = bad[30:32, 2] = bad[40:46, 1] = True
    return clean, values, bad


def spline_through(values, good, joint, codes=None, rate=24.0):
    """Rotations of a joint on the spline through its good samples, at all samples between the first and the last."""
    times = (np.arange(len(values)) if codes is None else np.asarray(codes)) / rate
    one = Skeleton(["joint"], [-1], np.zeros((1, 3)), [[0.0, 0.0, 0.0, 1.0]])
    keys = quat.normalize(values[good, joint : joint + 1].astype(np.float64))
    keys = quat.make_continuous(keys)
    return interpolate(Animation(one, times[good], keys, np.zeros((good.sum(), 1, 3))), times).rotations[:, 0]


def repaired(path, name="rotations"):
    return np.array(read(path, name)[1])


def check(clean, values, bad, after, codes=None):
    """Check that good samples are bit for bit, and bad ones on the spline through them."""
    assert bits(after[~bad]) == bits(values[~bad])
    for joint in range(values.shape[1]):
        expected = spline_through(values, ~bad[:, joint], joint, codes)
        found = quat.normalize(after[:, joint].astype(np.float64))
        assert quat.distance(found, expected)[bad[:, joint]].max(initial=0.0) < 3e-7


@pytest.mark.parametrize("extension", ["usda", "usdc", "usdz"])
def test_faults_are_rebuilt_and_all_else_is_bit_for_bit(tmp_path, run, extension):
    clean, values, bad = faulty()
    make_rig(tmp_path / "in.usda", codes=range(N), rotations=values)
    code, out, err = run("repair", tmp_path / "in.usda", "-o", tmp_path / f"out.{extension}")
    assert (code, err) == (0, "")
    assert "60 samples, 3 joints; 2 gaps, 1 spike, 1 drop-out" in out
    after = repaired(tmp_path / f"out.{extension}")
    check(clean, values, bad, after)
    step = quat.distance(*(quat.normalize(clean[part].astype(float)) for part in (slice(1, None), slice(-1)))).max()
    error = quat.distance(quat.normalize(after.astype(float)), quat.normalize(clean.astype(float)))
    assert error.max() < step  # of the longest, six samples
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "out.usda")) if extension == "usda" else None
    if layer is not None:  # what has no fault is left to composition
        assert [each.name for each in layer.GetPrimAtPath(ANIMATION).attributes] == ["rotations"]
    code, out, err = run("repair", tmp_path / f"out.{extension}", "--dry-run")
    assert (code, err) == (0, "") and "no faults" in out


def test_uneven_time_codes_cuts_blocks_and_ends(tmp_path, run):
    codes = np.cumsum(np.tile([1.0, 0.5, 1.0, 1.5], 15))
    joints = [f"root/joint{k}" if k else "root" for k in range(9)]
    clean = np.concatenate([swinging(seed) for seed in range(3)], axis=1)
    clean[30:] = quat.multiply(clean[30:].astype(float), np.broadcast_to(quat.exp(np.array([0, 2.5, 0.0])), (30, 9, 4)))
    values, bad = clean.copy(), np.zeros((N, 9), dtype=bool)
    for start, stop, joint in ((0, 2, 0), (28, 30, 1), (30, 31, 2), (57, 60, 2)):
        values[start:stop, joint] = np.nan
        bad[start:stop, joint] = True
    samples = list(values)
    samples[45] = None
    make_rig(tmp_path / "in.usda", codes=codes, rotations=samples, joints=joints)
    code, out, err = run("repair", tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    assert (code, err) == (0, "") and "4 gaps" in out
    written, after = read(tmp_path / "out.usda")
    assert written == codes.tolist() and after[45] is None
    after[45] = samples[45] = values[45]
    after = np.array(after)
    assert bits(after[~bad]) == bits(values[~bad])
    for start, stop, joint, nearest in ((0, 2, 0, 2), (28, 30, 1, 27), (30, 31, 2, 31), (57, 60, 2, 56)):
        held = np.repeat(values[nearest : nearest + 1, joint], stop - start, axis=0)  # across a cut nothing is known
        assert quat.distance(quat.normalize(after[start:stop, joint].astype(float)), held.astype(float)).max() < 1e-3


def test_translations_scales_and_weights(tmp_path, run):
    rng = np.random.default_rng(0)
    path = np.zeros((N, 3, 3), dtype=np.float32) + [0.0, 10.0, 0.0]
    path[:, 0] = np.stack([np.linspace(0, 90, N), 5 * np.sin(np.arange(N) / 5), np.zeros(N)], axis=-1)
    scales = rng.uniform(0.9, 1.1, (N, 3, 3)).astype(np.float16)
    weights = np.linspace(0, 1, N, dtype=np.float32)[:, None, None]
    broken = [each.copy() for each in (path.astype(np.float32), scales, weights)]
    broken[0][20:22, 0] += [0.0, 40.0, 0.0]
    broken[0][40:48, 0] = broken[0][39, 0]
    broken[1][30, 2] = np.inf
    broken[2][10:13] = np.nan
    stage = make_rig(tmp_path / "in.usdc", codes=range(N), rotations=swinging(), translations=broken[0])
    stage.GetPrimAtPath(ANIMATION).GetAttribute("scales").Clear()
    set_samples(stage, "scales", range(N), broken[1])
    stage.GetPrimAtPath(ANIMATION).GetAttribute("blendShapes").Set(["smile"])
    stage.GetPrimAtPath(ANIMATION).CreateAttribute("blendShapeWeights", Sdf.ValueTypeNames.FloatArray, False)
    set_samples(stage, "blendShapeWeights", range(N), broken[2])
    stage.Save()
    code, out, err = run(
        "repair", tmp_path / "in.usdc", "-o", tmp_path / "out.usdc", "--report", tmp_path / "report.json"
    )
    assert (code, err) == (0, "") and "2 gaps, 1 spike, 1 drop-out" in out
    assert bits(read(tmp_path / "out.usdc")[1]) == bits(read(tmp_path / "in.usdc")[1])
    moved = repaired(tmp_path / "out.usdc", "translations")
    np.testing.assert_allclose(moved, path, atol=0.2)  # the spline's own error over eight samples
    scaled = repaired(tmp_path / "out.usdc", "scales").astype(float)
    np.testing.assert_allclose(scaled[30, 2], 0.5 * (scales[29, 2].astype(float) + scales[31, 2]), atol=1e-3)
    weighed = repaired(tmp_path / "out.usdc", "blendShapeWeights")
    np.testing.assert_allclose(weighed, weights, atol=1e-6)
    (animation,) = json.loads((tmp_path / "report.json").read_text())["animations"]
    words = ("channel", "kind", "joint", "start", "end")
    faults = {tuple(each[word] for word in words) for each in animation["faults"]}
    assert faults == {
        ("translations", "spike", "hips", 20, 21),
        ("translations", "drop-out", "hips", 40, 47),
        ("scales", "gap", "hips/spine/arm", 30, 30),
        ("blendShapeWeights", "gap", "smile", 10, 12),
    }
    (spike,) = (each for each in animation["faults"] if each["kind"] == "spike")
    assert spike["centimetres"] == pytest.approx(40.0, abs=1.0) and spike["degrees"] is None


def test_signs_are_made_continuous_by_changing_as_few_as_can_be(tmp_path, run):
    values = swinging()
    flipped = values.copy()
    flipped[7] *= -1.0
    flipped[50:, 2] *= -1.0
    make_rig(tmp_path / "in.usda", codes=range(N), rotations=flipped)
    code, out, err = run("repair", tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    assert (code, err) == (0, "") and "4 sign flips" in out and "Signs made continuous: arm, hips, spine." in out
    assert bits(repaired(tmp_path / "out.usda")) == bits(values)


def test_what_is_longer_than_max_gap_is_named_and_left(tmp_path, run):
    values = swinging()
    values[10:15, 0], values[30:32, 0] = np.nan, 0.0
    make_rig(tmp_path / "in.usda", codes=range(N), rotations=values)
    code, out, err = run("repair", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--max-gap", 4)
    assert code == 0 and "gap, left" in out
    assert err == (
        f"warning: {ANIMATION}: 1 fault of up to 5 samples left as they are; --max-gap rebuilds longer ones.\n"
    )
    after = repaired(tmp_path / "out.usda")
    assert np.isnan(after[10:15, 0]).all() and np.isfinite(after[30:32]).all()
    expected = spline_through(values, ~np.isin(np.arange(N), [*range(10, 15), 30, 31]), 0)
    assert quat.distance(quat.normalize(after[30:32, 0].astype(float)), expected[30:32]).max() < 3e-7
    run("repair", tmp_path / "in.usda", "-o", tmp_path / "smooth.usda", "--max-gap", 4, "--smooth", 6)
    assert (np.isnan(repaired(tmp_path / "smooth.usda")) == np.isnan(after)).all()


def test_smoothing_takes_noise_away_and_keeps_the_motion(tmp_path, run):
    rate, seconds = 120.0, np.arange(481) / 120.0
    slow = quat.exp(0.8 * np.sin(2.0 * np.pi * 0.5 * seconds)[:, None, None] * np.eye(3))
    shake = quat.exp(0.05 * np.sin(2.0 * np.pi * 30.0 * seconds)[:, None, None] * np.eye(3)[::-1])
    shaken = quat.multiply(slow, shake).astype(np.float32)
    make_rig(tmp_path / "in.usdc", codes=range(481), rotations=shaken, rate=rate, translations=None)
    code, out, err = run("repair", tmp_path / "in.usdc", "-o", tmp_path / "out.usdc", "--smooth", 6)
    assert code == 0 and "filtered: rotations" in out
    after = quat.normalize(repaired(tmp_path / "out.usdc").astype(float))
    error = quat.distance(after, slow)[10:-10]
    assert error.max() < 0.05 * 10 ** (-30.0 / 20.0)
    code, _, err = run("repair", tmp_path / "in.usdc", "-o", tmp_path / "no.usdc", "--smooth", 60)
    assert code == 1 and err.endswith(
        f"error: {ANIMATION} has 120 samples per second, so --smooth must be below 60 hertz.\n"
    )
    assert not (tmp_path / "no.usdc").exists()


def test_packed_motion_is_repaired(tmp_path, run):
    values = swinging()
    turned(values, 30, 31, 2)
    make_rig(tmp_path / "in.usda", codes=range(N), rotations=values)
    assert run("pack", tmp_path / "in.usda", "-o", tmp_path / "packed.usdc", "--tolerance", 0.01)[0] == 0
    code, out, _ = run("repair", tmp_path / "packed.usdc", "-o", tmp_path / "out.usdc")
    assert code == 0 and "1 spike" in out
    codes, after = read(tmp_path / "out.usdc")
    expected = spline_through(values, np.arange(N) != 30, 2)
    assert codes == list(range(N)) and quat.distance(quat.normalize(after[30][2].astype(float)), expected[30]) < 2e-3


def test_stages_dry_runs_and_what_is_not_found(tmp_path, run):
    clean, values, bad = faulty()
    stage = make_rig(tmp_path / "in.usda", codes=range(N), rotations=values)
    before = (tmp_path / "in.usda").read_bytes()
    stage.SetEditTarget(stage.GetSessionLayer())
    assert repair_stage(stage, RepairOptions(dry_run=True)).brief == "2 gaps, 1 spike, 1 drop-out"
    assert stage.GetSessionLayer().empty
    repair_stage(stage, RepairOptions())
    after = np.array([np.array(stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").Get(k)) for k in range(N)])
    check(clean, values, bad, after)
    code, out, err = run("repair", tmp_path / "in.usda", "--dry-run")
    assert (code, err) == (0, "") and out.endswith("Dry run: nothing was written.\n")
    assert (tmp_path / "in.usda").read_bytes() == before
    assert run("repair", tmp_path / "in.usda")[0] == 2
    values[:, 1] = np.nan
    make_rig(tmp_path / "lost.usda", codes=range(N), rotations=values)
    code, _, err = run("repair", tmp_path / "lost.usda", "-o", tmp_path / "out.usda")
    assert code == 1 and "of joint spine have no sample that is a number" in err


def test_sparse_keys_are_not_doubted(tmp_path, run):
    """Keys that are far apart may leave and come back; so may those that downsample left."""
    values = swinging()[:20]
    turned(values, 9, 10, 1)
    make_rig(tmp_path / "in.usda", codes=np.arange(20) * 3.0, rotations=values)
    assert repair(tmp_path / "in.usda", None, RepairOptions(dry_run=True)).brief == "no faults"


def test_several_files(tmp_path, run):
    (tmp_path / "in").mkdir()
    for k in range(2):
        make_rig(tmp_path / "in" / f"{k}.usda", codes=range(N), rotations=faulty(k)[1])
    code, out, err = run("repair", tmp_path / "in", "-o", tmp_path / "out", "--dry-run")
    assert (code, err) == (0, "") and out.endswith("Worked on 2 files.\n")
    code, out, err = run("repair", tmp_path / "in", "-o", tmp_path / "out")
    assert (code, err) == (0, "") and "0.usda: 2 gaps, 1 spike, 1 drop-out" in out
    assert np.isfinite(repaired(tmp_path / "out" / "1.usda")).all()


def test_inspect_lists_what_repair_would_do(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(N), rotations=faulty()[1])
    code, out, err = run("inspect", tmp_path / "in.usda")
    assert code == 0 and "2 gaps, 1 spike, 1 drop-out" in out and "usd_tools.repair rebuilds them." in out
    assert err.endswith(
        f"warning: {ANIMATION} has 2 gaps from time code 10 on, which other commands refuse; usd_tools.repair fills "
        "them in.\n"
    )
    listed = json.loads(run("inspect", tmp_path / "in.usda", "--json")[1])["animations"][0]["faults"]
    report = repair(tmp_path / "in.usda", None, RepairOptions(dry_run=True)).faults
    assert listed == [{name: value for name, value in each.items() if name != "repaired"} for each in report]
    (tmp_path / "folder").mkdir()
    make_rig(tmp_path / "folder" / "a.usda", codes=range(N), rotations=faulty()[1])
    assert ',"2 gaps, 1 spike, 1 drop-out",' in run("inspect", tmp_path / "folder", "--csv")[1]


def test_hand_keyed_clips_have_no_faults():
    for name in ("punching", "sitting"):
        result = repair(real_file(f"clips/{name}.usda"), None, RepairOptions(dry_run=True))
        assert [each for each in result.faults if each["kind"] != "sign flip"] == []


def test_the_flipped_thumb_of_rolling_is_rebuilt(tmp_path):
    source = real_file("clips/rolling.usda")
    repair(source, tmp_path / "out.usdc", RepairOptions())
    stage = Usd.Stage.Open(str(tmp_path / "out.usdc"))
    clip = read_clip(find_animations(stage)[0])
    values = quat.normalize(clip.channels["rotations"].values.astype(np.float64))
    thumb = [joint.rpartition("/")[2] for joint in clip.joints].index("RThumb")
    assert np.degrees(quat.distance(values[1:, thumb], values[:-1, thumb])).max() < 45.0


def test_transforms_that_move_the_character(tmp_path, run):
    path = np.stack([2.0 * np.arange(N), 3.0 * np.sin(np.arange(N) / 6.0), np.zeros(N)], axis=-1)
    broken = path.copy()
    broken[10:12], broken[-1] = np.nan, np.nan
    broken[25, 1] += 60.0
    broken[40:46] = broken[39]
    stage = make_rig(tmp_path / "in.usda", codes=range(N), rotations=swinging())
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for code in range(N):
        op.Set(Gf.Vec3d(*broken[code].tolist()), code)
    stage.GetRootLayer().Save()
    code, out, err = run("repair", tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    assert (code, err) == (0, "") and "2 gaps, 1 spike, 1 drop-out" in out and "/Rig (xformOp:translate)" in out
    out = Usd.Stage.Open(str(tmp_path / "out.usda"))
    moved = out.GetAttributeAtPath("/Rig.xformOp:translate")
    after = np.array([moved.Get(code) for code in range(N)])
    bad = np.isin(np.arange(N), [10, 11, 25, *range(40, 46), N - 1])
    assert moved.GetTimeSamples() == list(range(N)) and (after[~bad] == path[~bad]).all()
    np.testing.assert_allclose(after[:-1], path[:-1], atol=0.05)
    assert (after[-1] == path[-2]).all()
    assert "2 gaps, 1 spike, 1 drop-out" in run("inspect", tmp_path / "in.usda")[1]
    code, out, _ = run("repair", tmp_path / "in.usda", "-o", tmp_path / "kept.usda", "--no-xforms")
    assert code == 0 and "no faults" in out
    sentence = "at time code 10 it is not finite; usd_tools.repair fills it in."
    assert sentence in run("upsample", tmp_path / "in.usda", "-o", tmp_path / "up.usda", "--factor", 2)[2]


def test_weights_without_any_number_do_not_keep_the_joints_from_it(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=range(N), rotations=faulty()[1])
    stage.GetPrimAtPath(ANIMATION).GetAttribute("blendShapes").Set(["smile", "frown"])
    set_samples(stage, "blendShapeWeights", range(N), np.tile([[np.nan], [0.5]], (N, 1, 1)).astype(np.float32))
    stage.Save()
    code, out, err = run("repair", tmp_path / "in.usda", "-o", tmp_path / "out.usda")
    assert code == 0 and "2 gaps, 1 spike, 1 drop-out" in out
    assert err == (
        f"warning: {ANIMATION}: blendShapeWeights have no number for a shape; the weights are left as they are.\n"
    )
    assert np.isnan(repaired(tmp_path / "out.usda", "blendShapeWeights")[:, 0]).all()
