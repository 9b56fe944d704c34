"""Optimal keys: what dynamic programming finds is the best there is, and a search under a scheme never loses to it."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geomstats_anim import SCHEMES, Animation, MetricParameters, Skeleton, interpolate, optimal_keyframes, quality
from geomstats_anim.keyframes.dynamic_programming import (
    Measure,
    UnreachableError,
    cheapest,
    fewest,
    segment_errors,
)
from geomstats_anim.kinematics import world_pose
from geomstats_anim.markers import Markers
from geomstats_anim.names import CRITERIA

SKELETON = Skeleton(
    ["hips", "hips/spine", "hips/spine/arm"],
    [-1, 0, 1],
    [[0.0, 0.9, 0.0], [0.0, 0.3, 0.0], [0.2, 0.2, 0.0]],
    np.tile([0.0, 0.0, 0.0, 1.0], (3, 1)),
    [[0.0, 0.3, 0.0], [0.2, 0.2, 0.0], [0.3, 0.0, 0.1]],
)


def clip(n_frames, seed=0, size=1.0, skeleton=SKELETON):
    """A motion about several axes, at uneven times."""
    random = np.random.default_rng(seed)
    times = np.cumsum(random.uniform(0.02, 0.05, n_frames))
    phase, speed = random.uniform(1.0, 6.0, (2, skeleton.n_joints, 3))
    turns = size * np.sin(speed * times[:, None, None] * 2.0 + phase)
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(n_frames, -1, 4)
    moves = np.zeros((n_frames, skeleton.n_joints, 3))
    moves[:, 0] = 0.3 * np.sin(3.0 * times[:, None] + [0.0, 1.0, 2.0])
    return Animation(skeleton, times, rotations, skeleton.rest_translations + moves)


def bone_errors(rebuilt, animation):
    """Distances of joints and of the ends of their bones."""
    ours, truth = (np.concatenate(world_pose(each)[1:], axis=1) for each in (rebuilt, animation))
    return np.linalg.norm(ours - truth, axis=-1)


def cost(animation, keys, kind, scheme="slerp", metric=None):
    rebuilt = interpolate(animation.at_frames(keys), animation.times, scheme, metric)
    return bone_errors(rebuilt, animation).max() if kind == "max" else quality(rebuilt, animation, kind)


def every_choice(n_frames, count):
    return [np.array([0, *inner, n_frames - 1]) for inner in combinations(range(1, n_frames - 1), count - 2)]


@pytest.mark.parametrize("kind", CRITERIA)
@pytest.mark.parametrize("count", [2, 3, 5])
def test_no_choice_is_better_for_slerp(kind, count):
    animation = clip(11)
    keys = optimal_keyframes(animation, count, kind=kind)
    assert len(keys) == count and (np.diff(keys) > 0).all()
    best = min(cost(animation, each, kind) for each in every_choice(11, count))
    assert cost(animation, keys, kind) == pytest.approx(best, rel=1e-9)


@pytest.mark.parametrize("tolerance", [0.002, 0.02, 0.1, 10.0])
def test_no_fewer_keys_are_within_a_tolerance(tolerance):
    animation = clip(11)
    keys = optimal_keyframes(animation, tolerance=tolerance)
    assert cost(animation, keys, "max") <= tolerance
    fewer = [choice for count in range(2, len(keys)) for choice in every_choice(11, count)]
    assert all(cost(animation, choice, "max") > tolerance for choice in fewer)


@pytest.mark.parametrize("size", [1e-6, 1.0, 3.1])
def test_segment_errors_are_those_of_slerp(size):
    animation = clip(9, size=size)
    weights = np.array([1.0, 0.5, 2.0])
    measures = {
        "loc": Measure(weights, 0.0 * weights),
        "rot": Measure(0.0 * weights, weights),
        "max": Measure(0.0 * weights, 0.0 * weights, Markers.of_bones(SKELETON)),
    }
    for kind, measure in measures.items():
        errors = segment_errors(animation, np.arange(9), 8, measure)
        for start in range(8):
            for stop in range(start + 1, 9):
                part = animation.at_frames(slice(start, stop + 1))
                rebuilt = interpolate(part.at_frames([0, part.n_frames - 1]), part.times, "slerp")
                if kind == "max":
                    expected = bone_errors(rebuilt, part).max()
                else:
                    expected = quality(rebuilt, part, kind, weights) * part.n_frames
                assert errors[start, stop - start - 1] == pytest.approx(expected, rel=1e-7, abs=1e-12)
        assert np.isinf(errors[np.add.outer(np.arange(9), np.arange(8)) >= 8]).all()


def test_half_turns_between_keys():
    turns = Rotation.from_rotvec([[0.0, 0.0, angle] for angle in np.linspace(0.0, np.pi, 7)]).as_quat()
    skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    animation = Animation(skeleton, np.arange(7.0), turns[:, None], np.zeros((7, 1, 3)))
    keys = optimal_keyframes(animation, tolerance=1e-6)
    assert cost(animation, keys, "max") <= 1e-6 and len(keys) <= 3


@pytest.mark.parametrize(
    "scheme",
    [
        pytest.param(scheme, marks=pytest.mark.slow) if scheme == "rotation-spline" else scheme
        for scheme in SCHEMES
        if scheme != "slerp"
    ],
)
def test_a_scheme_gets_keys_of_its_own(scheme):
    animation = clip(24)
    metric = MetricParameters([2.0, 1.0, 0.5], [1.0, 0.6, 1.5]) if scheme.startswith("geodesic") else None
    keys = optimal_keyframes(animation, 6, scheme=scheme, metric=metric)
    start = optimal_keyframes(animation, 6)
    assert len(keys) == 6
    assert cost(animation, keys, "hyb", scheme, metric) <= cost(animation, start, "hyb", scheme, metric)
    few = optimal_keyframes(animation, tolerance=0.02, scheme=scheme, metric=metric)
    assert cost(animation, few, "max", scheme, metric) <= 0.02


def test_no_key_of_a_spline_is_needless():
    animation = clip(60)
    keys = optimal_keyframes(animation, tolerance=0.01, scheme="geodesic-spline")
    for needless in range(1, len(keys) - 1):
        assert cost(animation, np.delete(keys, needless), "max", "geodesic-spline") > 0.01


def with_hold(animation, start, stop):
    frames = np.arange(animation.n_frames)
    frames[start : stop + 1] = start
    return Animation(animation.skeleton, animation.times, animation.rotations[frames], animation.translations[frames])


def test_ends_of_holds_stay():
    animation = with_hold(clip(40), 10, 25)
    for choice in ({"count": 6}, {"tolerance": 0.05}, {"tolerance": 0.05, "scheme": "geodesic-spline"}):
        keys = optimal_keyframes(animation, **choice)
        assert {0, 10, 25, 39} <= set(keys.tolist())
        assert not set(keys.tolist()) & set(range(11, 25))
    assert len(optimal_keyframes(animation, 39)) == 39  # more than there is to see


def breathing(n_frames=1400, radians_per_frame=9e-7, metres=0.0):
    """A turn, or a way, that is too slow to be seen from one frame to the next, forth and back."""
    phase = np.minimum(np.arange(n_frames), np.arange(n_frames)[::-1])
    turns = Rotation.from_rotvec(radians_per_frame * phase[:, None] * [0.0, 0.0, 1.0]).as_quat()
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (n_frames, 3, 1))
    rotations[:, 0] = turns
    translations = np.tile(SKELETON.rest_translations, (n_frames, 1, 1))
    translations[:, 0, 0] += metres * phase
    return Animation(SKELETON, np.arange(n_frames) / 120.0, rotations, translations)


@pytest.mark.parametrize("motion", [{}, {"radians_per_frame": 0.0, "metres": 9e-7}])
def test_a_slow_breath_is_no_hold(motion):
    animation = breathing(**motion)
    keys = optimal_keyframes(animation, tolerance=1e-4)
    assert cost(animation, keys, "max") <= 1e-4
    assert 3 <= len(keys) <= 20


def test_a_hold_lasts_as_long_as_the_pose_is_that_of_its_first_frame():
    noise = 2e-7 * np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3, 3))
    still = clip(60)
    rotations = Rotation.from_rotvec(noise.reshape(-1, 3)).as_quat().reshape(60, 3, 4)
    still = Animation(SKELETON, still.times, rotations, np.tile(SKELETON.rest_translations, (60, 1, 1)))
    assert optimal_keyframes(still, tolerance=1e-4).tolist() == [0, 59]
    # a tolerance below the noise needs the frames within
    keys = optimal_keyframes(still, tolerance=1e-8)
    assert cost(still, keys, "max") <= 1e-8


def test_a_pose_held_for_a_fifth_of_a_second_is_no_hold_and_for_a_third_it_is():
    animation = clip(60, size=0.5)
    times = np.arange(60) / 30.0
    animation = Animation(SKELETON, times, animation.rotations, animation.translations)
    brief, long = with_hold(animation, 20, 26), with_hold(animation, 20, 30)
    assert len(optimal_keyframes(brief, 2)) == 2
    assert {20, 30} <= set(optimal_keyframes(long, 5).tolist())
    with pytest.raises(ValueError, match="4 of 60 frames must stay"):
        optimal_keyframes(long, 2)


def test_keys_that_no_segments_join_are_an_error():
    animation = clip(40)
    apart = np.array([0, 20, 39])
    forced = np.array([True, False, True])
    with pytest.raises(UnreachableError, match="^No keys among 3 frames stay within 1e-06 m[.]$"):
        fewest(animation, apart, forced, 1e-6, Measure(np.zeros(3), np.zeros(3), Markers.of_bones(SKELETON)))
    errors = np.array([[1.0], [1.0], [1.0], [np.inf]])
    with pytest.raises(UnreachableError, match="^No 2 of 4 frames are joined by segments that were measured[.]$"):
        cheapest(errors, np.array([True, False, False, True]), 2, False)


def test_what_is_to_stay_stays():
    animation = clip(30)
    for choice in ({"count": 6}, {"tolerance": 0.05}, {"tolerance": 0.05, "scheme": "geodesic-spline"}):
        assert {0, 7, 8, 29} <= set(optimal_keyframes(animation, keep=[8, 7], **choice).tolist())


def test_many_that_stay_in_one_place_leave_few_for_the_rest():
    animation = clip(300, size=0.1)
    keys = optimal_keyframes(animation, 100, keep=np.arange(98))
    assert len(keys) == 100 and set(range(98)) <= set(keys.tolist())


def test_all_frames_and_two_frames():
    animation = clip(12)
    assert optimal_keyframes(animation, 12).tolist() == list(range(12))
    assert optimal_keyframes(animation.at_frames([0, 5]), 2).tolist() == [0, 1]
    assert optimal_keyframes(animation.at_frames([0, 5]), tolerance=1.0, scheme="geodesic-spline").tolist() == [0, 1]


def test_what_never_moves_needs_two_keys():
    still = clip(50)
    still = Animation(SKELETON, still.times, np.tile(still.rotations[:1], (50, 1, 1)), still.translations * 0.0)
    for scheme in SCHEMES:
        assert optimal_keyframes(still, tolerance=1e-4, scheme=scheme).tolist() == [0, 49]


def test_choice_does_not_depend_on_where_the_skeleton_stands():
    animation = clip(40)
    turn = Rotation.from_rotvec([0.4, -1.0, 0.2])
    rotations, translations = animation.rotations.copy(), animation.translations.copy()
    rotations[:, 0] = (turn * Rotation.from_quat(rotations[:, 0])).as_quat()
    translations[:, 0] = turn.apply(translations[:, 0]) + [3.0, 0.0, -1.0]
    moved = Animation(SKELETON, animation.times, rotations, translations)
    assert optimal_keyframes(animation, 9).tolist() == optimal_keyframes(moved, 9).tolist()
    assert len(optimal_keyframes(animation, tolerance=0.02)) == len(optimal_keyframes(moved, tolerance=0.02))


def test_weights_decide():
    animation = clip(40)
    hips, arm = (optimal_keyframes(animation, 6, kind="rot", weights=np.eye(3)[joint]) for joint in (0, 2))
    assert hips.tolist() != arm.tolist()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({}, "Either count or tolerance must be given, but count is None and tolerance is None"),
        ({"count": 4, "tolerance": 0.1}, "Either count or tolerance"),
        ({"count": 1}, "count is 1, but 2 of 10 frames must stay.*say 2 to 10"),
        ({"count": 11}, "count is 11"),
        ({"count": 3, "keep": [2, 5]}, "4 of 10 frames must stay"),
        ({"tolerance": 0.0}, "must be above 0 metres, but it is 0.0"),
        ({"tolerance": float("nan")}, "must be above 0 metres"),
        ({"tolerance": 0.1, "kind": "rot"}, "about kind \"max\", but kind is 'rot'"),
        ({"count": 4, "kind": "sum"}, "no kind 'sum'; the kinds are loc, rot, hyb, max"),
        ({"count": 4, "scheme": "nurbs"}, "no scheme 'nurbs'"),
        ({"count": 4, "keep": [10]}, r"frames from 0 to 9, but it is \[10\]"),
        ({"count": 4, "keep": [0.5]}, "frames from 0 to 9"),
        ({"count": 4, "weights": [1.0]}, "3 numbers"),
    ],
)
def test_refusals(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        optimal_keyframes(clip(10), **arguments)


def test_one_frame_is_refused():
    with pytest.raises(ValueError, match="at least 2 frames, but there are 1"):
        optimal_keyframes(clip(10).at_frames([0]), 2)
