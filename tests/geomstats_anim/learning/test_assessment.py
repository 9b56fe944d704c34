"""What a metric is said to be worth: the names, what is in-sample, and the verdicts."""

from dataclasses import replace

import numpy as np
import pytest
from wanderings import N_JOINTS, metric, noise, of_vectors, wandering

from geomstats_anim import LearnedMetric, MetricParameters, interpolate, learn_metric, quality, uniform_keyframes
from geomstats_anim.learned_metric import Score
from geomstats_anim.learning.assessment import assess, score


def learned(animation, parameters, kind="hyb"):
    return LearnedMetric(animation.skeleton.joints, parameters, quality=kind)


def never(animation, keyframes):
    raise AssertionError("this is too short to learn from its half")


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (0.9, "beats slerp"),
        (0.9949, "beats slerp"),
        (0.9951, "ties with slerp"),
        (1.0, "ties with slerp"),
        (1.0049, "ties with slerp"),
        (1.0051, "loses to slerp"),
        (2.0, "loses to slerp"),
    ],
)
def test_verdicts(value, verdict):
    for unit in (1e-3, 1.0, 50.0):
        result = Score("what", True, value * unit, unit, unit)
        assert result.verdict == verdict
        assert result.gain == pytest.approx(1.0 - value)


def test_where_slerp_is_perfect_there_is_nothing_to_gain():
    assert Score("what", True, 0.0, 0.0, 0.0).verdict == "ties with slerp"


@pytest.mark.parametrize("kind", ["loc", "rot", "hyb"])
@pytest.mark.parametrize("weights", [None, "depth"])
def test_a_score_is_the_quality_of_both(kind, weights):
    truth, parameters = wandering(), metric()
    keys = uniform_keyframes(41, 0.2)
    result = score("what", False, truth, keys, learned(truth, parameters, kind), weights)
    for value, scheme in ((result.learned, "geodesic"), (result.slerp, "slerp")):
        used = parameters if scheme == "geodesic" else None
        rebuilt = interpolate(truth.at_frames(keys), truth.times, scheme, used)
        assert value == quality(rebuilt, truth, kind, weights)
    assert (result.what, result.in_sample) == ("what", False)


def test_names_and_what_is_in_sample():
    truth, calls = wandering(n_frames=101), []

    def learn(animation, keyframes):
        calls.append((animation, keyframes))
        return learned(animation, metric(1))

    scores = assess(truth, 0.3, learned(truth, metric(2)), learn)
    assert [(one.what, one.in_sample) for one in scores] == [
        ("learned and scored at rate 0.3", True),
        ("learned on the first half, scored on the second", False),
        ("learned at rate 0.3, scored at rate 0.2", False),
        ("learned at rate 0.3, scored at rate 0.45", False),
    ]
    [(half, keys)] = calls
    np.testing.assert_array_equal(half.times, truth.times[:51])
    np.testing.assert_array_equal(keys, uniform_keyframes(51, 0.3))
    second = truth.at_frames(slice(50, 101))
    assert scores[1] == score(scores[1].what, False, second, uniform_keyframes(51, 0.3), learned(truth, metric(1)))


@pytest.mark.parametrize(
    ("n_frames", "rate", "rates"),
    [(6, 0.3, []), (8, 0.3, ["0.45"]), (18, 0.3, ["0.2", "0.45"]), (20, 0.1, ["0.15"]), (12, 0.6, ["0.4"])],
)
def test_what_is_too_short_is_left_out(n_frames, rate, rates):
    truth = wandering(n_frames=n_frames)
    metric_here = learned(truth, metric())
    halves_can_be_learned = (n_frames + 1) // 2 * rate >= 3
    scores = assess(truth, rate, metric_here, (lambda *_: metric_here) if halves_can_be_learned else never)
    others = [one.what for one in scores[1:] if "half" not in one.what]
    assert others == [f"learned at rate {rate:g}, scored at rate {other}" for other in rates]
    assert any("half" in one.what for one in scores) == halves_can_be_learned


def test_a_metric_that_loses_says_so():
    """Fitted to noise, it gains where it was learned, and loses where it was not."""
    truth = noise(n_frames=81)

    def learn(animation, keyframes):
        return learn_metric(animation, keyframes, scheme="geodesic")

    scores = assess(truth, 0.3, learn(truth, uniform_keyframes(81, 0.3)), learn)
    assert scores[0].verdict == "beats slerp"
    assert scores[1].verdict == "loses to slerp"
    assert scores[1].gain < 0.0


def test_the_identity_ties_everywhere():
    truth = wandering(n_frames=61)
    spline = replace(LearnedMetric.plain(truth.skeleton.joints, "geodesic-spline"), quality="hyb")
    assert {one.verdict for one in assess(truth, 0.3, spline, lambda *_: spline)} == {"ties with the plain spline"}
    # without a metric nobody would use slerp
    identity = learned(truth, MetricParameters.identity(N_JOINTS))
    scores = assess(truth, 0.3, identity, lambda *_: identity)
    assert {one.verdict for one in scores} == {"loses to the plain spline"}
    assert all(one.learned == pytest.approx(one.slerp) and one.plain < one.slerp for one in scores)


def test_a_clip_that_slerp_rebuilds_ties():
    """Both scores are rounding errors, which are no reason to praise or to blame."""
    vectors = np.linspace(0.0, 1.0, 41)[:, None, None] * np.random.default_rng(0).normal(size=(N_JOINTS, 3))
    truth = of_vectors(vectors)
    for kind in ("loc", "rot", "hyb"):
        identity = learned(truth, MetricParameters.identity(N_JOINTS), kind)
        assert {one.verdict for one in assess(truth, 0.3, identity, lambda *_, same=identity: same)} == {
            "ties with slerp"
        }


def test_a_first_half_that_does_not_move_is_left_out():
    truth = wandering(n_frames=81)
    vectors = 0.3 * np.random.default_rng(0).normal(size=(81, N_JOINTS, 3))
    vectors[:50] = vectors[50]
    truth = of_vectors(vectors)
    scores = assess(truth, 0.3, learned(truth, metric()), learn_metric)
    assert [one.in_sample for one in scores][0]
    assert not any("half" in one.what for one in scores)
