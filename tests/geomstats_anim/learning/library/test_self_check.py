import numpy as np
from gaits import biped

from geomstats_anim import rotations as quat
from geomstats_anim.learning.library.parts import body_parts
from geomstats_anim.learning.library.self_check import SHARES, HiddenPoses, best_shares

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


def test_what_is_missed_is_taken_whole_and_its_opposite_not_at_all():
    splines, missed = hidden()
    truth = quat.multiply(splines, quat.exp(missed))
    np.testing.assert_array_equal(shares(splines, missed, truth), 1.0)
    np.testing.assert_array_equal(shares(splines, -missed, truth), 0.0)
    np.testing.assert_array_equal(shares(splines, 0.0 * missed, truth), 0.0)


def test_twice_of_it_is_halved():
    splines, missed = hidden()
    truth = quat.multiply(splines, quat.exp(missed))
    found = shares(splines, 2.0 * missed, truth)
    assert (abs(found - 0.5) <= 0.1 + 1e-12).all()


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
