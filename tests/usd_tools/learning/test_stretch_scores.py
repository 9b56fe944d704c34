"""Scores of a clip that is cut: every frame weighs the same, however long its stretch is."""

import json

import numpy as np
import pytest
from rigs import JOINTS, make_rig, random_rotations, set_samples

from geomstats_anim import Animation, Skeleton, interpolate, quality, uniform_keyframes

COUNT, CUT, RATE = 60, 12, 0.3


def turns():
    """Rotations, float32, small ones before the cut."""
    rotations = random_rotations(COUNT, 3, size=0.4)
    rotations[:CUT] = random_rotations(COUNT, 3, size=0.1)[:CUT]
    return rotations


def stretches():
    """Both parts of the motion, before and after the cut."""
    skeleton = Skeleton(JOINTS, [-1, 0, 1], np.tile([0.0, 0.1, 0.0], (3, 1)), np.tile([0.0, 0.0, 0.0, 1.0], (3, 1)))
    rotations = turns().astype(np.float64)
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    rest = np.tile(skeleton.rest_translations, (COUNT, 1, 1))
    whole = Animation(skeleton, np.arange(COUNT) / 24.0, rotations, rest)
    return whole.at_frames(slice(0, CUT)), whole.at_frames(slice(CUT + 1, COUNT))


def slerp_score(stretch):
    keys = uniform_keyframes(stretch.n_frames, RATE)
    return quality(interpolate(stretch.at_frames(keys), stretch.times, "slerp"), stretch)


def test_learn_weighs_stretches_by_their_frames(tmp_path, run):
    samples = list(turns())
    samples[CUT] = None
    at_rest = np.tile(np.float32([0.0, 10.0, 0.0]), (COUNT, 3, 1))
    stage = make_rig(tmp_path / "in.usda", codes=range(COUNT), translations=at_rest)
    set_samples(stage, "rotations", range(COUNT), samples)
    stage.GetRootLayer().Save()
    words = ["--rate", RATE, "--scheme", "geodesic", "--report", tmp_path / "report.json"]
    code, _, err = run("learn", tmp_path / "in.usda", "-o", tmp_path / "out.usda", *words)
    assert code == 0, err
    (metric,) = json.loads((tmp_path / "report.json").read_text())["metrics"]
    (whole,) = [score for score in metric["scores"] if score["in_sample"]]
    parts = stretches()
    frames = [part.n_frames for part in parts]
    for found, expected in (
        (whole["slerp_score"], [slerp_score(part) for part in parts]),
        (metric["provenance"]["slerp_score"], [slerp_score(part) for part in parts]),
    ):
        weighted = np.average(expected, weights=frames)
        assert abs(weighted - np.mean(expected)) > 1e-2 * weighted
        assert found == pytest.approx(weighted, rel=1e-5)
