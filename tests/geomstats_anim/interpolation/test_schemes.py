"""The schemes: keys kept, laws of each, and what happens outside the range, with one key, or when a geodesic fails."""

import dataclasses

import numpy as np
import oracles
import pytest
import samples
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from geomstats_anim import (
    SCHEMES,
    Animation,
    FallbackWarning,
    LearnedMetric,
    LogStatus,
    MetricParameters,
    interpolate,
    names,
)
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics import pose_geodesics as geodesics_module

pytestmark = pytest.mark.filterwarnings("error")

MINE = tuple(SCHEMES)


def clip(seed=0, n_frames=12, n_joints=7, step=40.0, scales=True):
    return samples.animation(np.random.default_rng(seed), n_frames, n_joints, step, scales)


def metric_for(animation, full=True, invariance=None):
    return samples.parameters(np.random.default_rng(99), animation.n_joints, 8.0, full, invariance)


def metric_of(scheme, animation):
    """A metric, where the scheme has one."""
    return metric_for(animation) if scheme in names.WITH_METRIC else None


def dense(animation, n=101):
    """Times that include the first and the last key, and others that do not meet keys."""
    return np.linspace(animation.times[0], animation.times[-1], n)


def moved(animation, shift, side):
    """The whole clip, translated in the group."""
    turned = (shift, animation.rotations) if side == "left" else (animation.rotations, shift)
    return dataclasses.replace(animation, rotations=quat.multiply(*turned))


def test_the_schemes_are_named():
    assert set(MINE) <= set(SCHEMES)


@pytest.mark.parametrize("scheme", MINE)
@pytest.mark.parametrize("scales", [False, True])
def test_keys_are_exact(scheme, scales):
    keys = clip(scales=scales)
    result = interpolate(keys, keys.times, scheme, metric_of(scheme, keys))
    np.testing.assert_array_equal(result.times, keys.times)
    np.testing.assert_array_equal(result.translations, keys.translations)
    assert (result.scales is None) == (not scales)
    if scales:
        np.testing.assert_array_equal(result.scales, keys.scales)
    # the last key is the end of its segment, which shooting reaches to 1e-12
    assert quat.distance(result.rotations, keys.rotations).max() < 2e-12
    assert quat.distance(result.rotations, keys.rotations)[:-1].max() < 1e-15


@pytest.mark.parametrize("scheme", MINE)
def test_uneven_times_between_keys(scheme):
    keys = clip()
    times = np.sort(np.random.default_rng(1).uniform(keys.times[0], keys.times[-1], 200))
    result = interpolate(keys, times, scheme, metric_of(scheme, keys))
    one_by_one = [interpolate(keys, [t], scheme, metric_of(scheme, keys)) for t in times[::20]]
    for k, single in zip(range(0, 200, 20), one_by_one, strict=True):
        assert quat.distance(single.rotations[0], result.rotations[k]).max() < 1e-14
        np.testing.assert_array_equal(single.translations[0], result.translations[k])


@pytest.mark.parametrize("scheme", MINE)
def test_outside_the_range_the_end_keys_are_held(scheme):
    keys = clip()
    first, last = keys.times[[0, -1]]
    result = interpolate(keys, [first - 5.0, first - 1e-9, last + 1e-9, last + 5.0], scheme, metric_of(scheme, keys))
    for k, key in enumerate([0, 0, -1, -1]):
        assert quat.distance(result.rotations[k], keys.rotations[key]).max() < 2e-12
        np.testing.assert_array_equal(result.translations[k], keys.translations[key])
        np.testing.assert_array_equal(result.scales[k], keys.scales[key])


@pytest.mark.parametrize("scheme", MINE)
def test_one_key_is_held(scheme):
    keys = clip(n_frames=1)
    result = interpolate(keys, [-1.0, 0.0, 99.0], scheme, metric_of(scheme, keys))
    for k in range(3):
        np.testing.assert_allclose(result.rotations[k], keys.rotations[0], atol=1e-15)
        np.testing.assert_array_equal(result.translations[k], keys.translations[0])


@pytest.mark.parametrize("scheme", MINE)
def test_no_key(scheme):
    keys = Animation(samples.skeleton(2), [], np.empty((0, 2, 4)), np.empty((0, 2, 3)))
    with pytest.raises(ValueError, match="^Interpolation needs at least one key, but the animation has none[.]$"):
        interpolate(keys, [0.0], scheme)


@pytest.mark.parametrize("scheme", MINE)
def test_no_times(scheme):
    keys = clip()
    result = interpolate(keys, [], scheme, metric_of(scheme, keys))
    assert result.rotations.shape == (0, 7, 4)


@pytest.mark.parametrize("scheme", MINE)
@pytest.mark.parametrize("n_joints", [0, 1])
def test_few_joints(scheme, n_joints):
    keys = clip(n_joints=n_joints)
    assert interpolate(keys, dense(keys), scheme, metric_of(scheme, keys)).rotations.shape == (101, n_joints, 4)


@pytest.mark.parametrize("scheme", MINE)
def test_without_motion_nothing_moves(scheme):
    keys = clip()
    still = dataclasses.replace(keys, rotations=np.repeat(keys.rotations[:1], 12, axis=0))
    result = interpolate(still, dense(still), scheme, metric_of(scheme, still))
    assert quat.distance(result.rotations, keys.rotations[:1]).max() < 1e-15


@pytest.mark.parametrize("scheme", MINE)
def test_quaternions_are_unit_and_continuous_whatever_the_signs_of_the_keys(scheme):
    keys = clip(step=100.0)
    result = interpolate(keys, dense(keys, 1001), scheme, metric_of(scheme, keys))
    np.testing.assert_allclose(np.linalg.norm(result.rotations, axis=-1), 1.0, atol=1e-15)
    assert (np.einsum("tbi,tbi->tb", result.rotations[1:], result.rotations[:-1]) >= 0.0).all()


@pytest.mark.parametrize("scheme", ["linear", "slerp", "geodesic"])
def test_translations_and_scales_are_linear(scheme):
    keys = clip()
    times = dense(keys)
    result = interpolate(keys, times, scheme, metric_of(scheme, keys))
    for name in ("translations", "scales"):
        source, values = getattr(keys, name), getattr(result, name)
        for b in range(keys.n_joints):
            for i in range(3):
                expected = np.interp(times, keys.times, source[:, b, i])
                np.testing.assert_allclose(values[:, b, i], expected, atol=1e-13)


@pytest.mark.parametrize("scheme", ["squad", "rotation-spline"])
@pytest.mark.parametrize("n_keys", [2, 3, 4, 12])
def test_the_peers_carry_cubic_translations(scheme, n_keys):
    keys = clip(n_frames=n_keys)
    expected = CubicSpline(keys.times, keys.translations)(dense(keys))
    np.testing.assert_allclose(interpolate(keys, dense(keys), scheme).translations, expected, atol=1e-13)


@pytest.mark.parametrize("step", [20.0, 80.0])
def test_squad_is_that_of_numpy_quaternion(step):
    quaternion = pytest.importorskip("quaternion", reason="numpy-quaternion is not installed")
    keys = clip(step=step)
    found = interpolate(keys, dense(keys), "squad").rotations
    for joint in range(keys.n_joints):
        scalar_first = quaternion.as_quat_array(np.roll(keys.rotations[:, joint], 1, axis=-1))
        expected = quaternion.as_float_array(quaternion.squad(scalar_first, keys.times, dense(keys)))
        assert quat.distance(found[:, joint], np.roll(expected, -1, axis=-1)).max() < 1e-12


@pytest.mark.parametrize("step", [20.0, 80.0, 160.0])
def test_rotation_spline_is_that_of_scipy(step):
    keys = clip(step=step)
    found = interpolate(keys, dense(keys), "rotation-spline").rotations
    for joint in range(keys.n_joints):
        expected = RotationSpline(keys.times, Rotation.from_quat(keys.rotations[:, joint]))(dense(keys)).as_quat()
        assert quat.distance(found[:, joint], expected).max() < 1e-12


def test_constant_holds_every_key_until_the_next():
    keys = clip()
    times = np.concatenate([keys.times[:-1] + 0.999 * np.diff(keys.times), keys.times[-1:]])
    result = interpolate(keys, times, "constant")
    for name in ("rotations", "translations", "scales"):
        np.testing.assert_allclose(getattr(result, name), getattr(keys, name), atol=1e-15)


def test_linear_is_a_normalised_straight_line():
    keys = clip(n_frames=2)
    middle = interpolate(keys, [keys.times.mean()], "linear").rotations[0]
    np.testing.assert_allclose(middle, quat.normalize(keys.rotations.sum(axis=0)), atol=1e-15)
    assert quat.distance(middle, interpolate(keys, [keys.times.mean()], "slerp").rotations[0]).max() < 1e-14


@pytest.mark.parametrize("metric", ["none", "identity", "learned", "turned axes"])
def test_a_geodesic_of_the_identity_metric_is_a_slerp(metric):
    keys = clip(step=170.0)
    identity = MetricParameters.identity(7)
    given = {
        "none": None,
        "identity": identity,
        "learned": LearnedMetric(keys.skeleton.joints, identity),
        "turned axes": MetricParameters(np.ones(7), np.ones(7), np.full((7, 3), 0.4), "right"),
    }[metric]
    mine = interpolate(keys, dense(keys), "geodesic", given)
    slerped = interpolate(keys, dense(keys), "slerp")
    assert quat.distance(mine.rotations, slerped.rotations).max() < 1e-12


def test_a_geodesic_obeys_eulers_equations():
    keys = clip(n_frames=2)
    metric = metric_for(keys)
    curve = SCHEMES["geodesic"](keys, metric)
    poses, _ = oracles.velocity_form(
        metric.matrices, curve.geodesics.velocity[0], quat.to_matrix(keys.rotations[0]), metric.is_right, [0.25, 0.75]
    )
    result = curve(keys.times[0] + np.array([0.25, 0.75]) * np.diff(keys.times))
    assert oracles.angle_between(quat.to_matrix(result.rotations), poses).max() < 1e-10


@pytest.mark.parametrize("scheme", ["linear", "slerp", "geodesic"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_turning_the_whole_clip_turns_the_result(scheme, side):
    keys = clip()
    shift = samples.quaternions(np.random.default_rng(2), 7)
    metric = metric_for(keys, invariance=side) if scheme in names.WITH_METRIC else None
    expected = moved(interpolate(keys, dense(keys), scheme, metric), shift, side)
    result = interpolate(moved(keys, shift, side), dense(keys), scheme, metric)
    assert quat.distance(result.rotations, expected.rotations).max() < 1e-10


@pytest.mark.parametrize("scheme", ["linear", "slerp", "geodesic"])
def test_reversing_time_reverses_the_result(scheme):
    keys = clip()
    back = Animation(keys.skeleton, -keys.times[::-1], keys.rotations[::-1], keys.translations[::-1], keys.scales[::-1])
    times = dense(keys)
    there = interpolate(keys, times, scheme, metric_of(scheme, keys))
    again = interpolate(back, -times[::-1], scheme, metric_of(scheme, keys))
    assert quat.distance(again.rotations[::-1], there.rotations).max() < 1e-10
    np.testing.assert_allclose(again.translations[::-1], there.translations, atol=1e-13)


def test_a_metric_matters():
    keys = clip()
    curved = interpolate(keys, dense(keys), "geodesic", metric_for(keys))
    assert quat.distance(curved.rotations, interpolate(keys, dense(keys), "slerp").rotations).max() > 0.01


def test_the_same_bytes_twice():
    keys = clip(n_frames=60, n_joints=30)
    one, two = (interpolate(keys, dense(keys, 500), "geodesic", metric_for(keys)) for _ in range(2))
    assert one.rotations.tobytes() == two.rotations.tobytes()


@pytest.fixture
def failing(monkeypatch):
    """Let the search for a geodesic fail on joints 1 and 4 of segment 2 out of 7 joints."""
    solve = geodesics_module.shortest_momenta

    def fail_some(*problems):
        found = solve(*problems)
        for b, status in ((1, LogStatus.STALLED), (4, LogStatus.MAX_ITERATIONS)):
            found.status[2 * 7 + b], found.energy[2 * 7 + b] = status, np.inf
        return found

    monkeypatch.setattr(geodesics_module, "shortest_momenta", fail_some)


def test_a_segment_that_fails_is_slerped_and_named(failing):
    keys, metric = clip(), None
    metric = metric_for(keys)
    curve = SCHEMES["geodesic"](keys, metric)
    assert [(f.joint, f.status) for f in curve.fallbacks] == [
        ("joint1", LogStatus.STALLED),
        ("joint4", LogStatus.MAX_ITERATIONS),
    ]
    for fallback in curve.fallbacks:
        assert (fallback.start_time, fallback.end_time) == (keys.times[2], keys.times[3])
        start = f"Joint {fallback.joint!r} from {keys.times[2]:g} s to {keys.times[3]:g} s is slerped: "
        assert str(fallback) == start + str(fallback.status)
    times = np.linspace(keys.times[2], keys.times[3], 11)
    slerped = interpolate(keys, times, "slerp")
    assert quat.distance(curve(times).rotations, slerped.rotations)[:, [1, 4]].max() < 1e-12
    with pytest.warns(FallbackWarning, match="^2 segments are slerped. The first: Joint 'joint1' from "):
        interpolate(keys, times, "geodesic", metric)


def test_a_learned_metric_is_matched_by_name():
    keys = clip()
    metric = metric_for(keys)
    order = np.random.default_rng(3).permutation(7)
    shuffled = LearnedMetric(
        [keys.skeleton.joints[i] for i in order],
        MetricParameters(
            metric.alpha[order], metric.beta[order], metric.axes[order], [metric.invariance[i] for i in order]
        ),
    )
    one, two = (interpolate(keys, dense(keys), "geodesic", z) for z in (metric, shuffled))
    np.testing.assert_array_equal(one.rotations, two.rotations)


def test_joints_that_a_learned_metric_does_not_know_are_named():
    keys = clip(n_joints=3)
    known = LearnedMetric(["joint0", "joint2"], MetricParameters([2.0, 3.0], [0.5, 1.0]))
    with pytest.warns(UserWarning, match="joint1"):
        result = interpolate(keys, dense(keys), "geodesic", known)
    slerped = interpolate(keys, dense(keys), "slerp")
    assert quat.distance(result.rotations, slerped.rotations)[:, 1].max() < 1e-12


def test_the_scheme_is_that_of_the_metric_or_the_spline():
    keys = clip()
    parameters = metric_for(keys)
    times = dense(keys)
    learned = {scheme: LearnedMetric(keys.skeleton.joints, parameters, None, scheme) for scheme in names.WITH_METRIC}
    for metric, scheme in (
        (None, "geodesic-spline"),
        (parameters, "geodesic-spline"),
        *((learned[s], s) for s in learned),
    ):
        left, named = interpolate(keys, times, metric=metric), interpolate(keys, times, scheme, metric)
        np.testing.assert_array_equal(left.rotations, named.rotations)
        np.testing.assert_array_equal(left.translations, named.translations)
    two = (interpolate(keys, times, metric=learned[scheme]).rotations for scheme in names.LEARNABLE)
    assert quat.distance(*two).max() > 0.01


@pytest.mark.parametrize("scheme", [name for name in SCHEMES if name not in names.WITH_METRIC])
def test_a_metric_for_a_scheme_without_one_is_refused(scheme):
    keys = clip()
    learned = LearnedMetric(keys.skeleton.joints, metric_for(keys), scheme="geodesic")
    for metric in (metric_for(keys), learned):
        with pytest.raises(ValueError, match="has no metric; leave it out, or use one of the schemes geodesic and "):
            interpolate(keys, dense(keys), scheme, metric)
    only_named = LearnedMetric.plain(keys.skeleton.joints, scheme)
    np.testing.assert_array_equal(
        interpolate(keys, dense(keys), metric=only_named).rotations, interpolate(keys, dense(keys), scheme).rotations
    )


def test_an_unknown_scheme():
    with pytest.raises(ValueError, match="^There is no scheme 'bezier'; the schemes are constant, linear, slerp, "):
        interpolate(clip(), [0.0], "bezier")


def test_a_metric_of_other_joints():
    with pytest.raises(ValueError, match="^The metric has 3 joints, but the animation has 7[.]$"):
        interpolate(clip(), [1.0], "geodesic", MetricParameters.identity(3))


@pytest.mark.parametrize("scheme", MINE)
@pytest.mark.parametrize(
    "times, message",
    [
        ([2.0, 1.0], "times must increase, but time 0 is 2.0 and time 1 is 1.0."),
        ([1.0, 1.0], "times must increase, but time 0 is 1.0 and time 1 is 1.0."),
        ([0.0, np.nan], "times has a value that is not finite, nan, at index (1,)."),
        ([[0.0, 1.0]], "times has shape (1, 2), but (any) is needed."),
    ],
)
def test_times_that_make_no_animation(scheme, times, message):
    keys = clip()
    with pytest.raises(ValueError) as error:
        interpolate(keys, times, scheme, metric_of(scheme, keys))
    assert str(error.value) == message
