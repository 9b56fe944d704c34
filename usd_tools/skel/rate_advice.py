"""Advice about frame rates: where samples fall between frames, and where a player ignores the rate of a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from usd_tools.skel.frame_rates import NTSC, USUAL

_SLOWEST, _FASTEST = 12.0, 1000.0
"""Frames per second at which somebody steps through a motion."""

_MULTIPLES = 24
"""Multiples of the stage's rate that are tried; among many more, some would fit any few samples by chance."""


def written_at(path: Path, rate: float) -> str:
    """Return the sentence about a written file and its frame rate in Blender.

    Parameters
    ----------
    path : Path
    rate : float
        Time codes per second.
    """
    return (
        f"Wrote {path} ({rate:g} time codes per second). Blender ignores this rate; set the scene's frame rate to "
        f"{rate:g}."
    )


def between_frames(codes: np.ndarray, rate: float, frames_per_second: float | None) -> str:
    """Advise on a rate at which every sample is a whole frame; "" where it is one already, or no rate helps.

    Parameters
    ----------
    codes : array-like, shape=[F]
        Time codes of samples, increasing.
    rate : float
        Time codes per second.
    frames_per_second : float or None
        Rate at which the stage asks to be played.
    """
    if len(codes) < 2 or _are_whole(codes):
        return ""
    better = whole_frame_rate(codes / rate, rate, frames_per_second)
    if better is None:
        return ""
    return f"Some samples fall between frames; use --fps {better:g} --retime to make each a whole frame."


def whole_frame_rate(seconds: np.ndarray, rate: float, frames_per_second: float | None) -> float | None:
    """Find the lowest rate at which every sample is a whole frame; the stage's own, if it is one, comes first.

    Parameters
    ----------
    seconds : array-like, shape=[F]
        Times of samples, increasing.
    rate : float
        Time codes per second; its multiples are tried, and the rates of cameras.
    frames_per_second : float or None
        Rate at which the stage asks to be played.

    Returns
    -------
    rate : float or None
        Frames per second; None if there is none up to 1000.
    """
    multiples = rate * np.arange(1, _MULTIPLES + 1)
    sampled = np.round(1.0 / np.median(np.diff(seconds)))
    plain = sorted({*multiples.tolist(), float(sampled), *map(float, USUAL)})
    # those of television last, as a few frames of 24 are as good as whole at 23.976
    rates = [each for each in (*plain, *map(float, NTSC)) if _SLOWEST <= each <= _FASTEST]
    authored = [] if frames_per_second is None else [frames_per_second]
    return next((each for each in (*authored, *rates) if _are_whole(seconds * each)), None)


def _are_whole(frames: np.ndarray) -> bool:
    """Return whether numbers are whole, up to single precision and the digits in which a rate is printed."""
    return bool(np.abs(frames - np.round(frames)).max() < 1e-2)
