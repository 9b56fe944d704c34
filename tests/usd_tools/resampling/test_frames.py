"""Whole frames of a rate, and the samples that are taken there."""

import numpy as np
import pytest

from usd_tools.resampling.frames import at_frames, whole_frames
from usd_tools.skel.channels import Channel

NTSC = 30000 / 1001


@pytest.mark.parametrize(
    ("first", "last", "fps", "rate", "expected"),
    [
        (0, 8, 30, 120, [0, 4, 8]),
        (0, 5, 24, 30, [0, 1.25, 2.5, 3.75, 5]),
        (1, 5, 24, 30, [1.25, 2.5, 3.75, 5]),
        (-3, 3, 60, 30, np.arange(-6, 7) / 2),
        (0, 2, 60, 37.5, [0, 0.625, 1.25, 1.875]),
        (0, 2, 24, 23.99998, [0, 1, 2]),
        (0, 2, NTSC, 29.97, [0, 1, 2]),
        (0.001, 1.999, 24, 24, [0, 1, 2]),
    ],
)
def test_frames_of_a_range(first, last, fps, rate, expected):
    np.testing.assert_allclose(whole_frames(first, last, fps, rate), expected, atol=1e-12)


def test_television_and_whole_rates_differ():
    codes = whole_frames(0, 30000, 30, NTSC)
    assert len(codes) == 30031
    np.testing.assert_allclose(codes[::1001], np.arange(0, 30001, 1000), rtol=1e-12)


def channel(codes, numbers):
    blocked = np.array([number is None for number in numbers])
    values = np.array([number or 0 for number in numbers], dtype=np.float32)[:, None, None]
    return Channel("blendShapeWeights", np.array(codes, dtype=float), values, blocked, values[0], "a.usda")


def test_a_block_is_written_once_and_ends_where_samples_begin():
    dense = channel([0, 1, 2, 2.5, 6, 8], [1, 2, 3, None, 7, 9])
    taken = at_frames(dense, np.arange(0.0, 10.0, 2.0))
    assert taken.codes.tolist() == [0, 2, 4, 6, 8]
    assert taken.blocked.tolist() == [False, False, True, False, False]
    assert taken.values[:, 0, 0].tolist() == [1, 3, 0, 7, 9]
    longer = at_frames(channel([0, 2, 3, 8], [1, 2, None, 4]), np.arange(0.0, 10.0))
    assert longer.codes.tolist() == [0, 1, 2, 3, 8, 9]


def test_frames_outside_the_samples_hold_them():
    taken = at_frames(channel([2, 4], [5, 6]), np.arange(0.0, 8.0, 2.0))
    assert taken.values[:, 0, 0].tolist() == [5, 5, 6, 6]
