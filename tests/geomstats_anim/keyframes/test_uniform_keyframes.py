"""Which frames are kept."""

import numpy as np
import pytest

from geomstats_anim import uniform_keyframes


@pytest.mark.parametrize("rate", [1e-6, 0.05, 0.1, 0.3, 0.5, 0.77, 1.0])
@pytest.mark.parametrize("n_frames", [2, 3, 10, 101, 20_000])
def test_number_ends_and_spacing(n_frames, rate):
    keys = uniform_keyframes(n_frames, rate)
    assert len(keys) == max(2, round(rate * n_frames))
    assert (keys[0], keys[-1]) == (0, n_frames - 1)
    steps = np.diff(keys)
    assert steps.min() >= 1
    assert steps.max() - steps.min() <= 1
    assert np.issubdtype(keys.dtype, np.integer)


def test_all_frames():
    np.testing.assert_array_equal(uniform_keyframes(7, 1.0), np.arange(7))


@pytest.mark.parametrize("n_frames", [1, 0, -3])
def test_too_few_frames(n_frames):
    with pytest.raises(ValueError, match=f"^Keys need at least 2 frames, but there are {n_frames}[.]$"):
        uniform_keyframes(n_frames, 0.5)


@pytest.mark.parametrize("rate", [0.0, -0.1, 1.1, float("nan")])
def test_nonsense_rates(rate):
    with pytest.raises(ValueError, match=f"^The rate must be above 0 and at most 1, but it is {rate}[.]$"):
        uniform_keyframes(10, rate)
