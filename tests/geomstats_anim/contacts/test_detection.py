"""Laws of finding what is planted."""

from dataclasses import replace

import numpy as np
import pytest
from walker import FEET, walk

from geomstats_anim import rotations as quat
from geomstats_anim import uniform_keyframes
from geomstats_anim.contacts import ContactParameters, find_contacts
from geomstats_anim.contacts.detection import body_size
from geomstats_anim.markers import joint_matrices

UP = np.array([0.0, 1.0, 0.0])


def turned(animation, turn, move=(0.0, 0.0, 0.0), size=1.0):
    """Place an animation elsewhere in the world."""
    world = np.concatenate([size * quat.to_matrix(turn), np.array(move)[:, None]], axis=1)
    return replace(animation, world=np.tile(world, (animation.n_frames, 1, 1)))


def test_feet_are_planted_when_they_are_and_nothing_else_is():
    animation, planted = walk()
    found = find_contacts(animation, UP)
    assert tuple(found.joints) == FEET
    assert found.ground == pytest.approx(0.03, abs=1e-12)
    truth = planted[1:] & planted[:-1]
    for column, foot in enumerate((0, 0, 1, 1)):
        assert found.planted[truth[:, foot], column].all()
        late = found.planted[:, column] & ~truth[:, foot]
        # a foot leaves the ground slowly: what is found beyond is within three frames, of sixty per second
        near = np.convolve(truth[:, foot], np.ones(7), "same") > 0
        assert (~late | near).all()


def test_nothing_depends_on_axes_place_or_size():
    animation, _ = walk()
    expected = find_contacts(animation, UP)
    upright = quat.exp(np.array([0.5 * np.pi, 0.0, 0.0]))  # y to z
    for turn, move, size in ((upright, (3.0, -7.0, 5.0), 1.0), (quat.exp(np.array([0.0, 2.0, 0.0])), (0, 0, 0), 0.02)):
        up = quat.rotate(turn, UP)
        found = find_contacts(turned(animation, turn, move, size), up)
        np.testing.assert_array_equal(found.planted, expected.planted)
        assert found.ground == pytest.approx(size * expected.ground + np.dot(move, up), abs=1e-9)


def test_nothing_depends_on_the_rate():
    shares = [find_contacts(walk(rate=rate)[0], UP).planted.mean(axis=0) for rate in (30.0, 60.0, 240.0)]
    assert np.ptp(shares, axis=0).max() < 2.5 / 30.0  # a frame at both ends of a step


@pytest.mark.parametrize("keys_per_second", [2, 3, 5, 8])
def test_sparse_keys_claim_no_step_that_lifts(keys_per_second):
    claims = 0
    for start in range(20):
        animation = walk(seconds=4.0)[0].at_frames(slice(start, None))
        frames = uniform_keyframes(animation.n_frames, keys_per_second / 60.0)
        found = find_contacts(animation.at_frames(frames), UP)
        places = joint_matrices(animation)[..., 3][:, found.joints]
        for gap, point in np.argwhere(found.planted):
            claims += 1
            way = places[frames[gap] : frames[gap + 1] + 1, point]
            assert np.linalg.norm(way - way[0], axis=-1).max() < 0.03
    assert claims > 0 or keys_per_second == 2


def test_noise_parts_no_step_in_two():
    animation, planted = walk(seconds=2.9)
    shaken = np.random.default_rng(0).normal(0.0, 0.001, (animation.n_frames, 3))
    translations = np.array(animation.translations)
    translations[:, 0] += shaken
    found = find_contacts(replace(animation, translations=translations), UP).planted[:, 0]
    steps = np.count_nonzero(np.diff(np.concatenate([[0], found, [0]])) == 1)
    assert steps == np.count_nonzero(np.diff(np.concatenate([[0], planted[:, 0], [0]])) == 1)


def test_what_no_turn_moves_is_no_foot():
    animation, _ = walk()
    still = replace(animation, rotations=np.tile(quat.IDENTITY, (animation.n_frames, animation.n_joints, 1)))
    assert not len(find_contacts(still, UP).joints)
    assert np.isnan(find_contacts(still, UP).ground)
    assert find_contacts(animation.at_frames(slice(0, 1)), UP).planted.shape == (0, 0)


def test_a_platform_above_a_given_ground_is_no_ground():
    animation, _ = walk()
    assert not len(find_contacts(animation, UP, ground=-1.0).joints)
    np.testing.assert_array_equal(
        find_contacts(animation, UP, ground=0.0).planted, find_contacts(animation, UP).planted
    )


def test_points_that_stay_planted_for_a_moment_only_are_not():
    animation, _ = walk()
    assert not len(find_contacts(animation, UP, ContactParameters(shortest=5.0)).joints)
    assert find_contacts(animation, UP, ContactParameters(shortest=0.3)).share > 0.9


@pytest.mark.parametrize("name", ["height", "speed", "drift", "shortest", "window", "reach"])
def test_parameters_must_be_positive(name):
    with pytest.raises(ValueError, match=f"{name} is -1.0, but it must be a positive number"):
        ContactParameters(**{name: -1.0})


def test_lengths_grow_with_the_body_and_times_do_not():
    small, large = ContactParameters.for_size(1.0), ContactParameters.for_size(2.0)
    assert large == ContactParameters()
    assert small.height == pytest.approx(0.5 * large.height)
    assert small.shortest == large.shortest


def test_shares_and_seconds():
    animation, _ = walk()
    found = find_contacts(animation, UP)
    assert found.share == pytest.approx(1.0)  # while walking, one foot is on the ground at least
    assert found.seconds == pytest.approx(found.planted.sum() / 60.0)


def test_a_foot_that_slides_off_is_planted_only_near_where_it_rests():
    animation, _ = walk()
    translations = np.array(animation.translations)
    translations[:, 0, 2] += 0.16 * animation.times  # slow enough to be at rest, and 10 centimetres in a step
    animation = replace(animation, translations=translations)
    found = find_contacts(animation, UP)
    places = joint_matrices(animation)[..., 3]
    allowed = 0.015 * ContactParameters.for_size(body_size(places)).drift
    runs = 0
    for joint, planted in zip(found.joints, found.planted.T, strict=True):
        changes = np.flatnonzero(np.diff(np.concatenate([[0], planted, [0]])))
        for first, last in changes.reshape(-1, 2):
            runs += 1
            way = places[first : last + 1, joint]
            assert np.linalg.norm(way[-1] - way[0]) < 2.0 * allowed + 1e-9
    assert runs > 4
