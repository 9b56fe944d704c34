"""Laws of the low-pass filters."""

import numpy as np
import pytest

from geomstats_anim import rotations as quat
from geomstats_anim.filtering import low_pass, low_pass_rotations

RATE, CUTOFF = 120.0, 12.0
SECONDS = np.arange(600) / RATE
AXIS = np.array([0.8, 0.36, 0.48])


def slow_motion():
    """Return rotations that turn far, but with nothing faster than one hertz."""
    return quat.exp(np.stack([1.5 * np.sin(2 * SECONDS), np.cos(3 * SECONDS), 1.9 * np.sin(1.3 * SECONDS)], axis=-1))


def decibels(error, reference):
    inside = slice(60, -60)
    return 20.0 * np.log10(np.sqrt((error[inside] ** 2).mean() / (reference[inside] ** 2).mean()))


@pytest.mark.parametrize("hertz", [15.0, 18.0, 31.0, 59.0])
def test_fast_motion_is_gone_and_slow_motion_is_left(hertz):
    slow = slow_motion()
    shaken = quat.multiply(slow, quat.exp(0.05 * np.sin(2 * np.pi * hertz * SECONDS)[:, None] * AXIS))
    filtered = low_pass_rotations(shaken, RATE, CUTOFF)
    assert decibels(quat.distance(filtered, slow), quat.distance(shaken, slow)) < -27.0
    assert quat.distance(low_pass_rotations(slow, RATE, CUTOFF), slow).max() < 1e-3


def test_half_of_the_amplitude_is_left_at_the_cutoff():
    wave = np.sin(2 * np.pi * CUTOFF * SECONDS)
    assert decibels(low_pass(wave, RATE, CUTOFF), wave) == pytest.approx(-6.02, abs=0.05)
    turning = quat.exp(0.05 * wave[:, None] * AXIS)
    filtered = quat.log(low_pass_rotations(turning, RATE, CUTOFF))
    assert decibels(np.linalg.norm(filtered, axis=-1), 0.05 * wave) == pytest.approx(-6.02, abs=0.05)


def test_about_one_axis_it_is_the_filter_of_the_angle():
    """A turn by many revolutions is no obstacle, as quaternions never say how many."""
    angles = 4.0 * np.pi * SECONDS + 0.02 * np.sin(2 * np.pi * 40.0 * SECONDS)
    filtered = low_pass_rotations(quat.exp(angles[:, None] * AXIS), RATE, CUTOFF)
    expected = quat.exp(low_pass(angles, RATE, CUTOFF)[:, None] * AXIS)
    assert quat.distance(filtered, expected)[60:-60].max() < 2e-4


def test_turning_all_rotations_turns_the_result():
    rng = np.random.default_rng(0)
    shaken = quat.multiply(slow_motion(), quat.exp(rng.normal(0.0, 0.03, (600, 3))))
    left, right = quat.normalize(rng.normal(size=(2, 4)))
    turned = quat.multiply(quat.multiply(left, shaken), right)
    expected = quat.multiply(quat.multiply(left, low_pass_rotations(shaken, RATE, CUTOFF)), right)
    assert quat.distance(low_pass_rotations(turned, RATE, CUTOFF), expected).max() < 1e-12


def test_backwards_is_the_same_backwards():
    rng = np.random.default_rng(1)
    values = np.cumsum(rng.normal(size=(200, 2, 3)), axis=0)
    np.testing.assert_allclose(low_pass(values[::-1], RATE, 9.0), low_pass(values, RATE, 9.0)[::-1], atol=1e-3)
    straight = np.linspace(0.0, 7.0, 50)
    np.testing.assert_allclose(low_pass(straight, RATE, 9.0), straight, atol=1e-3)


@pytest.mark.parametrize("n_frames", [1, 2, 3, 5])
def test_short_motion_and_signs(n_frames):
    poses = slow_motion()[:n_frames, None] * np.where(np.arange(n_frames) % 2, -1.0, 1.0)[:, None, None]
    filtered = low_pass_rotations(poses, RATE, CUTOFF)
    assert filtered.shape == (n_frames, 1, 4)
    assert np.abs(np.linalg.norm(filtered, axis=-1) - 1.0).max() < 1e-14
    assert quat.distance(filtered, poses).max() < 0.02
    still = np.tile(poses[:1], (n_frames, 1, 1))
    assert quat.distance(low_pass_rotations(still, RATE, CUTOFF), still).max() < 1e-12


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 60.0, 100.0, np.nan])
def test_a_cutoff_beyond_the_rate_is_refused(cutoff):
    with pytest.raises(ValueError, match="cutoff must be between 0 and 60 Hz"):
        low_pass(SECONDS, RATE, cutoff)
