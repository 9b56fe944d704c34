"""Blend shape weights are thinned by a tolerance of their own, alone, beside joints, and beside another animation."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf, Usd, UsdSkel
from real_files import real_file
from rigs import ANIMATION, SKELETON, bits, make_rig, random_rotations, read, set_samples

from usd_tools.downsample import DownsampleOptions, downsample_stage
from usd_tools.downsampling.weights import fewest_keys
from usd_tools.metrics.attributes import read_metric

WEIGHTS = "blendShapeWeights"
FACE = "/Rig/Face"


def smooth(n_frames, n_shapes=2, seed=0):
    """Weights of smooth motion, float32, shape=[F, N, 1]."""
    rng = np.random.default_rng(seed)
    phase, speed = rng.uniform(0.0, 6.0, (2, n_shapes))
    return (0.5 + 0.5 * np.sin(speed * np.arange(n_frames)[:, None] / 8.0 + phase)).astype(np.float32)[..., None]


def add_weights(stage, codes, values, prim=ANIMATION):
    """Author weights on an animation, made if there is none."""
    animation = UsdSkel.Animation.Define(stage, prim)
    n_shapes = next(len(value) for value in values if value is not None)
    animation.CreateBlendShapesAttr([f"shape{n}" for n in range(n_shapes)])
    animation.CreateBlendShapeWeightsAttr()
    set_samples(stage, WEIGHTS, codes, values, prim)
    stage.Save()


def make_face(path, codes, values):
    """Write a file in which only weights move: a skeleton without joints, as face capture exports it."""
    stage = Usd.Stage.CreateNew(str(path))
    stage.SetDefaultPrim(UsdSkel.Root.Define(stage, "/Rig").GetPrim())
    stage.SetTimeCodesPerSecond(24)
    skeleton = UsdSkel.Skeleton.Define(stage, SKELETON).GetPrim()
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets([ANIMATION])
    add_weights(stage, codes, values)
    return path


@pytest.fixture
def there_and_back(tmp_path, run):
    """Downsample and upsample in.usda; give the report and what is said."""

    def call(*arguments, source=tmp_path / "in.usda"):
        report = tmp_path / "report.json"
        words = ["-o", tmp_path / "out.usda", "--report", report, *arguments]
        code, out, err = run("downsample", source, *words)
        assert code == 0, err
        code, _, told = run("upsample", tmp_path / "out.usda", "-o", tmp_path / "back.usda", "--times", "source")
        assert code == 0, told
        return json.loads(report.read_text()), out, err

    return call


def check_kept(source, out, back, tolerance, prim=ANIMATION):
    """Kept samples are the source's bit for bit, and all come back within the tolerance; give the kept time codes."""
    codes, values = read(source, WEIGHTS, prim)
    kept_codes, kept = read(out, WEIGHTS, prim)
    back_codes, rebuilt = read(back, WEIGHTS, prim)
    assert bits(kept) == bits([values[codes.index(code)] for code in kept_codes])
    assert (kept_codes[0], kept_codes[-1]) == (codes[0], codes[-1])
    assert set(codes) <= set(back_codes)
    for code, value in zip(codes, values, strict=True):
        found = rebuilt[back_codes.index(code)]
        assert (found is None) == (value is None)
        if value is not None:
            assert np.abs(found.astype(np.float64) - value).max() <= tolerance
    return kept_codes


def error_of(times, values, frames):
    shown = [np.interp(times, times[frames], column[frames]) for column in values.T]
    return float(np.abs(np.stack(shown, axis=-1) - values).max())


def fewest_by_trying(times, values, tolerance):
    """Count by dynamic programming over all pairs of samples."""
    counts = [1]
    for stop in range(1, len(times)):
        fits = [
            counts[start]
            for start in range(stop)
            if error_of(times[start : stop + 1], values[start : stop + 1], [0, stop - start]) <= tolerance
        ]
        counts.append(1 + min(fits))
    return counts[-1]


@given(st.integers(2, 14), st.integers(1, 3), st.integers(0, 10**6), st.sampled_from([0.0, 0.05, 0.2, 0.5, 2.0]))
def test_the_fewest_samples_are_kept(n_frames, n_shapes, seed, tolerance):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.1, 2.0, n_frames))
    values = np.cumsum(rng.uniform(-0.3, 0.3, (n_frames, n_shapes)), axis=0)
    frames = fewest_keys(times, values, tolerance)
    assert (frames[0], frames[-1]) == (0, n_frames - 1) and (np.diff(frames) > 0).all()
    assert error_of(times, values, frames) <= tolerance + 1e-12
    assert len(frames) == fewest_by_trying(times, values, tolerance)


def test_lines_need_their_ends_only():
    times = np.arange(2000.0)
    corner = np.minimum(times, 3000.0 - 2.0 * times)[:, None] * [1.0, -0.5, 0.0]
    assert fewest_keys(times, corner, 1e-6).tolist() == [0, 1000, 1999]
    assert fewest_keys(times, np.zeros((2000, 3)), 0.0).tolist() == [0, 1999]


@pytest.mark.parametrize("amount", [["--rate", ".3"], ["--keys", "2"], ["--tolerance", "1", "--measure", "skin"]])
def test_weights_alone(tmp_path, there_and_back, amount):
    make_face(tmp_path / "in.usda", range(60), smooth(60))
    report, out, err = there_and_back(*amount)
    kept = check_kept(tmp_path / "in.usda", tmp_path / "out.usda", tmp_path / "back.usda", 0.01)
    assert 2 < len(kept) < 30 and err == ""
    (animation,) = report["animations"]
    weights = animation["weights"]
    assert (weights["samples"], weights["kept_samples"], weights["tolerance"]) == (60, len(kept), 0.01)
    assert 0.0 < weights["largest_error"] <= 0.01
    assert (animation["kept_samples"], animation["kept_time_codes"], animation["joints"]) == (len(kept), kept, [])
    assert f"blendShapeWeights: {len(kept)} of 60 samples kept by --weights-tolerance 0.01" in out
    assert read_metric(Usd.Stage.Open(str(tmp_path / "out.usda")).GetPrimAtPath(ANIMATION)) is None


def test_looser_tolerances_keep_fewer(tmp_path, there_and_back):
    make_face(tmp_path / "in.usda", range(60), smooth(60, 5))
    counts = []
    for tolerance in (1e-9, 0.003, 0.01, 0.05, 2.0):
        there_and_back("--rate", ".3", "--weights-tolerance", tolerance)
        files = (tmp_path / name for name in ("in.usda", "out.usda", "back.usda"))
        counts.append(len(check_kept(*files, tolerance)))
    assert counts == sorted(counts, reverse=True) and counts[0] == 60 and counts[-1] == 2


@pytest.mark.parametrize("amount", [["--rate", ".3"], ["--tolerance", "1"]])
def test_joints_and_weights(tmp_path, there_and_back, amount):
    stage = make_rig(tmp_path / "in.usda", codes=range(40), rotations=random_rotations(40, 3))
    there_and_back(*amount, "--scheme", "slerp")
    joints = read(tmp_path / "out.usda")
    add_weights(stage, range(40), smooth(40))
    report, _, err = there_and_back(*amount, "--scheme", "slerp")
    kept = check_kept(tmp_path / "in.usda", tmp_path / "out.usda", tmp_path / "back.usda", 0.01)
    found = read(tmp_path / "out.usda")
    assert (found[0], bits(found[1])) == (joints[0], bits(joints[1]))
    assert len(kept) < 40 and kept != found[0]
    assert read(tmp_path / "back.usda")[0] == read(tmp_path / "back.usda", WEIGHTS)[0] == list(range(40))
    assert report["animations"][0]["kept_whole"] == [] and err == ""


def test_weights_that_never_change_become_a_default(tmp_path, there_and_back):
    stage = make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    add_weights(stage, range(20), np.full((20, 2, 1), 0.25, np.float32))
    report, out, _ = there_and_back("--rate", ".3", "--scheme", "slerp")
    (animation,) = report["animations"]
    assert WEIGHTS in animation["constant"] and animation["weights"] is None and WEIGHTS not in out
    for name in ("out.usda", "back.usda"):
        stage = Usd.Stage.Open(str(tmp_path / name))
        attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute(WEIGHTS)
        assert attribute.GetTimeSamples() == [] and list(attribute.Get()) == [0.25, 0.25]


def test_a_still_face_says_how_long(tmp_path, there_and_back):
    make_face(tmp_path / "in.usda", range(20), np.full((20, 2, 1), 0.25, np.float32))
    there_and_back("--rate", ".3")
    assert read(tmp_path / "out.usda", WEIGHTS)[0] == [0, 19]
    assert read(tmp_path / "back.usda", WEIGHTS)[0] == list(range(20))


def test_value_blocks_and_steps_stay(tmp_path, there_and_back):
    codes = [*range(30), 30 - 1e-3, *range(30, 50)]
    values = [np.float32([[0.02 * code]]) if code < 30 else np.float32([[1.0]]) for code in codes]
    values[12] = None
    make_face(tmp_path / "in.usda", codes, values)
    there_and_back("--rate", ".3")
    kept = check_kept(tmp_path / "in.usda", tmp_path / "out.usda", tmp_path / "back.usda", 0.01)
    assert kept == [0, 11, 12, 13, 30 - 1e-3, 30, 49]
    assert read(tmp_path / "back.usda", WEIGHTS)[0] == sorted(codes)


def test_weights_hold_at_a_cut_of_the_joints(tmp_path, there_and_back):
    moves = np.full((40, 3, 3), 10.0, np.float32)
    moves[:, 0, 0] = np.arange(40)
    moves[20:, 0, 0] += 4000.0
    stage = make_rig(tmp_path / "in.usda", codes=range(40), rotations=random_rotations(40, 3), translations=moves)
    add_weights(stage, np.arange(0.0, 39.5, 0.5), np.linspace(0.0, 1.0, 79, dtype=np.float32)[:, None, None])
    there_and_back("--rate", ".3", "--scheme", "slerp")
    kept = check_kept(tmp_path / "in.usda", tmp_path / "out.usda", tmp_path / "back.usda", 0.01)
    assert kept == [0, 19, 19.5, 20, 39]


def test_samples_too_near_for_motion_stay(tmp_path, there_and_back):
    """Were their neighbours removed, they would look like steps."""
    codes = np.arange(200) * 0.01
    make_face(tmp_path / "in.usda", codes, smooth(200))
    there_and_back("--rate", ".3")
    assert len(check_kept(tmp_path / "in.usda", tmp_path / "out.usda", tmp_path / "back.usda", 0.01)) == 200


def test_what_is_to_stay_stays(tmp_path, there_and_back):
    make_face(tmp_path / "in.usda", range(60), smooth(60))
    there_and_back("--rate", ".3", "--keep", "5,6")
    assert {5, 6} <= set(check_kept(tmp_path / "in.usda", tmp_path / "out.usda", tmp_path / "back.usda", 0.01))


def test_weights_on_another_clock(tmp_path, run, there_and_back):
    make_face(tmp_path / "face.usda", range(60), smooth(60))
    stage = Usd.Stage.CreateNew(str(tmp_path / "in.usda"))
    stage.SetTimeCodesPerSecond(24)
    stage.GetRootLayer().subLayerPaths.append("./face.usda")
    stage.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(1.0 / 3.0, 0.7)
    stage.Save()
    report, _, _ = there_and_back("--rate", ".3")
    assert report["animations"][0]["weights"]["largest_error"] <= 0.01
    assert len(read(tmp_path / "back.usda", WEIGHTS)[0]) == 60


def test_weights_of_an_open_stage(tmp_path):
    stage = Usd.Stage.Open(str(make_face(tmp_path / "in.usda", range(60), smooth(60))))
    (animation,) = downsample_stage(stage, DownsampleOptions(rate=0.3, weights_tolerance=0.02)).animations
    assert animation.weights["tolerance"] == 0.02 and 0.0 < animation.weights["largest_error"] <= 0.02
    codes = stage.GetPrimAtPath(ANIMATION).GetAttribute(WEIGHTS).GetTimeSamples()
    assert codes == list(animation.kept_time_codes) and 2 < len(codes) < 30


@pytest.mark.parametrize("measure", [[], ["--measure", "shell"]])
def test_a_face_beside_a_body(tmp_path, there_and_back, measure):
    stage = make_rig(tmp_path / "in.usda", codes=range(40), rotations=random_rotations(40, 3))
    add_weights(stage, range(60), smooth(60), FACE)
    report, _, err = there_and_back("--tolerance", "1", *measure)
    files = (tmp_path / name for name in ("in.usda", "out.usda", "back.usda"))
    assert len(check_kept(*files, 0.01, FACE)) < 60 and "left unchanged" not in err
    assert {each["prim"]: each["samples"] for each in report["animations"]} == {ANIMATION: 40, FACE: 60}
    assert read(tmp_path / "back.usda", WEIGHTS, FACE)[0] == list(range(60))
    assert read(tmp_path / "back.usda")[0] == list(range(40))


def test_a_strangers_face(tmp_path, there_and_back):
    source = real_file("strangers/face_weights_only.usda")
    report, _, err = there_and_back("--rate", ".3", source=source)
    kept = check_kept(source, tmp_path / "out.usda", tmp_path / "back.usda", 0.01, "/Root/Anim")
    assert len(kept) == report["animations"][0]["weights"]["kept_samples"] == 16 and err == ""


def test_pictures_are_of_joints(tmp_path, run, refuse):
    make_face(tmp_path / "in.usda", range(60), smooth(60))
    words = ["--rate", ".3", "-o", tmp_path / "out.usda", "--picture", tmp_path / "kept.svg"]
    assert refuse("downsample", tmp_path / "in.usda", *words) == (
        "--picture draws the motion of joints, but in.usda has blend shapes only; leave it out."
    )
    stage = make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    add_weights(stage, range(60), smooth(60), FACE)
    code, _, err = run("downsample", tmp_path / "in.usda", *words, "--scheme", "slerp")
    assert code == 0 and (tmp_path / "kept.svg").exists(), err


def test_what_is_written_is_verified(tmp_path, refuse, monkeypatch):
    make_face(tmp_path / "in.usda", range(60), smooth(60))
    monkeypatch.setattr("usd_tools.downsampling.weights.fewest_keys", lambda times, *_: np.array([0, len(times) - 1]))
    sentence = refuse("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--rate", ".3")
    assert "are rebuilt only to within" in sentence and "--weights-tolerance is 0.01" in sentence
