"""Rates that few digits stand for."""

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal

import numpy as np
import pytest

from usd_tools.skel.frame_rates import NTSC, USUAL, exact_rate, frame_rate, rate_like


@pytest.mark.parametrize("rounding", [ROUND_DOWN, ROUND_HALF_EVEN])
@pytest.mark.parametrize("n_digits", [4, 5, 6, 7, 10, 17])
@pytest.mark.parametrize("rate", USUAL)
def test_usual_rates(rate, n_digits, rounding):
    assert frame_rate((1 / rate).quantize(Decimal(1).scaleb(-n_digits), rounding)) == rate


@pytest.mark.parametrize("rounding", [ROUND_DOWN, ROUND_HALF_EVEN])
@pytest.mark.parametrize("n_digits", [6, 7, 10, 17])
@pytest.mark.parametrize("rate", NTSC)
def test_rates_of_television_are_kept(rate, n_digits, rounding):
    assert frame_rate((1 / rate).quantize(Decimal(1).scaleb(-n_digits), rounding)) == float(rate)


@pytest.mark.parametrize("rate", [*USUAL, *NTSC])
def test_digits_of_floats(rate):
    for kind in (np.float32, np.float64):
        assert frame_rate(Decimal(repr(float(kind(1 / rate))))) == float(rate)


@pytest.mark.parametrize(
    ("written", "rate"),
    [
        (".0083333", 120.0),  # CMU
        (".03333", 30.0),
        ("0.008342", 120000 / 1001),
        ("0.033", 30.0),
        ("0.04", 25.0),
        ("0.02", 50.0),
        ("0.1", 10.0),
        ("0.0125", 80.0),
        ("1", 1.0),
        ("2.5", 0.4),
        ("0.006024", 166.0),
        ("0.0080645", 124.0),
        ("0.0123300", 1 / 0.01233),
        ("3.33333e-2", 30.0),
        ("0.033366700000000000000000000000000000001", 30000 / 1001),
    ],
)
def test_written(written, rate):
    assert frame_rate(Decimal(written)) == pytest.approx(rate, rel=1e-15)


@pytest.mark.parametrize(
    ("typed", "whole"),
    [
        *((23.976, 24), (23.98, 24), (23.97, 24), (23.9760, 24), (23.976024, 24), (29.97, 30), (29.97003, 30)),
        *((47.952, 48), (47.95, 48), (59.94, 60), (59.9401, 60), (119.88, 120), (119.8801, 120), (239.76, 240)),
        *((14.985, 15), (11.988, 12)),
    ],
)
def test_rates_of_television_as_they_are_typed(typed, whole):
    assert exact_rate(typed) == whole * 1000 / 1001
    assert exact_rate(exact_rate(typed)) == exact_rate(typed)
    assert exact_rate(float(np.float32(exact_rate(typed)))) == exact_rate(typed)


@pytest.mark.parametrize(
    "typed",
    [1, 12, 12.5, 23.9, 24, 24.0, 24.98, 25, 29.9, 29.98, 30, 33.333, 47.9, 48, 59.9, 60, 60.06, 120, 0.1, 1e300],
)
def test_other_rates_are_meant_as_they_are_typed(typed):
    assert exact_rate(typed) == typed


def test_rates_of_any_size_are_rates():
    for typed in (5e-324, 1e-7, 1e22):
        assert exact_rate(typed) == typed


@pytest.mark.parametrize(
    ("rate", "own", "like"),
    [
        *((60000 / 1001, 29.97, 59.94), (60000 / 1001, 30000 / 1001, 60000 / 1001), (24, 23.99998, 23.99998)),
        *((30, 24, 30), (60, 30000 / 1001, 60), (24000 / 1001, 24, 24000 / 1001), (25.0001, 25, 25.0001)),
        *((1e-9, 24, 1e-9), (1e9, 24, 1e9)),
    ],
)
def test_rates_in_the_digits_of_others(rate, own, like):
    assert rate_like(rate, own) == pytest.approx(like, rel=1e-15)
