import numpy as np
import pytest
from gaits import biped

from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import place
from geomstats_anim.learning.library.parts import body_parts
from geomstats_anim.learning.library.self_check import SHARES, HiddenPoses, best_shares, spread

SKELETON = biped()
PARTS = body_parts(SKELETON)


def hidden(n=40):
    """Make splines at hidden keys, and what they miss."""
    rng = np.random.default_rng(0)
    splines = quat.exp(0.4 * rng.normal(size=(n, SKELETON.n_joints, 3)))
    return splines, 0.1 * rng.normal(size=(n, SKELETON.n_joints, 3))


def shares(splines, residuals, truth, doubt=0.0):
    doubts = np.full((len(PARTS.joints), len(SHARES), 2), doubt)
    return best_shares(HiddenPoses(SKELETON, PARTS, splines, residuals, truth), doubts)


def test_errors_are_angles_and_distances_of_bone_ends():
    splines, missed = hidden(7)
    truth = quat.multiply(splines, quat.exp(missed[::-1]))
    poses, rest = HiddenPoses(SKELETON, PARTS, splines, missed, truth), np.tile(SKELETON.rest_translations, (7, 1, 1))
    limbs = np.array([0.2, 0.0, 1.0, 0.6])
    for s, share in enumerate(SHARES):
        for of_torso, of_rest in ((0.0, share), (share, None)):
            shares = np.full(SKELETON.n_joints, of_torso)
            for limb, joints in zip(limbs, PARTS.joints[1:], strict=True):
                shares[joints] = limb if of_rest is None else of_rest
            turned = quat.multiply(splines, quat.exp(shares[:, None] * missed))
            angles = quat.distance(turned, truth)
            ends = [place(SKELETON, each, rest).ends for each in (turned, truth)]
            distances = np.linalg.norm(ends[0] - ends[1], axis=-1)
            if of_rest is None:
                found = poses.of_torso(limbs)[:, 0, s]
                expected = [angles[:, PARTS.joints[0]].mean(axis=-1), distances.mean(axis=-1)]
            else:
                found = poses.of_limbs()[:, :, s]
                expected = [
                    [each[:, joints].mean(axis=-1) for joints in PARTS.joints[1:]] for each in (angles, distances)
                ]
            np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_is_missed_is_taken_whole_and_its_opposite_not_at_all():
    splines, missed = hidden()
    truth = quat.multiply(splines, quat.exp(missed))
    np.testing.assert_array_equal(shares(splines, missed, truth), 1.0)
    np.testing.assert_array_equal(shares(splines, -missed, truth), 0.0)
    np.testing.assert_array_equal(shares(splines, 0.0 * missed, truth), 0.0)


def test_twice_of_it_is_halved():
    splines, missed = hidden()
    truth, residuals = quat.multiply(splines, quat.exp(missed)), missed.copy()
    residuals[:, PARTS.joints[2]] *= 2.0
    found = shares(splines, residuals, truth)
    assert abs(found[2] - 0.5) <= 0.1 + 1e-12
    np.testing.assert_array_equal(np.delete(found, 2), 1.0)


def test_where_few_parts_are_helped_these_have_less_of_it():
    splines, missed = hidden()
    missed[:, PARTS.joints[0]] *= 3.0
    truth, angles = quat.multiply(splines, quat.exp(missed)), np.linalg.norm(missed, axis=-1).mean(axis=0)
    of_parts = np.array([angles[joints].mean() for joints in PARTS.joints])
    for helped in ([0], [0, 4], [1, 2], [0, 1, 2, 3, 4]):
        residuals = np.zeros_like(missed)
        for part in helped:
            residuals[:, PARTS.joints[part]] = missed[:, PARTS.joints[part]]
        expected = np.zeros(len(of_parts))
        expected[helped] = min(1.0, of_parts[helped].sum() / of_parts.sum() / 0.75)
        np.testing.assert_allclose(shares(splines, residuals, truth), expected, atol=1e-9)


def test_parts_are_judged_apart():
    splines, missed = hidden()
    truth, residuals = quat.multiply(splines, quat.exp(missed)), missed.copy()
    residuals[:, PARTS.joints[3]] *= -1.0
    assert shares(splines, residuals, truth).tolist() == [1.0, 1.0, 1.0, 0.0, 1.0]


def test_a_limb_that_gains_angles_but_moves_its_ends_away_stays():
    splines = np.tile(quat.IDENTITY, (40, SKELETON.n_joints, 1))
    missed = np.zeros((40, SKELETON.n_joints, 3))
    missed[:, 0, 0], missed[:, 10, 0] = 0.2, -0.2  # the hips turn, and a thigh turns back: the foot is nearly right
    residuals = np.zeros_like(missed)
    residuals[:, 10] = missed[:, 10]
    assert shares(splines, residuals, quat.exp(missed)).tolist() == [0.0] * 5


def test_a_gain_of_few_keys_is_doubted():
    splines, missed = hidden()
    truth = quat.multiply(splines, quat.exp(missed))
    weak = 0.12 * missed
    assert shares(splines, weak, truth).all()
    assert not shares(splines[:3], weak[:3], truth[:3]).any()


def test_a_gain_that_is_doubted_needs_to_be_larger():
    splines, missed = hidden()
    truth = quat.multiply(splines, quat.exp(missed))
    assert (shares(splines, missed, truth, 0.1) == 1.0).all()
    assert not shares(splines, missed, truth, 9.0).any()


def test_a_gain_that_varies_from_key_to_key_is_used_less():
    splines, missed = hidden()
    truth, rng = quat.multiply(splines, quat.exp(missed)), np.random.default_rng(1)
    steady, unsure = 0.2 * np.ones((40, 1, 1)), 0.2 + 2.0 * rng.permutation(np.repeat([-1.0, 1.0], 20))[:, None, None]
    assert (shares(splines, steady * missed, truth, 0.4) == 1.0).all()
    assert (shares(splines, unsure * missed, truth, 0.4) < 0.5).all()


@pytest.mark.parametrize("n", [21, 50, 64, 1000])
def test_few_of_many_are_spread_over_all_and_over_the_phases_of_a_walk(n):
    chosen = spread(n, 20)
    assert 0.75 * 20 <= len(chosen) <= 20 and (np.diff(chosen) > 0).all() and chosen[-1] < n
    assert np.diff([0, *chosen, n]).max() <= 0.15 * n + 1
    for period in range(2, 8):
        assert np.bincount(chosen % period, minlength=period).max() <= 1.0 + 2.0 * len(chosen) / period
    np.testing.assert_array_equal(spread(20, 20), np.arange(20))
