"""Thin the weights of blend shapes by a tolerance of their own: every viewer interpolates them linearly."""

from __future__ import annotations

import numpy as np

from usd_tools.skel.channels import STEP_SECONDS, Channel
from usd_tools.skel.clip import SkelClip

WEIGHTS = "blendShapeWeights"


def fewest_keys(times: np.ndarray, values: np.ndarray, tolerance: float) -> np.ndarray:
    """Choose the fewest samples from which linear interpolation gives all others within a tolerance.

    This is a breadth-first search: of the samples that k segments lead to, for k = 1, 2, ..., until the last is among
    them.

    Parameters
    ----------
    times : array-like, shape=[F]
        Increasing.
    values : array-like, shape=[F, N]
    tolerance : float
        Largest difference of any value; 0 or more.

    Returns
    -------
    frames : array-like of int, shape=[K]
        Increasing, the first and the last among them.
    """
    before = np.full(len(times), -1)
    frontier = np.zeros(1, dtype=np.intp)
    while before[-1] < 0:
        frontier = _reached(times, values, tolerance, frontier, before)
    frames = [len(times) - 1]
    while frames[-1] > 0:
        frames.append(int(before[frames[-1]]))
    return np.array(frames[::-1])


def _reached(
    times: np.ndarray, values: np.ndarray, tolerance: float, starts: np.ndarray, before: np.ndarray
) -> np.ndarray:
    """Return the samples that one segment leads to from some, if none led there yet; enter where it starts.

    A segment is near the samples that it passes if its slope is in the cone of slopes that pass each of them.
    """
    low = np.full((len(starts), values.shape[1]), -np.inf)
    high = -low
    reached = []
    for step in range(1, len(times)):
        is_open = (low <= high).all(axis=-1) & (starts + step < len(times))
        starts, low, high = starts[is_open], low[is_open], high[is_open]
        if not len(starts) or before[-1] >= 0:
            break
        ends = starts + step
        gaps, rises = (times[ends] - times[starts])[:, None], values[ends] - values[starts]
        slopes = rises / gaps
        is_new = ((low <= slopes) & (slopes <= high)).all(axis=-1) & (before[ends] < 0)
        before[ends[is_new]] = starts[is_new]
        reached.append(ends[is_new])
        low, high = np.maximum(low, (rises - tolerance) / gaps), np.minimum(high, (rises + tolerance) / gaps)
    return np.concatenate(reached)


def thinned_weights(clip: SkelClip, tolerance: float, keep: np.ndarray) -> Channel | None:
    """Keep the fewest samples of the weights with which upsampling restores the others within a tolerance.

    Parameters
    ----------
    clip : SkelClip
    tolerance : float
        Largest difference of any weight at any sample.
    keep : array-like, shape=[K]
        Time codes of samples that must stay, if there are any.

    Returns
    -------
    weights : Channel or None
        Value blocks and the ends of stretches are kept. None if the weights never change.
    """
    channel = clip.channels.get(WEIGHTS)
    if channel is None or channel.is_constant:
        return None
    values = channel.values[..., 0].astype(np.float64)
    # what is restored is rounded to the precision of the file
    tolerance = max(0.0, tolerance - 2.0 * float(np.finfo(channel.values.dtype).eps * np.abs(values).max()))
    # a pair of samples this near would become a step once its neighbours were gone
    is_short = np.diff(channel.codes) < STEP_SECONDS * clip.codes_per_second
    fixed = np.isin(channel.codes, keep)
    fixed[:-1] |= is_short
    fixed[1:] |= is_short
    kept = np.ones(len(channel.codes), dtype=bool)
    for span in clip.spans(WEIGHTS):
        kept[span] = False
        ends = np.unique([span.start, *span.start + np.flatnonzero(fixed[span]), span.stop - 1])
        for first, last in zip(ends[:-1], ends[1:], strict=True):
            part = slice(first, last + 1)
            kept[first + fewest_keys(channel.codes[part], values[part], tolerance)] = True
    return channel.at(kept)


def weights_error(rebuilt: Channel, source: Channel) -> float:
    """Return the largest difference of any weight at any sample of the source that is not blocked."""
    codes = source.codes[~source.blocked]
    right = np.minimum(np.searchsorted(rebuilt.codes, codes), len(rebuilt.codes) - 1)
    left = np.maximum(right - 1, 0)
    nearest = np.where(codes - rebuilt.codes[left] < np.abs(rebuilt.codes[right] - codes), left, right)
    values = source.values[~source.blocked].astype(np.float64)
    return float(np.abs(rebuilt.values[nearest] - values).max(initial=0.0))
