"""Keys for slerp by their number: exactly where the errors of all segments can be measured, else from coarse to fine.

The table of segments grows with the cube of the frames where few of them are keys. So the keys of a long clip are first
chosen among every so many frames, by which they are measured too; then the spacing is halved again and again, and each
key is sought near its last place, all of them together by dynamic programming.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.kernels import segment_errors as kernel
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.keyframes.dynamic_programming import (
    Measure,
    UnreachableError,
    cheapest,
    segment_errors,
    truth_of,
)

_WINDOW = 5
"""Usual distances of keys that one segment may span: wider ones change the outcome by less than one per cent."""

_LEAST_WINDOW = 8

_AFFORDABLE, _COARSE = 2e8, 1e8
"""Joints times frames, over all segments, that are measured: for an exact choice; and for the first of a coarse one."""

_LEAST_CANDIDATES = 4
"""Coarse candidates for each key, at least."""

_REACH = 4
"""Candidates to both sides of its last place among which a key is sought."""


def cheapest_keys(
    animation: Animation,
    candidates: np.ndarray,
    forced: np.ndarray,
    count: int,
    measure: Measure,
    progress: Callable[[float], None] = lambda share: None,
) -> np.ndarray:
    """Choose candidates so that slerping between them costs least.

    Parameters
    ----------
    animation : Animation
        The truth.
    candidates : array-like of int, shape=[N]
        Frames that may be keys, increasing.
    forced : array-like of bool, shape=[N]
        Those that must be, the first and the last among them.
    count : int
        How many to choose, K.
    measure : Measure
    progress : callable
        Called with the share of the work that is done.

    Returns
    -------
    chosen : array-like of int, shape=[K]
        Indices of candidates.
    """
    if _work(len(candidates), count, animation.n_joints) <= _AFFORDABLE:
        return _exactly(animation, candidates, forced, count, measure)
    must = np.flatnonzero(forced)
    spacing = 1
    grid = np.arange(len(candidates))
    while _work(len(grid), count, animation.n_joints) > _COARSE:
        coarser = _grid(len(candidates), must, 2 * spacing)
        if len(coarser) < _LEAST_CANDIDATES * count or len(coarser) == len(grid):
            break
        spacing, grid = 2 * spacing, coarser
    part = animation.at_frames(candidates[grid])
    chosen = grid[_exactly(part, np.arange(len(grid)), forced[grid], count, measure)]
    coarsest = spacing
    progress(_share_done(spacing, coarsest))
    while spacing > 1:
        spacing //= 2
        grid = _grid(len(candidates), must, spacing)
        part = animation.at_frames(candidates[grid])
        chosen = grid[_nearby(part, np.searchsorted(grid, chosen), forced[grid], measure)]
        progress(_share_done(spacing, coarsest))
    return chosen


def _share_done(spacing: int, coarsest: int) -> float:
    """Return the share of the work, each spacing costing twice as much as the one before."""
    return (2.0 / spacing - 1.0 / coarsest) / (2.0 - 1.0 / coarsest)


def _work(n_candidates: int, count: int, n_joints: int) -> float:
    """Count the joints of all inner frames of the segments that an exact choice measures."""
    ahead = np.arange(min(_window(n_candidates, count), n_candidates - 1), dtype=np.float64)
    return float(((n_candidates - 1 - ahead) * ahead).sum()) * n_joints


def _window(n_candidates: int, count: int) -> int:
    return max(_LEAST_WINDOW, -(-_WINDOW * n_candidates // count))


def _exactly(
    animation: Animation, candidates: np.ndarray, forced: np.ndarray, count: int, measure: Measure
) -> np.ndarray:
    """Choose by the errors of all segments that are not several times longer than usual."""
    window = _window(len(candidates), count)
    while True:
        errors = segment_errors(animation, candidates, min(window, len(candidates) - 1), measure)
        try:
            return cheapest(errors, forced, count, measure.largest)
        except UnreachableError:
            # so many frames must stay in one place that few keys are left for the rest
            if window >= len(candidates) - 1:
                raise
            window *= 2


def _grid(n_candidates: int, forced: np.ndarray, spacing: int) -> np.ndarray:
    return np.union1d(np.arange(0, n_candidates, spacing), forced)


def _nearby(animation: Animation, keys: np.ndarray, forced: np.ndarray, measure: Measure) -> np.ndarray:
    """Move the keys of an animation that are not forced, all at once, to the best frames near them."""
    layers = keys[:, None] + np.arange(-_REACH, _REACH + 1)
    layers[(layers < 0) | (layers >= animation.n_frames)] = -1
    layers[forced[keys]] = np.where(np.arange(2 * _REACH + 1) == _REACH, keys[forced[keys], None], -1)
    n_layers, width = layers.shape
    errors = np.full((n_layers - 1, width, width), np.inf)
    truth = truth_of(animation, measure)
    in_threads(lambda part: kernel.fill_layers(part.start, part.stop, layers, truth, errors), errors.size)
    steps = np.zeros(layers.shape, dtype=np.intp)
    cost = kernel.cheapest_of_layers(errors, measure.largest, steps)
    path = [int(cost.argmin())]
    for row in steps[:0:-1]:
        path.append(int(row[path[-1]]))
    return layers[np.arange(n_layers), path[::-1]]
