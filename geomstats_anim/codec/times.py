"""Times in few bytes and bit for bit: ticks of a rate where they are that, else as they are."""

from __future__ import annotations

import zlib
from fractions import Fraction

import numpy as np

from geomstats_anim.codec.bytestream import Reader, StreamError, Writer
from geomstats_anim.rotations import Array

_SUBDIVISIONS = (1, 2, 4, 5, 8, 10, 100, 1000)
_LARGEST_TICK = 2**53
_EVEN, _UNEVEN, _VERBATIM = 0, 1, 2


def write_times(writer: Writer, times: Array) -> None:
    """Write times, shape=[F], in seconds.

    Parameters
    ----------
    writer : Writer
    times : array-like, shape=[F]
    """
    found = _ticks(times)
    if found is None:
        packed = zlib.compress(times.astype("<f8").view(np.uint8).reshape(-1, 8).T.tobytes(), 9)
        writer.number(_VERBATIM)
        writer.block(packed)
        return
    rate, ticks = found
    gaps = np.diff(ticks)
    is_even = bool((gaps == gaps[:1]).all())
    writer.number(_EVEN if is_even else _UNEVEN)
    writer.number(rate.numerator)
    writer.number(rate.denominator)
    writer.signed(int(ticks[0]) if len(ticks) else 0)
    if is_even:
        writer.number(int(gaps[0]) if len(gaps) else 1)
    else:
        runs = Writer()
        for gap in gaps.tolist():
            runs.number(gap)
        writer.block(zlib.compress(runs.getvalue(), 9))


def read_times(reader: Reader, n_frames: int) -> Array:
    """Read times, shape=[F].

    Raises
    ------
    StreamError
        If they are not increasing, finite and as many.
    """
    form = reader.number(2)
    if form == _VERBATIM:
        raw = np.frombuffer(_inflated(reader.block(), 8 * n_frames), dtype=np.uint8)
        if len(raw) != 8 * n_frames:
            raise StreamError("The stream is damaged: it has too few times.")
        times = raw.reshape(8, n_frames).T.copy().view("<f8")[:, 0].astype(np.float64)
    else:
        rate = reader.number(_LARGEST_TICK) / max(reader.number(_LARGEST_TICK), 1)
        first = reader.signed(_LARGEST_TICK)
        if form == _EVEN:
            gap = reader.number(_LARGEST_TICK)
            ticks = first + gap * np.arange(n_frames, dtype=np.float64)
        else:
            runs = Reader(_inflated(reader.block(), 8 * n_frames))
            gaps = [runs.number(_LARGEST_TICK) for _ in range(n_frames - 1)]
            ticks = np.cumsum([first, *gaps], dtype=np.float64)
        if not rate:
            raise StreamError("The stream is damaged: its rate is not positive.")
        times = _seconds(ticks, rate)
    if not np.isfinite(times).all() or (times[1:] <= times[:-1]).any():
        raise StreamError("The stream is damaged: its times do not increase.")
    return times


def _inflated(packed: bytes, limit: int) -> bytes:
    """Decompress to at most `limit` bytes."""
    try:
        return zlib.decompressobj().decompress(packed, max(limit, 1))
    except zlib.error as error:
        raise StreamError("The stream is damaged: its times cannot be read.") from error


def _seconds(ticks: Array, rate: float) -> Array:
    return ticks / rate


def _ticks(times: Array) -> tuple[Fraction, np.ndarray] | None:
    """Return a rate and whole ticks that give exactly these times, None if there are none."""
    if len(times) < 2:
        usual = 1.0
    else:
        usual = 1.0 / float(np.median(np.diff(times)))
    if not np.isfinite(usual):
        return None
    rounded = Fraction(f"{usual:.10g}")
    rates = {rounded: None, Fraction(usual).limit_denominator(1001): None}
    for factor in _SUBDIVISIONS:
        for rate in rates:
            finer = rate * factor
            if finer <= 0 or finer.numerator > _LARGEST_TICK or finer.denominator > _LARGEST_TICK:
                continue
            ticks = np.rint(times * float(finer))
            if np.abs(ticks).max(initial=0.0) < _LARGEST_TICK and np.array_equal(_seconds(ticks, float(finer)), times):
                return finer, ticks.astype(np.int64)
    return None
