"""Splines: what is continuous, what is symmetric, what stays, and the exact derivative by metric and tension."""

import dataclasses

import numpy as np
import oracles
import pytest
import samples
from scipy.interpolate import CubicSpline

from geomstats_anim import Animation, LearnedMetric, MetricParameters, interpolate
from geomstats_anim import rotations as quat
from geomstats_anim.interpolation.splines import PathSpline, PoseSpline
from geomstats_anim.parameters import CurveParameters

pytestmark = pytest.mark.filterwarnings("error")

N_KEYS, N_JOINTS = 6, 7
FULL = pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
TENSIONS = [0.0, 0.3, 1.0, 1.4, 2.0]


def clip(seed=0, n_keys=N_KEYS, step=40.0, n_joints=N_JOINTS):
    """Keys at uneven times."""
    return samples.animation(np.random.default_rng(seed), n_keys, n_joints, step)


def metric_for(keys, full=True, invariance=None, seed=9):
    return samples.parameters(np.random.default_rng(seed), keys.n_joints, 8.0, full, invariance)


def with_tension(keys, parameters, tension):
    tensions = np.full(keys.n_joints, tension)
    return LearnedMetric(keys.skeleton.joints, parameters, tensions, "geodesic-spline", translation_tension=tensions)


def spline(keys, parameters, tension, times):
    return interpolate(keys, times, "geodesic-spline", with_tension(keys, parameters, tension))


def dense(keys, n=201):
    return np.linspace(keys.times[0], keys.times[-1], n)


def rates(keys, parameters, tension, order):
    """One-sided angular and linear velocities (order 1) or accelerations (order 2) at the inner keys."""
    step = 1e-4
    sides = []
    for sign in (-1.0, 1.0):
        at = keys.times[1:-1, None] + sign * step * np.arange(5)[None]
        times, where = np.unique(at, return_inverse=True)
        motion = spline(keys, parameters, tension, times)
        poses = motion.rotations[where].reshape(*at.shape, -1, 4)
        points = motion.translations[where].reshape(*at.shape, -1, 3)
        turns = quat.log(quat.multiply(quat.conjugate(poses[:, :1]), poses))
        values = np.concatenate([turns, points - points[:, :1]], axis=2)
        # one-sided differences of third order
        weights = {1: [-11 / 6, 3.0, -1.5, 1 / 3, 0.0], 2: [35 / 12, -26 / 3, 19 / 2, -14 / 3, 11 / 12]}[order]
        sides.append(np.einsum("i,kibj->kbj", weights, values) / (sign * step) ** order)
    return sides


@FULL
@pytest.mark.parametrize("tension", [1.0, 1.5, 2.0])
def test_velocity_is_continuous_from_tension_1_on(tension, full):
    keys = clip()
    before, after = rates(keys, metric_for(keys, full), tension, 1)
    np.testing.assert_allclose(before, after, atol=1e-6)


@FULL
def test_acceleration_is_continuous_at_tension_2(full):
    keys = clip()
    before, after = rates(keys, metric_for(keys, full), 2.0, 2)
    assert np.abs(before).max() > 1.0
    np.testing.assert_allclose(before, after, atol=1e-3)


def test_below_tension_1_velocity_jumps_in_proportion():
    keys = clip()
    parameters = metric_for(keys)
    jumps = [np.subtract(*rates(keys, parameters, tension, 1)) for tension in (0.0, 0.25, 0.75)]
    np.testing.assert_allclose(jumps[1], 0.75 * jumps[0], atol=1e-6)
    np.testing.assert_allclose(jumps[2], 0.25 * jumps[0], atol=1e-6)


@FULL
def test_tension_0_is_the_geodesic(full):
    keys = clip(step=90.0)
    parameters = metric_for(keys, full)
    bent, straight = spline(keys, parameters, 0.0, dense(keys)), interpolate(keys, dense(keys), "geodesic", parameters)
    np.testing.assert_array_equal(bent.rotations, straight.rotations)
    np.testing.assert_allclose(bent.translations, straight.translations, atol=1e-15)


@pytest.mark.parametrize("tension", TENSIONS)
def test_keys_are_kept_bit_for_bit(tension):
    keys = clip(step=120.0)
    result = spline(keys, metric_for(keys), tension, keys.times)
    np.testing.assert_array_equal(result.rotations, keys.rotations)
    np.testing.assert_array_equal(result.translations, keys.translations)


@pytest.mark.parametrize("tension", TENSIONS)
@pytest.mark.parametrize("side", ["left", "right"])
def test_the_whole_clip_may_be_moved_on_the_side_of_its_invariance(side, tension):
    keys = clip(1)
    parameters = metric_for(keys, invariance=side)
    shift = samples.quaternions(np.random.default_rng(2), N_JOINTS)

    def moved(animation):
        factors = (shift, animation.rotations) if side == "left" else (animation.rotations, shift)
        return dataclasses.replace(animation, rotations=quat.multiply(*factors))

    first, last = (
        moved(spline(keys, parameters, tension, dense(keys))),
        spline(moved(keys), parameters, tension, dense(keys)),
    )
    assert quat.distance(first.rotations, last.rotations).max() < 1e-10


@pytest.mark.parametrize("tension", TENSIONS)
def test_right_by_inversion_of_left(tension):
    keys = clip(2)
    right = metric_for(keys, invariance="right")
    left = MetricParameters(right.alpha, right.beta, right.axes, "left")
    inverse = dataclasses.replace(keys, rotations=quat.conjugate(keys.rotations))
    one = spline(keys, right, tension, dense(keys)).rotations
    other = quat.conjugate(spline(inverse, left, tension, dense(keys)).rotations)
    assert quat.distance(one, other).max() < 1e-12


@pytest.mark.parametrize("tension", TENSIONS)
def test_reversed_in_time(tension):
    keys = clip(3)
    parameters = metric_for(keys)
    backwards = dataclasses.replace(
        keys, times=-keys.times[::-1], rotations=keys.rotations[::-1], translations=keys.translations[::-1]
    )
    one = spline(keys, parameters, tension, dense(keys))
    other = spline(backwards, parameters, tension, -dense(keys)[::-1])
    assert quat.distance(one.rotations, other.rotations[::-1]).max() < 1e-10
    np.testing.assert_allclose(one.translations, other.translations[::-1], atol=1e-12)


@pytest.mark.parametrize("tension", TENSIONS)
def test_slower_or_later_it_is_the_same_curve(tension):
    keys = clip(4)
    parameters = metric_for(keys)
    slow = dataclasses.replace(keys, times=3.0 + 1e3 * keys.times)
    one, other = (
        spline(keys, parameters, tension, dense(keys)),
        spline(slow, parameters, tension, 3.0 + 1e3 * dense(keys)),
    )
    assert quat.distance(one.rotations, other.rotations).max() < 1e-9
    np.testing.assert_allclose(one.translations, other.translations, atol=1e-9)


@pytest.mark.parametrize("tension", TENSIONS)
def test_full_matrices_by_conjugation(tension):
    keys = clip(5)
    full = metric_for(keys, invariance="left")
    diagonal = MetricParameters(full.alpha, full.beta, None, "left")
    axes = full.axes_quaternions

    def seen(rotations, turn):
        return quat.multiply(quat.multiply(turn, rotations), quat.conjugate(turn))

    along_axes = dataclasses.replace(keys, rotations=seen(keys.rotations, axes))
    one = spline(keys, full, tension, dense(keys)).rotations
    other = seen(spline(along_axes, diagonal, tension, dense(keys)).rotations, quat.conjugate(axes))
    assert quat.distance(one, other).max() < 1e-11


@pytest.mark.parametrize("seed", range(3))
def test_smooth_paths_are_the_natural_cubic_spline(seed):
    keys = clip(seed)
    found = spline(keys, MetricParameters.identity(N_JOINTS), 2.0, dense(keys)).translations
    expected = CubicSpline(keys.times, keys.translations, bc_type="natural")(dense(keys))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_turns_about_one_axis_are_the_natural_cubic_spline_of_the_angle():
    rng = np.random.default_rng(6)
    times, angles = np.cumsum(rng.uniform(0.1, 1.0, 9)), np.cumsum(rng.uniform(-1.5, 1.5, (9, N_JOINTS)), axis=0)
    axes = samples.unit_vectors(rng, N_JOINTS)
    keys = Animation(samples.skeleton(N_JOINTS), times, quat.exp(angles[..., None] * axes), np.zeros((9, N_JOINTS, 3)))
    found = spline(keys, MetricParameters.identity(N_JOINTS), 2.0, dense(keys)).rotations
    expected = CubicSpline(times, angles, bc_type="natural")(dense(keys))
    assert quat.distance(found, quat.exp(expected[..., None] * axes)).max() < 1e-12


@pytest.mark.parametrize("tension", TENSIONS)
def test_what_does_not_move_between_two_keys_stays(tension):
    keys = clip(7, n_keys=8)
    rotations, translations = keys.rotations.copy(), keys.translations.copy()
    rotations[3:5], translations[3:5] = rotations[3], translations[3]
    held = dataclasses.replace(keys, rotations=rotations, translations=translations)
    times = np.linspace(held.times[3], held.times[4], 50)
    result = spline(held, metric_for(held), tension, times)
    assert quat.distance(result.rotations, rotations[3]).max() < 1e-15
    np.testing.assert_allclose(
        result.translations, np.broadcast_to(translations[3], result.translations.shape), atol=1e-15
    )
    if tension >= 1.0:
        before, after = rates(held, metric_for(held), tension, 1)
        np.testing.assert_allclose(before, after, atol=1e-6)


@pytest.mark.parametrize("first", [0, 6])
def test_a_hold_at_either_end_stays(first):
    keys = clip(8, n_keys=8)
    rotations = keys.rotations.copy()
    rotations[first : first + 2] = rotations[first]
    held = dataclasses.replace(keys, rotations=rotations)
    times = np.linspace(held.times[first], held.times[first + 1], 50)
    assert quat.distance(spline(held, metric_for(held), 2.0, times).rotations, rotations[first]).max() < 1e-15


@pytest.mark.parametrize("tension", TENSIONS)
def test_two_keys_make_a_geodesic(tension):
    keys = clip(9, n_keys=2, step=100.0)
    parameters = metric_for(keys)
    one, other = spline(keys, parameters, tension, dense(keys)), interpolate(keys, dense(keys), "geodesic", parameters)
    assert quat.distance(one.rotations, other.rotations).max() < 1e-12
    np.testing.assert_allclose(one.translations, other.translations, atol=1e-14)


@pytest.mark.parametrize("tension", TENSIONS)
def test_half_turns(tension):
    """Exactly 180 degrees, where the shortest way is not unique, and the bend is large."""
    rotations = np.array([[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    keys = Animation(samples.skeleton(1), np.arange(4.0), rotations[:, None], np.zeros((4, 1, 3)))
    result = spline(keys, MetricParameters([3.0], [0.5]), tension, dense(keys, 61))
    assert np.isfinite(result.rotations).all()
    np.testing.assert_allclose(quat.distance(result.rotations[::20], keys.rotations), 0.0, atol=1e-12)


def test_a_metric_without_tension_gets_1_and_none_is_the_bi_invariant():
    keys = clip(10)
    parameters = metric_for(keys)
    by_parameters = interpolate(keys, dense(keys), "geodesic-spline", parameters)
    np.testing.assert_array_equal(by_parameters.rotations, spline(keys, parameters, 1.0, dense(keys)).rotations)
    identity = MetricParameters.identity(N_JOINTS)
    plain = interpolate(keys, dense(keys), "geodesic-spline")
    np.testing.assert_array_equal(plain.rotations, spline(keys, identity, 1.0, dense(keys)).rotations)


def test_each_joint_and_channel_has_its_own_tension():
    keys = clip(11)
    parameters = metric_for(keys)
    tension, translation_tension = np.random.default_rng(0).uniform(0.0, 2.0, (2, N_JOINTS))
    mixed = LearnedMetric(
        keys.skeleton.joints, parameters, tension, "geodesic-spline", translation_tension=translation_tension
    )
    result = interpolate(keys, dense(keys), "geodesic-spline", mixed)
    for joint in range(N_JOINTS):
        alone = spline(keys, parameters, tension[joint], dense(keys)).rotations[:, joint]
        assert quat.distance(result.rotations[:, joint], alone).max() < 1e-14
        path = spline(keys, parameters, translation_tension[joint], dense(keys)).translations[:, joint]
        np.testing.assert_allclose(result.translations[:, joint], path, atol=1e-14)


GENERATORS = oracles.cross_matrix(np.eye(3))
INDEX = np.repeat(np.arange(N_KEYS - 1), 7)
PARAMETER = np.tile([0.0, 0.1, 0.1, 0.5, 0.73, 0.99, 1.0], N_KEYS - 1)


@FULL
@pytest.mark.parametrize("invariance", ["left", "right", None])
@pytest.mark.parametrize("step_angle", [20.0, 60.0, 110.0])
@pytest.mark.parametrize("held", [False, True])
def test_the_derivative_against_finite_differences(held, step_angle, invariance, full):
    keys = clip(12, step=step_angle)
    rotations = keys.rotations.copy()
    if held:
        rotations[2, ::2] = rotations[3, ::2]
    parameters = metric_for(keys, full, invariance)
    tension = np.array([0.2, 0.5, 0.9, 1.1, 1.5, 1.9, 0.7])
    coefficients = np.random.default_rng(13).normal(size=(len(INDEX), N_JOINTS, 3, 3))

    def scalars(curve):
        return np.einsum("fbij,fbij->b", coefficients, quat.to_matrix(curve(INDEX, PARAMETER)))

    curve = PoseSpline(keys.times, rotations, parameters, tension)
    poses = curve(INDEX, PARAMETER)
    cotangent = np.einsum("fbij,fbik,dkj->fbd", coefficients, quat.to_matrix(poses), GENERATORS)
    by_metric, by_tension = curve.pull_back(INDEX, PARAMETER, poses, cotangent)
    found = np.concatenate([by_metric, by_tension[:, None]], axis=1)
    expected, step = np.empty_like(found), 1e-4
    for direction in range(6):
        values = []
        for factor in (-2.0, -1.0, 1.0, 2.0):
            near = samples.moved(parameters, direction, factor * step) if direction < 5 else parameters
            tight = tension + (factor * step if direction == 5 else 0.0)
            values.append(scalars(PoseSpline(keys.times, rotations, near, tight, curve.geodesics.velocity)))
        expected[:, direction] = (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(found - expected) / scale).max() < 1e-5


def test_the_derivative_of_paths_against_finite_differences():
    keys = clip(14)
    tension = np.array([0.2, 0.5, 0.9, 1.1, 1.5, 1.9, 0.7])
    cotangent = np.random.default_rng(15).normal(size=(len(INDEX), N_JOINTS, 3))

    def scalars(tension):
        points = PathSpline(keys.times, keys.translations, tension)(INDEX, PARAMETER)
        return np.einsum("fbi,fbi->b", cotangent, points)

    found = PathSpline(keys.times, keys.translations, tension).pull_back(INDEX, PARAMETER, cotangent)
    np.testing.assert_allclose(found, (scalars(tension + 1e-3) - scalars(tension - 1e-3)) / 2e-3, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["tension", "translation_tension"])
@pytest.mark.parametrize(("value", "shown"), [(-0.1, "-0.1"), (2.1, "2.1"), (np.nan, "nan")])
def test_tensions_out_of_range(name, value, shown):
    tensions = {"tension": np.ones(3), "translation_tension": np.ones(3)}
    tensions[name] = np.array([1.0, value, 1.0])
    with pytest.raises(ValueError, match=f"^{name} of joint 1 is {shown}; it must be from 0 to 2[.]$"):
        CurveParameters(MetricParameters.identity(3), **tensions)


def test_another_tension_gives_what_a_new_path_gives():
    rng = np.random.default_rng(9)
    times, points = np.cumsum(rng.uniform(0.1, 1.0, 6)), rng.normal(size=(6, 3, 3))
    index, parameter = np.repeat(np.arange(5), 4), np.tile([0.0, 0.3, 0.7, 1.0], 5)
    cotangent = rng.normal(size=(20, 3, 3))
    path = PathSpline(times, points, np.zeros(3))
    for tension in rng.uniform(0.0, 2.0, (5, 3)):
        path, anew = path.tightened(tension), PathSpline(times, points, tension)
        np.testing.assert_array_equal(path(index, parameter), anew(index, parameter))
        np.testing.assert_array_equal(
            path.pull_back(index, parameter, cotangent), anew.pull_back(index, parameter, cotangent)
        )
