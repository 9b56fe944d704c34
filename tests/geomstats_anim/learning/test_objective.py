"""What learning minimises: the quality itself, with the exact gradient."""

import numpy as np
import pytest
from wanderings import N_JOINTS, metric, wandering

from geomstats_anim import LearnedMetric, MetricParameters, interpolate, quality, uniform_keyframes
from geomstats_anim import rotations as quat
from geomstats_anim.learning.objective import SMOOTHING, Objective
from geomstats_anim.parameters import CurveParameters

KINDS = ("loc", "rot", "hyb")
SIDES = {"left": ("left",) * N_JOINTS, "right": ("right",) * N_JOINTS, "mixed": None}
KEYS = uniform_keyframes(41, 0.15)


def objective(kind="hyb", weights=None, location_weight=0.5):
    return Objective(wandering(), KEYS, kind, weights, location_weight)


def curve(seed=0, full=False, sides=None):
    """A metric and tensions, away from the kink at 1."""
    tension, translation_tension = np.random.default_rng(seed).choice([0.0, 0.3, 0.8, 1.2, 1.9], (2, N_JOINTS))
    return CurveParameters(metric(seed, full, sides), tension, translation_tension)


def moved(start, joint, direction, step):
    """Move one joint's log alpha, log beta, axes (by a turn from the left), tension or translation tension."""
    parameters = start.metric
    log_moments, turns = np.log(parameters.moments[:, 1:]), np.zeros((N_JOINTS, 3))
    tensions = np.stack([start.tension, start.translation_tension])
    if direction < 2:
        log_moments[joint, direction] += step
    elif direction < 5:
        turns[joint, direction - 2] = step
    else:
        tensions[direction - 5, joint] += step
    axes = quat.log(quat.multiply(quat.exp(turns), parameters.axes_quaternions))
    turned = MetricParameters(*np.exp(log_moments).T, axes, parameters.invariance)
    return CurveParameters(turned, *tensions)


def rebuilt_with(parameters, scheme="geodesic-spline"):
    truth = wandering()
    named = LearnedMetric(
        truth.skeleton.joints,
        parameters.metric,
        parameters.tension,
        scheme,
        translation_tension=parameters.translation_tension,
    )
    return interpolate(truth.at_frames(KEYS), truth.times, scheme, named)


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "spd"])
@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("weights", [None, "depth"])
def test_the_value_is_the_quality_of_what_is_rebuilt(kind, sides, full, weights):
    truth, parameters = wandering(), curve(1, full, SIDES[sides])
    rebuilt = rebuilt_with(parameters)
    expected = quality(rebuilt, truth, kind, weights)
    value = objective(kind, weights).value(parameters)
    # rounding off takes at most SMOOTHING from each angle
    slack = 0.0 if kind == "loc" else SMOOTHING * N_JOINTS * 3
    assert expected - slack <= value * (1.0 + 1e-12)
    assert value <= expected * (1.0 + 1e-12)


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "spd"])
@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_gradient_is_that_of_the_value(kind, sides, full):
    parameters = curve(2, full, SIDES[sides])
    # where a tension is 0 its derivative is one-sided
    parameters = CurveParameters(
        parameters.metric, *np.maximum([parameters.tension, parameters.translation_tension], 0.1)
    )
    some = objective(kind, "depth", 0.3)
    value, gradient = some.value_and_gradient(parameters)
    assert value == pytest.approx(some.value(parameters), rel=1e-9)
    expected, step = np.empty((N_JOINTS, 7)), 2e-4
    for joint, direction in np.ndindex(expected.shape):
        far, near = (
            some.value(moved(parameters, joint, direction, factor * step))
            - some.value(moved(parameters, joint, direction, -factor * step))
            for factor in (2.0, 1.0)
        )
        expected[joint, direction] = (8.0 * near - far) / (12.0 * step)
    assert np.abs(gradient - expected).max() < 1e-5 * np.abs(expected).max()


def test_the_gradient_at_the_identity():
    some = objective("rot")
    identity = CurveParameters.plain("geodesic", N_JOINTS)
    _, gradient = some.value_and_gradient(identity)
    step = 1e-4
    for joint, direction in np.ndindex(N_JOINTS, 2):
        ends = [some.value(moved(identity, joint, direction, sign * step)) for sign in (1.0, -1.0)]
        assert gradient[joint, direction] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4)


def test_a_perfect_metric_has_no_gradient():
    """An angle has no derivative at 0, the smoothed one has."""
    parameters = curve(3)
    made = rebuilt_with(parameters)
    for kind in KINDS:
        value, gradient = Objective(made, KEYS, kind).value_and_gradient(parameters)
        assert value < 1e-12
        assert np.abs(gradient).max() < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_segments_and_the_others_add_up_to_all(kind):
    whole, parameters = objective(kind), curve(4)
    block = np.array([1, 2])
    inside = (np.arange(41) >= KEYS[1]) & (np.arange(41) < KEYS[3])
    only, without = whole.only(block), whole.without(block)
    np.testing.assert_array_equal(only.scored, inside)
    np.testing.assert_array_equal(without.scored, ~inside)
    total = inside.sum() * only.value(parameters) + (~inside).sum() * without.value(parameters)
    assert total == pytest.approx(41 * whole.value(parameters), rel=1e-12)
    gradients = [part.value_and_gradient(parameters)[1] for part in (whole, only, without)]
    expected = inside.sum() * gradients[1] + (~inside).sum() * gradients[2]
    np.testing.assert_allclose(expected, 41 * gradients[0], rtol=1e-9, atol=1e-12)


def test_frames_that_do_not_count_already_stay_out():
    early = np.arange(41) < 20
    part = Objective(wandering(), KEYS, scored=early)
    np.testing.assert_array_equal(part.only(np.array([0, 4])).scored, np.arange(41) < KEYS[1])
    np.testing.assert_array_equal(part.without(np.array([0])).scored, early & (np.arange(41) >= KEYS[1]))


def test_only_scored_frames_count():
    truth, parameters = wandering(), curve(5)
    scored = np.arange(41) % 3 == 0
    rebuilt = rebuilt_with(parameters)
    expected = quality(rebuilt.at_frames(np.flatnonzero(scored)), truth.at_frames(np.flatnonzero(scored)), "loc")
    assert Objective(truth, KEYS, "loc", scored=scored).value(parameters) == pytest.approx(expected, rel=1e-12)


def test_no_scored_frames():
    value, gradient = Objective(wandering(), KEYS, scored=np.zeros(41, bool)).value_and_gradient(curve())
    assert value == 0.0 and not gradient.any()


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "spd"])
def test_rotation_errors_of_some_joints_and_their_gradient(full):
    some, parameters = objective("rot", "depth"), curve(12, full)
    value, gradient = some.value_and_gradient(parameters)
    for joints in (np.arange(N_JOINTS), np.array([3]), np.array([4, 1]), np.array([], dtype=int)):
        errors, by_joint = some.rotation_errors_and_gradient(parameters.at(joints), joints)
        np.testing.assert_allclose(errors, some.rotation_errors_by_joint(parameters)[joints], rtol=1e-9)
        alone = some.rotation_errors_by_joint(parameters.at(joints), joints)
        np.testing.assert_allclose(alone, errors, rtol=1e-9)
        np.testing.assert_allclose(by_joint, gradient[joints], rtol=1e-12, atol=1e-15)


def test_following_gives_what_searching_anew_gives():
    rng = np.random.default_rng(6)
    followed, parameters = objective(), curve(6, full=True)
    for _ in range(20):
        for direction in range(5):
            parameters = moved(parameters, rng.integers(N_JOINTS), direction, rng.normal(scale=0.2))
        value, gradient = followed.value_and_gradient(parameters)
        anew, by_anew = objective().value_and_gradient(parameters)
        assert value == pytest.approx(anew, rel=1e-9)
        np.testing.assert_allclose(gradient, by_anew, atol=1e-7 * np.abs(by_anew).max())


def test_the_value_does_not_depend_on_what_came_before():
    one, parameters = objective(), curve(7)
    before = one.value(parameters)
    one.value_and_gradient(curve(8))
    one.rotation_errors_by_joint(curve(9))
    assert one.value(parameters) == before


@pytest.mark.parametrize("weights", [None, "depth"])
def test_rotation_errors_add_up_and_keep_to_their_joint(weights):
    some, parameters = objective("rot", weights), curve(10)
    errors = some.rotation_errors_by_joint(parameters)
    assert errors.sum() == pytest.approx(some.value(parameters), rel=1e-9)
    for joint in range(N_JOINTS):
        other = some.rotation_errors_by_joint(moved(parameters, joint, 0, 0.5))
        change = np.abs(other - errors)
        assert change[joint] > 1e-6
        assert np.delete(change, joint).max() < 1e-12


def test_rotation_errors_are_the_same_for_every_kind():
    errors = [objective(kind).rotation_errors_by_joint(curve(11)) for kind in KINDS]
    np.testing.assert_array_equal(errors[0], errors[1])
    np.testing.assert_array_equal(errors[0], errors[2])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"kind": "all"}, "^There is no quality 'all'; the kinds are loc, rot, hyb[.]$"),
        ({"weights": [1.0]}, r"^weights has shape \(1,\), but 6 numbers that are at least 0 are needed[.]$"),
        ({"location_weight": -1.0}, "^location_weight must be between 0 and 1, but it is -1.0[.]$"),
    ],
)
def test_nonsense_arguments(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        Objective(wandering(), KEYS, **arguments)
