"""Laws of keeping points in place."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from walker import FEET, walk

from geomstats_anim import SCHEMES, MetricParameters, learn_library, quality, uniform_keyframes
from geomstats_anim import rotations as quat
from geomstats_anim.contacts import Plants, find_contacts, plant, skating
from geomstats_anim.interpolation.learned_scheme import Learned
from geomstats_anim.markers import joint_matrices

UP = np.array([0.0, 1.0, 0.0])
EASE = 0.3


@cache
def library():
    """Learn from walks of other strides, for the gaps of these keys and twice as long ones."""
    return learn_library([walk(2.0, stride=stride)[0] for stride in (0.6, 0.8)], gaps=(3, 5, 7, 10))


def curve_of(keys, scheme):
    if scheme != "learned":
        return SCHEMES[scheme](keys)
    curve = Learned(keys, None, library())
    assert max(part.share for part in curve.help.parts) > 0.5
    return curve


def case(rate=0.1, dense_contacts=True, scheme="geodesic-spline", extra=()):
    """Return the original, its keys, its plants, and the curve through the keys at all times that matter."""
    original, _ = walk()
    keys = original.at_frames(uniform_keyframes(original.n_frames, rate))
    source = original if dense_contacts else keys
    plants = Plants.of(find_contacts(source, UP), source).through_keys(keys)
    times = np.unique(np.concatenate([original.times, plants.probes(), extra]))
    return original, keys, plants, curve_of(keys, scheme)(times)


def at(animation, times):
    return animation.at_frames(np.searchsorted(animation.times, times - 1e-9))


def identity(animation):
    return MetricParameters.identity(animation.n_joints)


@pytest.mark.parametrize("dense_contacts", [True, False])
@pytest.mark.parametrize("scheme", ["slerp", "geodesic-spline", "learned"])
def test_planted_points_are_in_their_places(dense_contacts, scheme):
    original, keys, plants, dense = case(0.15, dense_contacts, scheme)
    planted = plant(dense, keys, plants, identity(dense))
    assert planted.plants.number == plants.number > 4
    places = joint_matrices(planted.animation)[..., 3]
    for joint, start, end, first, last in zip(*vars(plants).values(), strict=True):
        inside = (dense.times >= start - 1e-9) & (dense.times <= end + 1e-9)
        share = ((dense.times[inside] - start) / (end - start)).clip(0.0, 1.0)[:, None]
        expected = first + share**2 * (3.0 - 2.0 * share) * (last - first)
        # ankle and toe are on one bone, so that both are at their places only as far as these are as far apart
        assert np.linalg.norm(places[inside, joint] - expected, axis=-1).max() < 0.004


def test_skate_falls_to_a_tenth_and_quality_does_not():
    original, keys, plants, dense = case()
    contacts = find_contacts(original, UP)
    planted = at(plant(dense, keys, plants, identity(dense)).animation, original.times)
    plain = at(dense, original.times)
    before, after = (skating([each], [original], [contacts]) for each in (plain, planted))
    assert after.skate < 0.1 * before.skate
    assert after.floating < 0.2 * before.floating
    assert quality(planted, original) < quality(plain, original)


def test_a_library_and_contacts_add_up():
    errors = {}
    for scheme in ("geodesic-spline", "learned"):
        original, keys, plants, dense = case(scheme=scheme)
        planted = plant(dense, keys, plants, identity(dense)).animation
        contacts = find_contacts(original, UP)
        for word, motion in (("free", dense), ("planted", planted)):
            there = at(motion, original.times)
            errors[scheme, word] = quality(there, original), skating([there], [original], [contacts]).skate
    both = errors["learned", "planted"]
    assert both[0] < min(errors["learned", "free"][0], errors["geodesic-spline", "planted"][0])
    assert both[1] < 0.2 * errors["learned", "free"][1]


@pytest.mark.parametrize("scheme", ["geodesic-spline", "learned"])
@pytest.mark.parametrize("dense_contacts", [True, False])
def test_keys_and_frames_without_contact_stay_bit_for_bit(dense_contacts, scheme):
    _, keys, plants, dense = case(0.15, dense_contacts, scheme)
    after = plant(dense, keys, plants, identity(dense)).animation
    is_key = np.isin(dense.times, keys.times)
    far = np.ones(len(dense.times), dtype=bool)
    for start, end in zip(plants.starts, plants.ends, strict=True):
        far &= (dense.times < start - EASE) | (dense.times > end + EASE)
    for name in ("rotations", "translations"):
        for same in (is_key, far):
            np.testing.assert_array_equal(getattr(after, name)[same], getattr(dense, name)[same])
    above = {0, 1, 2, 3, 5, 6, 7}
    others = [joint for joint in range(dense.n_joints) if joint not in above]
    np.testing.assert_array_equal(after.rotations[:, others], dense.rotations[:, others])


@pytest.mark.parametrize("reach", [np.inf, 0.0])
def test_frames_that_are_wanted_are_those_of_all(reach):
    original, keys, plants, dense = case()
    wanted = np.isin(dense.times, original.times)
    assert 0 < wanted.sum() < len(wanted)
    some = plant(dense, keys, plants, identity(dense), reach, wanted=wanted)
    every = plant(dense, keys, plants, identity(dense), reach)
    assert some.plants.number == every.plants.number
    for name in ("times", "rotations", "translations"):
        np.testing.assert_array_equal(getattr(some.animation, name), getattr(every.animation, name)[wanted])


@pytest.mark.parametrize("scheme", ["geodesic-spline", "learned"])
@pytest.mark.parametrize("dense_contacts", [True, False])
def test_velocities_stay_continuous(dense_contacts, scheme):
    _, keys, plants, _ = case(0.15, dense_contacts, scheme)
    edges = np.unique([plants.starts, plants.ends])
    edges = edges[(edges > 0.01) & (edges < keys.times[-1] - 0.01)]
    step = 1e-4
    around = (edges[:, None] + step * np.arange(-2, 3)).ravel()
    _, keys, plants, dense = case(0.15, dense_contacts, scheme, extra=around)
    after = plant(dense, keys, plants, identity(dense)).animation
    for joint in (1, 2, 3):
        index = np.searchsorted(after.times, around - 1e-9).reshape(-1, 5)
        turns = after.rotations[index, joint]
        steps = quat.difference(turns[:, :-1], turns[:, 1:]) / step
        # the jump of the velocity, less what an acceleration of both sides explains
        left, right = 1.5 * steps[:, 1] - 0.5 * steps[:, 0], 1.5 * steps[:, 2] - 0.5 * steps[:, 3]
        assert np.abs(right - left).max() < 0.02
        assert np.abs(steps).max() > 0.5


def test_what_is_out_of_reach_is_left_to_lift():
    _, keys, plants, dense = case(0.06)
    free = plant(dense, keys, plants, identity(dense))
    places = joint_matrices(dense)[..., 3]
    moved = np.linalg.norm(joint_matrices(free.animation)[..., 3] - places, axis=-1)[:, list(FEET)].max()
    reach = 0.3 * moved
    some = plant(dense, keys, plants, identity(dense), reach)
    assert 0 < some.left.number < plants.number
    assert some.left.number + some.plants.number == plants.number
    assert np.linalg.norm(joint_matrices(some.animation)[..., 3] - places, axis=-1)[:, list(FEET)].max() < 1.1 * reach
    none = plant(dense, keys, plants, identity(dense), 1e-9)
    assert none.plants.number == 0
    assert none.animation is dense


def test_a_foot_that_lifts_between_keys_is_not_dragged():
    # both keys have the foot on the ground at places that are apart: no contact of keys, so nothing is changed
    original, _ = walk()
    keys = original.at_frames([0, 60, 120])
    contacts = find_contacts(keys, UP)
    assert not contacts.planted.any()
    assert Plants.of(contacts, keys).number == 0


def test_the_stiff_axes_of_a_metric_move_least():
    _, keys, plants, dense = case()
    # all legs turn about z, the third axis, so beta makes them stiff
    turns = {}
    for name, joint in (("thigh", 1), ("shin", 2)):
        moments = np.ones(dense.n_joints)
        moments[[joint, joint + 4]] = 50.0
        after = plant(dense, keys, plants, MetricParameters(np.ones(dense.n_joints), moments)).animation
        turns[name] = quat.distance(dense.rotations, after.rotations).mean(axis=0)
    assert turns["thigh"][1] < 0.5 * turns["shin"][1]
    assert turns["shin"][2] < 0.5 * turns["thigh"][2]


def test_both_sides_of_a_metric_reach_the_places():
    original, keys, plants, dense = case()
    contacts = find_contacts(original, UP)
    plain = skating([at(dense, original.times)], [original], [contacts])
    results = []
    for side in ("left", "right"):
        parameters = MetricParameters(np.full(10, 3.0), np.full(10, 0.4), np.full((10, 3), 0.5), side)
        after = at(plant(dense, keys, plants, parameters).animation, original.times)
        assert skating([after], [original], [contacts]).skate < 0.1 * plain.skate
        results.append(after.rotations)
    assert quat.distance(*results).max() > 1e-3


def test_what_rests_between_keys_still_rests():
    original, _ = walk()
    rotations = np.array(original.rotations)
    rotations[:, 3] = rotations[0, 3]  # an ankle that never turns
    original = replace(original, rotations=rotations)
    keys = original.at_frames(uniform_keyframes(original.n_frames, 0.1))
    plants = Plants.of(find_contacts(original, UP), original).through_keys(keys)
    dense = SCHEMES["geodesic-spline"](keys)(np.union1d(original.times, plants.probes()))
    after = plant(dense, keys, plants, identity(dense)).animation
    assert (after.rotations != dense.rotations).any()
    np.testing.assert_array_equal(after.rotations[:, 3], dense.rotations[:, 3])
    still = plant(dense, keys, plants, identity(dense), moves_root=False).animation
    np.testing.assert_array_equal(still.translations, dense.translations)
    assert (after.translations != dense.translations).any()


def test_nothing_depends_on_where_a_character_stands():
    original, keys, plants, dense = case()
    expected = plant(dense, keys, plants, identity(dense)).animation
    turn, move = quat.exp(np.array([0.4, -1.1, 0.7])), np.array([5.0, -2.0, 1.0])
    matrix = np.concatenate([quat.to_matrix(turn), move[:, None]], axis=1)

    def there(animation):
        return replace(animation, world=np.tile(matrix, (animation.n_frames, 1, 1)))

    source = there(original)
    elsewhere = Plants.of(find_contacts(source, quat.rotate(turn, UP)), source).through_keys(there(keys))
    np.testing.assert_allclose(elsewhere.starts, plants.starts)
    after = plant(there(dense), there(keys), elsewhere, identity(dense)).animation
    assert quat.distance(after.rotations, expected.rotations).max() < 1e-7


def test_plants_are_cut_at_keys():
    original, _ = walk()
    keys = original.at_frames([0, 20, 100, 180])
    plants = Plants(
        np.array([3, 3, 7]),
        np.array([0.2, 1.0, 2.5]),
        np.array([0.5, 2.0, 2.75]),
        np.zeros((3, 3)),
        np.ones((3, 3)),
    )
    cut = plants.through_keys(keys)
    places = joint_matrices(keys)[..., 3]
    np.testing.assert_allclose(cut.starts, [0.2, 1 / 3, 1.0, 5 / 3, 2.5], atol=1e-12)
    np.testing.assert_allclose(cut.ends, [1 / 3, 0.5, 5 / 3, 2.0, 2.75], atol=1e-12)
    np.testing.assert_array_equal(cut.joints, [3, 3, 3, 3, 7])
    # the first two and the next two have one key each; the last has none, and keeps its own places
    for row, key in enumerate((1, 1, 2, 2)):
        np.testing.assert_array_equal(cut.start_places[row], places[key, 3])
        np.testing.assert_array_equal(cut.end_places[row], places[key, 3])
    np.testing.assert_array_equal(cut.start_places[4], 0.0)
    np.testing.assert_array_equal(cut.end_places[4], 1.0)


def test_a_plant_at_keys_goes_from_place_to_place():
    original, _ = walk()
    keys = original.at_frames([0, 20, 40, 100])
    none = np.zeros((1, 3))
    cut = Plants(np.array([3]), keys.times[:1], keys.times[2:3], none, none).through_keys(keys)
    places = joint_matrices(keys)[..., 3][:, 3]
    np.testing.assert_array_equal(cut.starts, keys.times[:2])
    np.testing.assert_array_equal(cut.ends, keys.times[1:3])
    np.testing.assert_array_equal(cut.start_places, places[:2])
    np.testing.assert_array_equal(cut.end_places, places[1:3])
