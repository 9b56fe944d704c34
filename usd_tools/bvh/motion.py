"""The second part of a BVH file: a table with a row per frame and a column per channel."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation

import numpy as np

from usd_tools.bvh.lines import LARGEST, LineError, check_decimal_points, is_number, quoted
from usd_tools.skel.frame_rates import frame_rate

_CHUNK = 1 << 17
"""Numbers that are parsed at once: few enough to need little memory beside the table."""


def read_motion(
    lines: Sequence[str], start: int, n_channels: int, rate: float | None, warn: Callable[[str], None]
) -> tuple[float, np.ndarray]:
    """Read the lines after MOTION.

    Parameters
    ----------
    lines : sequence of str
        Of the whole file.
    start : int
        How many of them the hierarchy takes.
    n_channels : int
    rate : float or None
        Frames per second; what the file says of it is then not looked at.
    warn : callable
        Told, in a sentence, if there is a row more or less than the file says.

    Returns
    -------
    rate : float
        Frames per second.
    table : array-like, shape=[F, C]

    Raises
    ------
    LineError
        If they are broken.
    """
    full = [k for k in range(start, len(lines)) if lines[k].strip()]
    n_frames, n_read = _frame_count(lines, full), 1
    if rate is None:
        rate, n_read = frame_rate(_frame_time(lines, full)), 2
    elif len(full) > 1 and re.match(r"\s*Frame\s+Time\b", lines[full[1]], re.IGNORECASE):
        n_read = 2
    rows, said = full[n_read:], f"{n_frames} frames of line {full[0] + 1}"
    # A row more or less is what exporters write that count from the other end; more is a file that lost something.
    if len(rows) > n_frames + 1:
        raise LineError(rows[n_frames] + 1, f"this comes after the {said}; correct one of them.")
    table = _read_table(lines, rows, n_channels)
    if len(rows) < max(1, n_frames - 1):
        raise LineError(len(lines), f"the file ends after {len(rows)} of the {said}; correct one of them.")
    if len(rows) != n_frames:
        warn(f"line {full[0] + 1}: Frames says {n_frames}, but the file has {len(rows)}; all {len(rows)} are read.")
    return rate, table


def _value(lines: Sequence[str], full: Sequence[int], place: int, name: str) -> tuple[int, str]:
    """Return what follows a name and a colon, and the number of the line."""
    if place >= len(full):
        raise LineError(len(lines), f"the file ends where {name} is expected; it is cut short.")
    number, line = full[place] + 1, lines[full[place]].strip()
    found = re.fullmatch(name.replace(" ", r"\s+") + r"\s*:\s*(\S+)", line, re.IGNORECASE)
    if not found:
        raise LineError(number, f"expected {name} and a number, but found {quoted(line)!r}.")
    return number, found.group(1)


def _frame_count(lines: Sequence[str], full: Sequence[int]) -> int:
    number, word = _value(lines, full, 0, "Frames")
    if not re.fullmatch("0*[1-9][0-9]{0,17}", word):
        raise LineError(number, f"Frames must be a whole number of at least 1, not {quoted(word)}; correct it.")
    return int(word)


def _frame_time(lines: Sequence[str], full: Sequence[int]) -> Decimal:
    number, word = _value(lines, full, 1, "Frame Time")
    check_decimal_points(number, [word])
    try:
        seconds = Decimal(word)
    except InvalidOperation:
        seconds = Decimal(0)
    if not (seconds.is_finite() and 1e-6 <= seconds <= 1e6):
        raise LineError(
            number,
            f"Frame Time must be a positive number of seconds, not {quoted(word)}; correct it, or give the rate with "
            "--fps.",
        )
    return seconds


def _read_table(lines: Sequence[str], rows: Sequence[int], n_channels: int) -> np.ndarray:
    table = np.empty((len(rows), n_channels))
    step = max(1, _CHUNK // max(1, n_channels))
    for first in range(0, len(rows), step):
        chunk = rows[first : first + step]
        try:
            numbers = np.loadtxt([lines[k] for k in chunk], ndmin=2, comments=None)
        except ValueError:
            numbers = np.empty((0, 0))
        if numbers.shape != (len(chunk), n_channels) or not (np.abs(numbers) <= LARGEST).all():
            for k in chunk:
                _check_row(k + 1, lines[k].split(), n_channels)
        table[first : first + step] = numbers
    return table


def _check_row(number: int, words: list[str], n_channels: int) -> None:
    """Raise an error that says what is wrong with a row, if something is."""
    check_decimal_points(number, words)
    if len(words) != n_channels:
        raise LineError(number, f"{len(words)} numbers for {n_channels} channels; repair the file.")
    for word in words:
        if not is_number(word):
            raise LineError(number, f"{quoted(word)} is no finite number; repair the file.")
