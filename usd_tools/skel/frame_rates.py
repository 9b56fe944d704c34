"""Exact frame rates, from rates and frame times that people and files give with few digits."""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction

from usd_tools.console.arguments import positive_number

USUAL = tuple(map(Decimal, (12, 15, 24, 25, 30, 48, 50, 60, 72, 90, 96, 100, 120, 144, 150, 180, 200, 240)))
"""Rates that cameras and motion capture record at."""

NTSC = tuple(Decimal(1000 * rate) / 1001 for rate in (12, 15, 24, 30, 48, 60, 96, 120, 240))
"""Those of American television: 23.976, 29.97, and so on."""

SINGLE_PRECISION = Decimal("1e-6")
"""Relative difference that single precision, and a few digits more, leave in a number."""

_SIMPLE = 100
"""Largest denominator of a simple fraction; 1001 / 1000, which is 30 over 29.97, is none."""


def exact_rate(rate: float) -> float:
    """Return the rate that people mean who give it with few digits.

    Rates of television are written in two decimals or more: 23.976, 23.98 and 23.97 are 24000 / 1001, and 29.97 is
    30000 / 1001. All others are meant as they are written, 24, 30 and 23.9 among them.

    Parameters
    ----------
    rate : float
        Frames per second.

    Returns
    -------
    rate : float
    """
    written = Decimal(repr(float(rate)))
    if int(written.as_tuple().exponent) > -2:
        return float(rate)
    return float(next((exact for exact in NTSC if _comes_to(exact, written)), rate))


def typed_rate(text: str) -> float:
    """Parse a rate that people type, as `exact_rate` does; the type of every option for a rate."""
    return exact_rate(positive_number(text))


def rate_like(rate: float, own: float) -> float:
    """Return a rate in the digits of another that it is a simple multiple or part of.

    Beside 29.97, 60000 / 1001 is 59.94, and 24 is 23.99998 beside that: so frames of both coincide however long
    a clip is.

    Parameters
    ----------
    rate : float
        Frames per second, exact.
    own : float
        Frames per second, as a file has it.

    Returns
    -------
    rate : float
    """
    ratio = Fraction(rate / exact_rate(own)).limit_denominator(_SIMPLE)
    is_near = abs(float(ratio) * exact_rate(own) - rate) <= float(SINGLE_PRECISION) * rate
    return own * float(ratio) if is_near else rate


def frame_rate(frame_time: Decimal) -> float:
    """Return the rate whose frame time is rounded, or cut off, to the given digits.

    Of rates that come to the same digits, a usual one is taken before one of television, and that before any whole one:
    0.0083333 is 120, 0.0333667 is 30000 / 1001. Where there is none, the digits are taken by the word.

    Parameters
    ----------
    frame_time : Decimal
        Seconds per frame, with the digits of the file.

    Returns
    -------
    rate : float
        Frames per second.
    """
    written = Context(prec=17).plus(frame_time)
    whole = max(Decimal(1), (1 / written).to_integral_value())
    if _is_near(1 / whole, written):
        return float(whole)
    for rates in (USUAL, NTSC, (whole,)):
        fitting = [rate for rate in rates if _comes_to(1 / rate, written)]
        if fitting:
            return float(min(fitting, key=lambda rate: abs(1 / rate - written)))
    return float(1 / frame_time)


def _comes_to(exact: Decimal, written: Decimal) -> bool:
    """Return whether a number has the written digits, be they rounded or cut off."""
    last_digit = Decimal(1).scaleb(int(written.as_tuple().exponent))
    return _is_near(exact, written) or -last_digit / 2 <= exact - written < last_digit


def _is_near(exact: Decimal, written: Decimal) -> bool:
    return abs(exact - written) <= SINGLE_PRECISION * written
