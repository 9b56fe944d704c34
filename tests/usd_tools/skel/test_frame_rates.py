"""Rates that few digits stand for."""

from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal

import numpy as np
import pytest

from usd_tools.skel.frame_rates import NTSC, USUAL, frame_rate


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
