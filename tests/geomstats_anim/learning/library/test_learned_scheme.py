"""Laws of the scheme `learned`."""

from dataclasses import replace

import numpy as np
import pytest
from gaits import biped, gait, library

from geomstats_anim import SCHEMES, Animation, LearnedMetric, MetricParameters, Skeleton, interpolate, learn_library
from geomstats_anim import rotations as quat
from geomstats_anim.criteria import rotation_errors
from geomstats_anim.interpolation.learned_scheme import Learned
from geomstats_anim.learning.library.storage import dump_library


@pytest.fixture(scope="module")
def unseen():
    return gait(100, 81)


@pytest.fixture(scope="module")
def keys(unseen):
    return unseen.at_frames(np.arange(0, 81, 8))


def test_it_helps_clips_that_are_like_those_in_the_library(unseen, keys):
    curve = Learned(keys, None, library())
    learned = rotation_errors(curve(unseen.times), unseen).mean()
    spline = rotation_errors(interpolate(keys, unseen.times), unseen).mean()
    assert learned < 0.6 * spline
    assert max(part.share for part in curve.help.parts) > 0.5


@pytest.mark.parametrize("tension", [1.0, 2.0])
def test_keys_are_exact_and_the_curve_is_as_smooth_as_the_spline(keys, tension):
    metric = LearnedMetric.plain(keys.skeleton.joints, "learned", tension)
    curve = Learned(keys, metric, library())
    assert curve.help.residual is not None
    np.testing.assert_array_equal(curve(keys.times).rotations, keys.rotations)
    inner = keys.times[1:-1]
    near = np.stack([inner - 1e-9, inner + 1e-9])
    steps = np.diff([curve(times, order=0) for times in near], axis=0)
    assert abs(steps).max() < 1e-7
    assert abs(np.diff([curve(times, order=1) for times in near], axis=0)).max() < 1e-5
    if tension == 2.0:
        assert abs(np.diff([curve(times, order=2) for times in near], axis=0)).max() < 1e-3


def test_rates_are_derivatives_of_the_curve(keys):
    curve, times, step = Learned(keys, None, library()), np.linspace(0.11, 2.3, 40), 1e-5
    before, after = curve(times - step, order=0), curve(times + step, order=0)
    np.testing.assert_allclose(quat.difference(before, after) / (2 * step), curve(times, order=1), atol=1e-6)
    slope = (curve(times + step, order=1) - curve(times - step, order=1)) / (2 * step)
    np.testing.assert_allclose(slope, curve(times, order=2), atol=1e-4)


def test_some_joints_are_those_of_all(keys):
    curve, times, joints = Learned(keys, None, library()), np.linspace(-0.1, 3.0, 50), np.array([3, 7, 12])
    np.testing.assert_allclose(curve.rotations(times, joints), curve(times).rotations[:, joints], atol=1e-14)


def test_neither_heading_nor_place_nor_the_start_matters(unseen, keys):
    turn = quat.exp(np.array([0.0, 1.1, 0.0]))
    rotations, translations = keys.rotations.copy(), keys.translations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    translations[:, 0] = quat.rotate(turn, translations[:, 0]) + [3.0, 0.0, -7.0]
    moved = Animation(keys.skeleton, keys.times + 12.0, rotations, translations)
    dense, other = (
        Learned(each, None, library())(unseen.times + shift) for each, shift in ((keys, 0.0), (moved, 12.0))
    )
    expected = dense.rotations.copy()
    expected[:, 0] = quat.multiply(turn, expected[:, 0])
    np.testing.assert_allclose(quat.distance(other.rotations, expected), 0.0, atol=1e-9)


def test_left_and_right_are_treated_alike(unseen, keys):
    mirror = library().mirror
    curve, other = Learned(keys, None, library()), Learned(mirror.animation(keys), None, library())
    assert curve.help.residual is not None
    expected = mirror.rotations(curve(unseen.times).rotations)
    np.testing.assert_allclose(quat.distance(other(unseen.times).rotations, expected), 0.0, atol=1e-7)
    shares = [[part.share for part in each.help.parts] for each in (curve, other)]
    assert shares[0] == [shares[1][i] for i in (0, 2, 1, 4, 3)]


def test_the_order_of_joints_does_not_matter(unseen, keys):
    order = [0, 13, 14, 15, 10, 11, 12, 1, 2, 7, 8, 9, 4, 5, 6, 3]
    skeleton, place = keys.skeleton, np.argsort(order)
    other = Skeleton(
        [skeleton.joints[i] for i in order],
        [-1 if (p := skeleton.parents[i]) < 0 else place[p] for i in order],
        skeleton.rest_translations[order],
        skeleton.rest_rotations[order],
    )
    shuffled = Animation(other, keys.times, keys.rotations[:, order], keys.translations[:, order])
    expected = Learned(keys, None, library())(unseen.times).rotations[:, order]
    np.testing.assert_allclose(Learned(shuffled, None, library())(unseen.times).rotations, expected, atol=1e-12)


@pytest.mark.parametrize("kind", ["none", "empty", "foreign names", "foreign bones", "few keys"])
def test_without_help_it_is_the_spline_bit_for_bit(unseen, keys, kind):
    own, skeleton = library(), biped()
    if kind == "none":
        own = None
    elif kind == "empty":
        own = replace(own, models=())
    elif kind == "foreign names":
        joints = [joint.upper() for joint in skeleton.joints]
        own = replace(
            own, skeleton=Skeleton(joints, skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
        )
    elif kind == "foreign bones":
        bones = -skeleton.rest_translations
        own = replace(own, skeleton=Skeleton(skeleton.joints, skeleton.parents, bones, skeleton.rest_rotations))
    else:
        keys = keys.at_frames([0, 3, 6, 9])
    curve = Learned(keys, None, own)
    spline = SCHEMES["geodesic-spline"](keys)
    assert curve.help.residual is None
    for order in range(3):
        np.testing.assert_array_equal(curve(unseen.times, order=order), spline(unseen.times, order=order))


def test_motion_that_is_nothing_like_the_library_stays_the_spline():
    rng, skeleton = np.random.default_rng(3), biped()
    rotations = quat.exp(0.5 * rng.normal(size=(12, skeleton.n_joints, 3)))
    keys = Animation(skeleton, np.arange(12) * 8 / 30, rotations, np.zeros((12, skeleton.n_joints, 3)))
    help = Learned(keys, None, library()).help
    assert sum(part.share for part in help.parts) <= 0.5


def test_joints_that_rest_between_keys_stay(unseen, keys):
    rotations = keys.rotations.copy()
    rotations[4:6, 10:13] = rotations[4, 10:13]
    held = Animation(keys.skeleton, keys.times, rotations, keys.translations)
    times = np.linspace(held.times[4], held.times[5], 30)
    curve = Learned(held, None, library())
    assert curve.help.residual is not None
    np.testing.assert_allclose(quat.distance(curve(times).rotations[:, 10:13], rotations[4, 10:13]), 0.0, atol=1e-7)


def test_keys_may_be_uneven(unseen):
    keys = unseen.at_frames([0, 7, 15, 24, 31, 40, 47, 56, 64, 73, 80])
    learned = rotation_errors(Learned(keys, None, library())(unseen.times), unseen).mean()
    assert learned < 0.8 * rotation_errors(interpolate(keys, unseen.times), unseen).mean()


def test_interpolate_takes_a_library_for_this_scheme_alone(unseen, keys):
    metric = MetricParameters(np.full(16, 1.5), np.full(16, 0.7))
    dense = interpolate(keys, unseen.times, "learned", metric, library())
    np.testing.assert_array_equal(dense.rotations, Learned(keys, metric, library())(unseen.times).rotations)
    with pytest.raises(ValueError, match="slerp has no library"):
        interpolate(keys, unseen.times, "slerp", library=library())


def test_learning_twice_gives_the_same_bytes():
    clips = [gait(seed, 50) for seed in (1, 2, 3)]
    first, second = (dump_library(learn_library(clips, gaps=(4, 8))) for _ in range(2))
    assert first == second


def test_what_cannot_be_learned_from_is_refused():
    with pytest.raises(ValueError, match="at least one clip"):
        learn_library([])
    with pytest.raises(ValueError, match="too short"):
        learn_library([gait(1, 4)], gaps=(8,))
    other = Skeleton(["a"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]])
    still = Animation(other, np.arange(9) / 30, np.tile([0.0, 0.0, 0.0, 1.0], (9, 1, 1)), np.zeros((9, 1, 3)))
    with pytest.raises(ValueError, match="joints of the clips differ"):
        learn_library([gait(1), still])
