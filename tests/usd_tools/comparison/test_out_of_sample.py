"""Rows out of sample: what the first half teaches about the second, found once more with the public functions alone."""

import json

import numpy as np
import pytest
from rigs import JOINTS, make_rig, random_rotations, set_samples

from geomstats_anim import Animation, Skeleton, interpolate, learn_metric, quality, uniform_keyframes

COUNT, RATE, CODES_PER_SECOND = 24, 0.3, 24.0


def turns(count, quiet=0):
    """Rotations, float32, small ones in the first frames."""
    rotations = random_rotations(count, 3, size=0.4)
    rotations[:quiet] = random_rotations(count, 3, size=0.1)[:quiet]
    return rotations


def motion(count, quiet=0):
    """The motion that `clip_file` writes."""
    skeleton = Skeleton(JOINTS, [-1, 0, 1], np.tile([0.0, 0.1, 0.0], (3, 1)), np.tile([0.0, 0.0, 0.0, 1.0], (3, 1)))
    rotations = turns(count, quiet).astype(np.float64)
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    translations = np.tile(skeleton.rest_translations, (count, 1, 1))
    return Animation(skeleton, np.arange(count) / CODES_PER_SECOND, rotations, translations)


def clip_file(path, count=COUNT):
    """Write a file of that motion; translations are at rest, and 10 cm long."""
    at_rest = np.tile(np.float32([0.0, 10.0, 0.0]), (count, 3, 1))
    return make_rig(path, codes=range(count), rotations=turns(count), translations=at_rest)


def compared(run, folder, *words):
    code, _, err = run("compare", folder / "in.usda", "-o", folder / "out", *words)
    assert code == 0, err
    return json.loads((folder / "out" / "results.json").read_text())["rows"]


def rebuilt_quality(animation, scheme, metric=None, kind="hyb"):
    keys = uniform_keyframes(animation.n_frames, RATE)
    return quality(interpolate(animation.at_frames(keys), animation.times, scheme, metric), animation, kind)


def test_the_second_half_is_never_learned_from(tmp_path, run):
    clip_file(tmp_path / "in.usda")
    rows = compared(run, tmp_path, "--rates", RATE, "--schemes", "geodesic-spline")
    whole = motion(COUNT)
    first, second = whole.at_frames(slice(0, COUNT // 2 + 1)), whole.at_frames(slice(COUNT // 2, COUNT))
    unseen = {row["purpose"]: row["q_hyb"] for row in rows if row["out_of_sample"]}
    assert set(unseen) == {"predict", "reconstruct"}
    of_whole = learn_metric(whole, uniform_keyframes(COUNT, RATE), scheme="geodesic-spline")
    for purpose, found in unseen.items():
        keys = uniform_keyframes(first.n_frames, RATE)
        metric = learn_metric(first, keys, purpose=purpose, scheme="geodesic-spline")
        assert found == pytest.approx(rebuilt_quality(second, "geodesic-spline", metric), rel=1e-4)
    # the second half would have taught something else
    assert unseen["reconstruct"] != pytest.approx(rebuilt_quality(second, "geodesic-spline", of_whole), rel=1e-2)


def test_every_frame_weighs_the_same_in_stretches_of_different_length(tmp_path, run):
    count, cut = 40, 8
    stage = clip_file(tmp_path / "in.usda", count)
    samples = list(turns(count, cut))
    samples[cut] = None
    set_samples(stage, "rotations", range(count), samples)
    stage.GetRootLayer().Save()
    rows = compared(run, tmp_path, "--rates", RATE, "--schemes", "slerp")
    (row,) = [row for row in rows if not row["out_of_sample"]]
    stretches = [motion(count, cut).at_frames(part) for part in (slice(0, cut), slice(cut + 1, count))]
    for kind in ("loc", "rot", "hyb"):
        values = [rebuilt_quality(stretch, "slerp", kind=kind) for stretch in stretches]
        weighted = np.average(values, weights=[stretch.n_frames for stretch in stretches])
        assert abs(weighted - np.mean(values)) > 1e-2 * weighted
        assert row[f"q_{kind}"] == pytest.approx(weighted, rel=1e-5)
