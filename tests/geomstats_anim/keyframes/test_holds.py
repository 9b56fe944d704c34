"""A pose that stays is a hold from a quarter of a second on; shorter, it is animation on twos or threes."""

import numpy as np
import pytest

from geomstats_anim import Animation, Skeleton, optimal_keyframes
from geomstats_anim import rotations as quat

RATE = 60.0
PAUSE = 30  # frame at which the motion pauses


def paused(n_frames_of_pause):
    """A turn of one joint that pauses for a number of frames."""
    skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    progress = np.r_[np.arange(PAUSE), np.full(n_frames_of_pause, PAUSE), np.arange(PAUSE, 2 * PAUSE)]
    turns = quat.exp(np.stack([0.01 * progress, 0.0 * progress, 0.0 * progress], axis=-1))[:, None]
    return Animation(skeleton, np.arange(len(progress)) / RATE, turns, np.zeros((len(progress), 1, 3)))


@pytest.mark.parametrize("seconds", [0.05, 0.1, 0.2, 0.24])
def test_a_short_pause_is_no_hold(seconds):
    animation = paused(round(seconds * RATE))
    np.testing.assert_array_equal(optimal_keyframes(animation, count=2), [0, animation.n_frames - 1])


@pytest.mark.parametrize("seconds", [0.26, 0.5, 2.0])
def test_a_long_pause_is_a_hold_whose_ends_are_keys(seconds):
    n_frames_of_pause = round(seconds * RATE)
    animation = paused(n_frames_of_pause)
    keys = optimal_keyframes(animation, count=4)
    np.testing.assert_array_equal(keys, [0, PAUSE, PAUSE + n_frames_of_pause, animation.n_frames - 1])
    with pytest.raises(ValueError, match="4 of"):
        optimal_keyframes(animation, count=3)
