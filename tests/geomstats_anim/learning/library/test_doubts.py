"""Doubts: what the self-check does not see, learned from actions that are left out."""

import numpy as np
from gaits import biped, gait, library

from geomstats_anim.learning.library.doubts import LeftOut, doubts_of, errors_left_out
from geomstats_anim.learning.library.parts import body_parts
from geomstats_anim.learning.library.samples import samples_of
from geomstats_anim.learning.library.self_check import SHARES

PARTS = body_parts(biped())
UP = np.array([0.0, 1.0, 0.0])


def falling(slope, deviation=0.5, n_clips=40):
    """Make ratios that fall by a slope times the share, and vary as much times the share from segment to segment."""
    shape = (n_clips, len(PARTS.joints), len(SHARES), 2)
    ratios, deviations = (np.broadcast_to(each[:, None], shape) for each in (1.0 - slope * SHARES, deviation * SHARES))
    return LeftOut(ratios.copy(), deviations)


def test_what_is_lost_between_the_check_and_the_gap_is_doubted_in_deviations():
    for deviation in (0.5, 0.25):
        doubts = doubts_of(falling(0.1), falling(0.4, deviation))
        np.testing.assert_allclose(doubts[:, 1:], 0.3 / deviation)


def test_nothing_is_doubted_where_the_check_is_the_stricter():
    assert not doubts_of(falling(0.5), falling(0.4))[:, 1:].any()


def test_clips_that_the_check_refuses_tell_nothing():
    at_gap, at_double = falling(0.1), falling(0.4)
    at_gap.ratios[::2, :, 1:], at_double.ratios[::2, :, 1:] = 9.0, 1.5
    np.testing.assert_allclose(doubts_of(at_gap, at_double), doubts_of(falling(0.1), falling(0.4)), atol=1e-3)


def test_without_evidence_there_is_some_doubt():
    prior = doubts_of(falling(0.1), None)
    assert (prior > 0.0).all()
    for refused in (falling(-0.4), falling(0.4, 0.0)):  # harmful, or told by a single segment
        np.testing.assert_allclose(doubts_of(falling(0.1), refused), prior)


def test_ratios_are_those_of_the_clip_with_what_is_predicted():
    clips = [gait(seed) for seed in (1, 2)]
    samples = samples_of(clips, 8, PARTS.trunk, UP)
    for scale, expected in ((1.0, 1.0 - SHARES), (-1.0, 1.0 + SHARES)):
        left_out = errors_left_out(samples, scale * samples.sines, biped(), PARTS, np.random.default_rng(0))
        assert left_out.ratios.shape == left_out.deviations.shape == (2, 5, len(SHARES), 2)
        np.testing.assert_allclose(left_out.ratios[..., 0], np.broadcast_to(expected, (2, 5, len(SHARES))), atol=1e-6)
        ratio = np.broadcast_to(left_out.deviations[:, :, 1:2], left_out.deviations.shape) * SHARES[:, None] / SHARES[1]
        np.testing.assert_allclose(left_out.deviations[..., 0], ratio[..., 0], atol=1e-6)


def test_a_library_doubts_what_it_learned_by_leaving_actions_out():
    doubts = library().models[0].doubts
    assert doubts.shape == (5, len(SHARES), 2) and (doubts >= 0.0).all()
