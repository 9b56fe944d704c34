"""A curve that takes another metric through the same keys is the curve that is made from that metric."""

import numpy as np
import pytest
import samples

from geomstats_anim import SCHEMES, LearnedMetric, MetricParameters
from geomstats_anim.names import WITH_METRIC

TIMES = np.linspace(-0.1, 3.0, 57)


def metrics(animation, seed=0):
    """A metric, and one that differs in some joints only: moments, axes, side, tension of turns and of translations."""
    rng = np.random.default_rng(seed)
    n = animation.n_joints
    alpha, beta = rng.uniform(0.3, 3.0, (2, n))
    tension = rng.uniform(0.0, 2.0, n)
    first = LearnedMetric(animation.skeleton.joints, MetricParameters(alpha, beta), tension, "geodesic-spline")
    alpha[0] *= 2.0
    axes, sides, translation = np.zeros((n, 3)), ["left"] * n, np.ones(n)
    axes[1], sides[2], tension[3], translation[4] = [0.3, -0.5, 0.2], "right", 0.4, 2.0
    parameters = MetricParameters(alpha, beta, axes, tuple(sides))
    joints = animation.skeleton.joints
    return first, LearnedMetric(joints, parameters, tension, "geodesic-spline", translation_tension=translation)


@pytest.mark.parametrize("scheme", WITH_METRIC)
def test_it_is_the_curve_of_the_other_metric_bit_for_bit(scheme):
    keys = samples.animation(np.random.default_rng(3), 7, 9)
    first, second = (metric.for_scheme(scheme) for metric in metrics(keys))
    curve = SCHEMES[scheme](keys, first)
    before = curve(TIMES)
    changed, anew = curve.with_metric(second), SCHEMES[scheme](keys, second)
    for name in ("rotations", "translations"):
        np.testing.assert_array_equal(getattr(changed(TIMES), name), getattr(anew(TIMES), name))
        np.testing.assert_array_equal(getattr(curve(TIMES), name), getattr(before, name))
    np.testing.assert_array_equal(changed(TIMES, order=2), anew(TIMES, order=2))
    np.testing.assert_array_equal(changed.geodesics.length, anew.geodesics.length)


@pytest.mark.parametrize("scheme", WITH_METRIC)
def test_joints_alone_are_those_of_the_whole_curve(scheme):
    keys = samples.animation(np.random.default_rng(3), 7, 9)
    curve = SCHEMES[scheme](keys, metrics(keys)[1].for_scheme(scheme))
    joints = np.array([4, 1])
    whole = curve(TIMES)
    np.testing.assert_allclose(curve.rotations(TIMES, joints), whole.rotations[:, joints], atol=1e-15)
    np.testing.assert_allclose(curve.translations(TIMES, joints), whole.translations[:, joints], atol=1e-15)


def test_differing_joints():
    keys = samples.animation(np.random.default_rng(3), 7, 9)
    first, second = metrics(keys)
    curve = SCHEMES["geodesic-spline"](keys, first)
    turns, moves = curve.differs(curve.with_metric(second))
    assert (
        np.flatnonzero(turns).tolist() == [0, 1, 2, 3]
        and (moves == (second.translation_tension != first.translation_tension)).all()
    )
    assert not curve.differs(curve.with_metric(first))[0].any()


def test_quick_searches_are_continued_from_the_metric_before():
    keys = samples.animation(np.random.default_rng(3), 7, 9)
    first, second = metrics(keys)
    curve = SCHEMES["geodesic-spline"](keys, first)
    quick, thorough = curve.with_metric(second, "quick"), curve.with_metric(second)
    np.testing.assert_allclose(quick(TIMES).rotations, thorough(TIMES).rotations, atol=1e-8)
    assert (quick(TIMES).rotations != thorough(TIMES).rotations).any()
    again = quick.with_metric(first, "quick").with_metric(second)
    np.testing.assert_array_equal(again(TIMES).rotations, thorough(TIMES).rotations)


def test_a_single_key_is_held():
    keys = samples.animation(np.random.default_rng(3), 2, 5).at_frames(slice(0, 1))
    curve = SCHEMES["geodesic-spline"](keys).with_metric(None)
    np.testing.assert_array_equal(curve.rotations(TIMES, np.array([1])), np.tile(keys.rotations[:, [1]], (57, 1, 1)))
