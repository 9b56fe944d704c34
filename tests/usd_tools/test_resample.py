"""Laws of resampled files."""

import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel
from rigs import ANIMATION, JOINTS, SKELETON, bits, make_rig, random_rotations, read, set_samples

from geomstats_anim import interpolate
from geomstats_anim import rotations as quat
from usd_tools.resample import ResampleOptions, resample, resample_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

NTSC = 30000 / 1001


def rotations_of(path):
    """Return time codes and unit rotations, float64."""
    codes, values = read(path)
    return np.array(codes), quat.normalize(np.array(values, dtype=np.float64))


@pytest.mark.parametrize("retime", [False, True])
@pytest.mark.parametrize("scheme", ["geodesic-spline", "slerp", "squad"])
@pytest.mark.parametrize(
    ("own", "fps", "count"), [(120, 30, 10), (30, 24, 32), (37.5, 60, 63), (NTSC, 30, 40), (30, NTSC, 39)]
)
def test_samples_are_on_whole_frames_and_those_of_the_curve(tmp_path, run, own, fps, count, scheme, retime):
    make_rig(tmp_path / "in.usdc", codes=range(40), rotations=random_rotations(40, 3), rate=own)
    options = ["--fps", fps, "--scheme", scheme, *(["--retime"] if retime else [])]
    code, _, err = run("resample", tmp_path / "in.usdc", "-o", tmp_path / "out.usdc", *options)
    assert (code, err) == (0, "")
    codes, values = rotations_of(tmp_path / "out.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "out.usdc"))
    if retime:
        assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == pytest.approx(fps, rel=1e-12)
        assert codes.tolist() == list(range(count))
    else:
        assert stage.GetTimeCodesPerSecond() == own
        np.testing.assert_allclose(codes, np.arange(count) * own / fps, rtol=1e-12)
    clip = read_clip(find_animations(Usd.Stage.Open(str(tmp_path / "in.usdc")))[0])
    keys = clip.keys(("rotations", "translations"), slice(None))
    expected = interpolate(keys, np.minimum(np.arange(count) / fps, keys.times[-1]), scheme)
    assert quat.distance(values, expected.rotations[:, clip.columns]).max() < 3e-7
    moved = np.array(read(tmp_path / "out.usdc", "translations")[1])
    np.testing.assert_allclose(moved, clip.to_file_units("translations", expected), rtol=2e-7)


def test_slerp_is_what_usd_shows(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 17, "--scheme", "slerp")
    codes, values = rotations_of(tmp_path / "out.usda")
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations")
    shown = quat.normalize(np.array([np.array(attribute.Get(code)) for code in codes], dtype=np.float64))
    assert len(codes) == 14 and quat.distance(values, shown).max() < 1e-6


def test_samples_on_frames_stay_bit_for_bit(tmp_path, run):
    scales = np.random.default_rng(1).uniform(0.5, 2.0, (9, 3, 3)).astype(np.float16)
    make_rig(tmp_path / "in.usda", codes=range(9), rotations=random_rotations(9, 3), scales=scales, rate=120)
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 30)
    for name in ("rotations", "translations", "scales"):
        codes, values = read(tmp_path / "out.usda", name)
        assert codes == [0, 4, 8] and bits(values) == bits(read(tmp_path / "in.usda", name)[1][::4])


def test_samples_off_frames_are_moved_onto_them(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=np.arange(8) + 0.4, rotations=random_rotations(8, 3))
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 24)
    assert read(tmp_path / "out.usda")[0] == list(range(1, 8))


def test_holds_blocks_steps_and_cuts(tmp_path, run):
    rotations = random_rotations(40, 3, size=0.2)
    rotations[10:21, 1] = rotations[10, 1]
    rotations[25:] = quat.multiply(rotations[25:].astype(float), quat.exp(np.array([0.0, 2.5, 0.0])))
    values = list(rotations)
    values[30] = None
    make_rig(tmp_path / "in.usda", codes=range(40), rotations=values, translations=None)
    _, _, err = run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 60)
    assert "from time code 24 to 25" in err
    codes, dense = read(tmp_path / "out.usda")
    by_code = dict(zip(np.round(np.array(codes) / 0.4).astype(int).tolist(), dense, strict=True))
    assert {by_code[k][1].tobytes() for k in range(25, 51)} == {rotations[10, 1].tobytes()}
    assert {by_code[k].tobytes() for k in (60, 61, 62)} == {rotations[24].tobytes()}  # time codes 24 to 24.8
    assert by_code[75] is None and by_code[78] is not None  # 30 and 31.2; a block lasts until the next sample
    assert not {76, 77} & set(by_code)


def test_weights_and_transforms_are_sampled_too(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=(0, 8, 16), joints=["a"], translations=None)
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["smile"])
    set_samples(stage, "blendShapeWeights", (0, 16), np.float32([[[0]], [[1]]]))
    move = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for code in (0, 16, 32):
        move.Set(Gf.Vec3d(code, 0, 0), code)
    stage.Save()
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 6)
    assert read(tmp_path / "out.usda")[0] == [0, 4, 8, 12, 16]
    codes, weights = read(tmp_path / "out.usda", "blendShapeWeights")
    assert codes == [0, 4, 8, 12, 16] and np.array(weights)[:, 0, 0].tolist() == [0, 0.25, 0.5, 0.75, 1]
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    moved = stage.GetPrimAtPath("/Rig").GetAttribute("xformOp:translate")
    assert moved.GetTimeSamples() == list(range(0, 33, 4))
    np.testing.assert_allclose([moved.Get(code)[0] for code in range(0, 33, 4)], range(0, 33, 4), atol=1e-12)
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 6, "--no-xforms")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert stage.GetPrimAtPath("/Rig").GetAttribute("xformOp:translate").GetTimeSamples() == [0, 16, 32]


def shaken_rig(path, hertz, size=0.05):
    """Write a slow motion at 120 samples per second that is shaken; return what is slow: rotations, moves, root."""
    seconds = np.arange(481) / 120
    shake = np.sin(2 * np.pi * hertz * seconds)[:, None]
    turns = np.stack([np.sin(2 * seconds + phase) for phase in range(3)], axis=-1)
    slow = quat.exp(np.stack([turns, 0.7 * turns, -turns], axis=1))
    path_of_root = np.stack([3.0 * seconds, np.sin(seconds), 0.0 * seconds], axis=-1)
    shaken = quat.multiply(slow, quat.exp((size * shake * [0.6, 0.0, 0.8])[:, None]))
    moves = np.tile(path_of_root[:, None], (1, 3, 1))
    stage = make_rig(path, range(481), shaken.astype(np.float32), moves + size * shake[:, None], rate=120)
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for code, point in enumerate(path_of_root + size * shake):
        op.Set(Gf.Vec3d(*point.tolist()), code)
    stage.Save()
    return slow, moves, path_of_root


def loss(values, expected, size):
    """Return how far values are from what is expected, in decibels of a shake of some size; ends left out."""
    error = np.linalg.norm(values - expected, axis=-1)[10:-10]
    return 20.0 * np.log10(np.sqrt((error**2).mean()) / (size / np.sqrt(2.0)))


@pytest.mark.parametrize("hertz", [15.0, 17.0, 29.0, 43.0, 58.0])
def test_antialias_takes_what_is_too_fast_for_the_new_rate(tmp_path, run, hertz):
    slow, moves, root = shaken_rig(tmp_path / "in.usdc", hertz)
    losses = {}
    for words in ([], ["--antialias"]):
        run("resample", tmp_path / "in.usdc", "-o", tmp_path / "out.usdc", "--fps", 30, *words)
        codes, turned = rotations_of(tmp_path / "out.usdc")
        assert codes.tolist() == list(range(0, 481, 4))
        moved = np.array(read(tmp_path / "out.usdc", "translations")[1])
        stage = Usd.Stage.Open(str(tmp_path / "out.usdc"))
        attribute = stage.GetPrimAtPath("/Rig").GetAttribute("xformOp:translate")
        placed = np.array([attribute.Get(code) for code in codes])
        losses[bool(words)] = [
            loss(quat.difference(slow[::4], turned), 0.0, 0.05),
            loss(moved, moves[::4], 0.05 * np.sqrt(3.0)),
            loss(placed, root[::4], 0.05 * np.sqrt(3.0)),
        ]
    assert max(losses[True]) < -20.0
    if hertz != 15.0:  # whose samples at 30 per second may be all zeros
        assert min(losses[False]) > -3.0


def test_antialias_leaves_what_is_slow_and_what_is_still(tmp_path, run):
    slow, _, _ = shaken_rig(tmp_path / "in.usdc", 1.0, size=0.0)
    rotations = slow.astype(np.float32)
    rotations[:, 2] = [0.1, 0.2, 0.3, 0.9]  # not of unit length: stays so
    make_rig(tmp_path / "still.usdc", range(481), rotations, rate=120)
    run("resample", tmp_path / "still.usdc", "-o", tmp_path / "out.usdc", "--fps", 24, "--antialias")
    _, values = read(tmp_path / "out.usdc")
    assert {value[2].tobytes() for value in values} == {rotations[0, 2].tobytes()}
    _, turned = rotations_of(tmp_path / "out.usdc")
    assert quat.distance(turned, quat.normalize(rotations[::5].astype(float)))[:, :2].max() < 2e-3


def test_antialias_ends_at_cuts(tmp_path, run):
    rotations = quat.exp(0.3 * np.sin(np.arange(360).reshape(120, 3, 1) / 60) * [0.0, 0.6, 0.8])
    rotations[60:] = quat.multiply(rotations[60:], quat.exp(np.array([2.0, 0.0, 0.0])))
    make_rig(tmp_path / "in.usda", range(120), rotations.astype(np.float32), rate=120)
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 30, "--antialias")
    _, turned = rotations_of(tmp_path / "out.usda")
    assert quat.distance(turned, rotations[::4]).max() < 0.01
    smeared = tmp_path / "smeared.usda"
    run("resample", tmp_path / "in.usda", "-o", smeared, "--fps", 30, "--antialias", "--no-cuts")
    assert quat.distance(rotations_of(smeared)[1], rotations[::4]).max() > 0.3


def test_nothing_to_filter_is_a_warning_and_uneven_samples_an_error(tmp_path, run, refuse):
    make_rig(tmp_path / "in.usda", codes=range(9), rotations=random_rotations(9, 3))
    _, _, err = run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 24, "--antialias")
    assert err == (
        f"warning: {ANIMATION} has 24 samples per second, no more than --fps 24, so there is nothing for --antialias "
        "to filter.\n"
    )
    assert bits(read(tmp_path / "out.usda")[1]) == bits(read(tmp_path / "in.usda")[1])
    make_rig(tmp_path / "uneven.usda", codes=(0, 1, 2, 4, 5), rotations=random_rotations(5, 3))
    sentence = refuse("resample", tmp_path / "uneven.usda", "-o", tmp_path / "x.usda", "--fps", 12, "--antialias")
    assert sentence == (
        f"{ANIMATION}: rotations is not evenly sampled, so --antialias cannot filter it; resample it with --fps 24 "
        "first."
    )


def test_what_cannot_be_done_is_refused(tmp_path, refuse):
    make_rig(tmp_path / "in.usda")
    call = ["resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda"]
    assert refuse(*call, "--fps", 2) == f"{ANIMATION} is 0.125 seconds long, too short for two frames at --fps 2."
    assert "would create" in refuse(*call, "--fps", "1e12")
    assert refuse("resample", tmp_path / "in.usda", "--fps", 12, exit_code=2).startswith("name the output")
    assert "--fps" in refuse(*call, exit_code=2)
    in_place = ["resample", tmp_path / "in.usda", "--fps", 30, "--in-place", "--retime"]
    assert refuse(*in_place) == "--retime cannot change a file in place; name another file with --out."


def test_in_place_flattened_and_same_bytes(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(9), rotations=random_rotations(9, 3))
    contents = []
    for name in ("a", "b"):
        run("resample", tmp_path / "in.usda", "-o", tmp_path / f"{name}.usda", "--fps", 12, "--flatten", "--retime")
        contents.append((tmp_path / f"{name}.usda").read_bytes())
    assert contents[0] == contents[1]
    run("resample", tmp_path / "in.usda", "--fps", 12, "--in-place")
    assert read(tmp_path / "in.usda")[0] == [0, 2, 4, 6, 8]
    assert read(tmp_path / "a.usda")[0] == [0, 1, 2, 3, 4]


def test_a_rebuilt_sparse_file_no_longer_names_the_samples_of_its_source(tmp_path, run, inspected):
    make_rig(tmp_path / "in.usda", codes=range(40), rotations=random_rotations(40, 3))
    slerp = ["--select", "uniform", "--scheme", "slerp"]
    run("downsample", tmp_path / "in.usda", "-o", tmp_path / "sparse.usda", "--keys", 20, *slerp)
    assert inspected(tmp_path / "sparse.usda")["animations"][0]["samples_of_source"] == 40
    run("resample", tmp_path / "sparse.usda", "-o", tmp_path / "out.usda", "--fps", 12)
    animation = inspected(tmp_path / "out.usda")["animations"][0]
    assert animation["samples_of_source"] is None and animation["samples"] == 20
    run("resample", tmp_path / "sparse.usda", "-o", tmp_path / "all.usda", "--fps", 24)
    assert len(read(tmp_path / "all.usda")[0]) == 40


def test_report_and_functions(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(9), rotations=random_rotations(9, 3))
    run("resample", tmp_path / "in.usda", "--fps", 12, "--dry-run", "--report", tmp_path / "report.json")
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["tool"] == "usd_tools.resample" and report["settings"] == {"fps": 12.0}
    assert (report["animations"][0]["samples_before"], report["animations"][0]["samples_after"]) == (9, 5)
    result = resample(tmp_path / "in.usda", tmp_path / "out.usda", ResampleOptions(fps=12, antialias=True))
    assert result.path == tmp_path / "out.usda" and result.animations[0].rate_after == 12
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    stage.SetEditTarget(stage.GetSessionLayer())
    assert resample_stage(stage, ResampleOptions(fps=12)).animations[0].samples_after == 5
    assert stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations").GetTimeSamples() == [0, 2, 4, 6, 8]
    assert Sdf.Layer.FindOrOpen(str(tmp_path / "in.usda")).GetPrimAtPath(SKELETON) and JOINTS
