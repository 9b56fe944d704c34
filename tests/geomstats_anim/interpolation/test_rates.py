"""Angular velocities and accelerations of every scheme: derivatives of the curve, and what is continuous at keys."""

import dataclasses

import numpy as np
import pytest
import samples

from geomstats_anim import SCHEMES, LearnedMetric, MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.exponential import Rates, exponential_rates, logarithm_rates
from geomstats_anim.interpolation.learned_scheme import Help
from geomstats_anim.interpolation.residuals import Residual

SIDES = pytest.mark.parametrize("side", ["left", "right"])
STEP = 2e-3


def clip(step=50.0, n_keys=8):
    """Keys at uneven times."""
    return samples.animation(np.random.default_rng(4), n_keys, 7, step, False)


def curve_of(scheme, keys, side="left", tension=None):
    if not scheme.startswith("geodesic"):
        return SCHEMES[scheme](keys)
    parameters = samples.parameters(np.random.default_rng(99), keys.n_joints, 8.0, True, side)
    if tension is None:
        return SCHEMES[scheme](keys, parameters)
    tensions = np.full(keys.n_joints, tension)
    return SCHEMES[scheme](keys, LearnedMetric(keys.skeleton.joints, parameters, tensions, scheme))


def between_keys(keys, n=5):
    pairs = zip(keys.times[:-1], keys.times[1:], strict=True)
    return np.concatenate([np.linspace(a, b, n + 2)[1:-1] for a, b in pairs])


def difference(values):
    """Derivative of sixth order by central differences of values at -3 to 3 steps."""
    weights = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
    return sum(weight * value for weight, value in zip(weights, values, strict=True)) / STEP


@SIDES
@pytest.mark.parametrize("scheme", SCHEMES)
def test_rates_are_the_derivatives_of_the_curve(scheme, side):
    keys = clip()
    times, steps = between_keys(keys), STEP * np.arange(-3, 4)
    curve = curve_of(scheme, keys, side, 1.4 if scheme == "geodesic-spline" else None)
    back = quat.conjugate(curve(times, order=0))
    turns = [quat.log(quat.multiply(back, curve(times + step, order=0))) for step in steps]
    velocity, acceleration = curve(times, order=1), curve(times, order=2)
    expected = difference([curve(times + step, order=1) for step in steps])
    assert velocity.shape == acceleration.shape == (len(times), keys.n_joints, 3)
    np.testing.assert_allclose(velocity, difference(turns), atol=1e-9 * max(1.0, np.abs(velocity).max()))
    np.testing.assert_allclose(acceleration, expected, atol=1e-9 * max(1.0, np.abs(acceleration).max()))
    if scheme != "constant":
        assert np.abs(velocity).max() > 0.1


@pytest.mark.parametrize("scheme", SCHEMES)
def test_order_0_is_the_rotations_of_the_animation(scheme):
    keys = clip()
    curve, times = curve_of(scheme, keys), np.linspace(keys.times[0] - 1.0, keys.times[-1] + 1.0, 50)
    np.testing.assert_array_equal(curve(times, order=0), curve(times).rotations)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_what_is_held_does_not_turn(scheme):
    keys = clip()
    first, last = keys.times[[0, -1]]
    for order in (1, 2):
        assert not curve_of(scheme, keys)([first - 1.0, first - 1e-9, last + 1e-9], order).any()
        assert not curve_of(scheme, keys.at_frames([0]))([first - 1.0, first, last], order).any()
        still = dataclasses.replace(keys, rotations=np.repeat(keys.rotations[:1], keys.n_frames, axis=0))
        np.testing.assert_allclose(curve_of(scheme, still)(between_keys(keys), order), 0.0, atol=1e-13)


@pytest.mark.parametrize("order", [-1, 3, 1.5])
def test_there_are_three_orders(order):
    with pytest.raises(ValueError, match=f"^The order must be 0, 1 or 2, but it is {order}[.]$"):
        curve_of("slerp", clip())([0.0], order)


def jumps(curve, order):
    """Return the distance of rates on both sides of the inner keys."""
    keys, step = curve.animation.times[1:-1], 1e-9
    return np.abs(curve(keys, order) - curve(keys - step, order)).max()


@SIDES
@pytest.mark.parametrize("tension", [1.0, 1.5, 2.0])
def test_from_tension_1_on_velocity_is_continuous(tension, side):
    assert jumps(curve_of("geodesic-spline", clip(), side, tension), 1) < 1e-6


@SIDES
def test_at_tension_2_acceleration_is_continuous_and_below_it_is_not(side):
    assert jumps(curve_of("geodesic-spline", clip(), side, 2.0), 2) < 1e-5
    assert jumps(curve_of("geodesic-spline", clip(), side, 1.9), 2) > 0.1
    assert jumps(curve_of("geodesic-spline", clip(), side, 0.9), 1) > 0.1


def test_the_spline_of_scipy_is_as_smooth():
    assert jumps(curve_of("rotation-spline", clip()), 1) < 1e-6
    assert jumps(curve_of("rotation-spline", clip()), 2) < 1e-4


@SIDES
def test_both_ends_are_natural(side):
    """Nothing bends there: the acceleration is the geodesic's, seen from a body that turns at another velocity."""
    keys = clip()
    straight, bent = curve_of("geodesic", keys, side), curve_of("geodesic-spline", keys, side, 2.0)
    ends = keys.times[[0, -1]]
    own, velocity = straight(ends, 1), bent(ends, 1)
    if side == "left":
        expected = straight(ends, 2) - np.cross(velocity, own)
    else:  # in space, where the bend of a right-invariant geodesic is seen from its other end
        expected = straight(ends, 2) + np.cross(velocity, own)
    assert np.abs(velocity - own).max() > 0.1
    np.testing.assert_allclose(bent(ends, 2), expected, atol=1e-9)


@SIDES
def test_geodesics_obey_eulers_equation(side):
    keys = clip()
    curve, times = curve_of("geodesic", keys, side), between_keys(keys)
    matrices = curve.geodesics.parameters.matrices
    rates, sign = [curve(times, 1), curve(times, 2)], 1.0
    if side == "right":  # in space, where Euler's equation has the other sign
        rates, sign = [quat.rotate(curve(times, 0), rate) for rate in rates], -1.0
    velocity, acceleration = rates
    momentum = np.einsum("bij,fbj->fbi", matrices, velocity)
    changed = np.einsum("bij,fbj->fbi", matrices, acceleration)
    np.testing.assert_allclose(changed, sign * np.cross(momentum, velocity), atol=1e-9 * np.abs(changed).max())


def test_slerp_and_the_geodesic_of_the_identity_turn_alike():
    keys = clip()
    times = between_keys(keys)
    geodesic, slerp = SCHEMES["geodesic"](keys, MetricParameters.identity(7)), SCHEMES["slerp"](keys)
    for order in (1, 2):
        np.testing.assert_allclose(geodesic(times, order), slerp(times, order), atol=1e-11)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.3, 0.499, 0.501, 1.0, 2.0, 3.0])
def test_logarithm_rates_undo_exponential_rates(angle):
    vector = angle * samples.unit_vectors(np.random.default_rng(0), 50)
    first, second = np.random.default_rng(1).normal(size=(2, 50, 3))
    rates = exponential_rates(vector, first, second)
    for found, expected in zip(logarithm_rates(vector, rates), (first, second), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 0.1, 0.499, 0.501, 2.0, 6.0])
def test_exponential_rates_against_finite_differences(angle):
    vector = angle * samples.unit_vectors(np.random.default_rng(2), 20)
    first, second = np.random.default_rng(3).normal(size=(2, 20, 3))
    steps = STEP * np.arange(-3, 4)

    def along(step):
        return vector + step * first + 0.5 * step**2 * second, first + step * second

    back = quat.exp(-vector)
    turns = [quat.log(quat.multiply(back, quat.exp(along(step)[0]))) for step in steps]
    rates = exponential_rates(vector, first, second)
    np.testing.assert_allclose(rates.velocity, difference(turns), atol=1e-10)
    expected = difference([exponential_rates(*along(step), second).velocity for step in steps])
    np.testing.assert_allclose(rates.acceleration, expected, atol=1e-10)
    assert isinstance(rates, Rates)


def check_differences(curve):
    times, steps = between_keys(curve.animation, 3), STEP * np.arange(-3, 4)
    back = quat.conjugate(curve(times, order=0))
    turns = [quat.log(quat.multiply(back, curve(times + step, order=0))) for step in steps]
    velocity, acceleration = curve(times, order=1), curve(times, order=2)
    expected = difference([curve(times + step, order=1) for step in steps])
    np.testing.assert_allclose(velocity, difference(turns), atol=1e-7 * np.abs(velocity).max())
    np.testing.assert_allclose(acceleration, expected, atol=1e-7 * np.abs(acceleration).max())


@pytest.mark.parametrize(("scheme", "tension"), [("geodesic", 0.0), ("geodesic-spline", 1.4)])
def test_rates_with_coupled_joints(scheme, tension):
    keys = clip(40.0, 4)
    rng, n = np.random.default_rng(3), keys.n_joints
    parameters = samples.parameters(rng, n, 4.0, True)
    coupling = 0.4 * rng.normal(size=(n, 3, 2))
    metric = LearnedMetric(keys.skeleton.joints, parameters, np.full(n, tension), scheme, coupling=coupling)
    curve = SCHEMES[scheme](keys, metric)
    assert not curve.fallbacks
    check_differences(curve)


def test_rates_with_what_a_library_predicts():
    keys = clip()
    rng, shape = np.random.default_rng(3), (keys.n_frames - 1, 2, keys.n_joints, 3)
    holds = np.zeros((keys.n_frames - 1, keys.n_joints), dtype=bool)
    residual = Residual.through_keys(0.1 * rng.normal(size=shape), np.diff(keys.times), holds)
    curve = SCHEMES["learned"](keys, None, Help(residual))
    assert np.abs(curve(between_keys(keys), 1) - SCHEMES["learned"](keys)(between_keys(keys), 1)).max() > 0.1
    check_differences(curve)
