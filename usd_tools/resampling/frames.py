"""Samples at the whole frames of a rate, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usd_tools.skel.channels import Channel
from usd_tools.skel.frame_rates import rate_like
from usd_tools.skel.resampling import SNAP, SNAP_OF_FRAME


def whole_frames(first: float, last: float, fps: float, codes_per_second: float) -> np.ndarray:
    """Return the time codes of the whole frames of a rate in a range; time code 0 is one of them.

    Parameters
    ----------
    first, last : float
        Time codes; a frame that misses the range by less than a hundredth of a frame belongs to it.
    fps : float
        Frames per second, taken in the digits of `codes_per_second`.
    codes_per_second : float

    Returns
    -------
    codes : array-like, shape=[F]
    """
    rate = rate_like(fps, codes_per_second)
    start = np.ceil(first * rate / codes_per_second - SNAP_OF_FRAME)
    stop = np.floor(last * rate / codes_per_second + SNAP_OF_FRAME)
    return np.arange(start, stop + 1.0) * codes_per_second / rate


def nearest_share(frames: np.ndarray) -> float:
    """Return how far from a frame, in time codes, a sample may be that is taken for that frame's."""
    return SNAP * float(np.diff(frames).min(initial=np.inf)) if len(frames) > 1 else 0.0


def at_frames(channel: Channel, frames: np.ndarray) -> Channel:
    """Take the sample at each frame, or the last before it.

    Parameters
    ----------
    channel : Channel
        With a sample at each of the frames that it moves at.
    frames : array-like, shape=[F]
        Time codes, increasing.

    Returns
    -------
    channel : Channel
        A value block is at the first frame within it only, as USD has it.
    """
    last = np.maximum(np.searchsorted(channel.codes, frames + nearest_share(frames), side="right") - 1, 0)
    blocked = channel.blocked[last]
    kept = ~blocked | (np.diff(last, prepend=-1) != 0)
    last = last[kept]
    return replace(channel, codes=frames[kept], values=channel.values[last], blocked=channel.blocked[last])
