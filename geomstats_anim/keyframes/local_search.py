"""Moving, removing and adding keys under the scheme that will rebuild the frames between them.

A spline's segments depend on keys further away, so no table of segments tells what they cost. But a key's influence
fades within a few segments: keys that are far enough apart are tried all at once, each judged by the frames around it,
and what they gain together is measured before it is taken.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.criteria import rotation_errors
from geomstats_anim.interpolation.curves import Metric
from geomstats_anim.interpolation.schemes import SCHEMES
from geomstats_anim.keyframes.dynamic_programming import Measure
from geomstats_anim.kinematics import world_pose
from geomstats_anim.markers import world_errors
from geomstats_anim.rotations import Array

_MOVE_STRIDE, _MOVE_REACH = 4, 2
_REMOVE_STRIDE, _REMOVE_REACH = 8, 3
"""Every so many keys are moved or removed at once; so many segments to both sides are what each is judged by."""

_MOVES = (-1, 1, -2, 2)
"""Frames by which a key is moved."""

_ROUNDS, _FEW_ROUNDS = 8, 1
"""Most passes over all keys; few where keys are removed in between."""

_WORTHWHILE = 0.98
"""Share of the keys: another round of moving and removing is made while one leaves fewer."""

_LEAST_GAIN = 1e-2
"""Share of the cost that another pass over all keys must have gained."""

_POWER = 12
"""Sums of this power of errors are led by the largest."""

Judge = Callable[[np.ndarray], Array]
"""Cost of every frame, shape=[F], when rebuilt from keys, shape=[K]."""


def judge_of(
    truth: Animation, measure: Measure, scheme: str, metric: Metric | None, tolerance: float | None = None
) -> Judge:
    """Make the function that judges keys.

    Parameters
    ----------
    truth : Animation
    measure : Measure
    scheme : str
        A name in `SCHEMES`.
    metric : MetricParameters, LearnedMetric or None
    tolerance : float
        Largest error that is allowed, metres, if the measure is the largest: a frame costs no more than 1 if it is
        within.
        Optional, default: 1 metre.

    Returns
    -------
    judge : callable
    """
    ends = world_pose(truth).ends

    def judge(keys: np.ndarray) -> Array:
        rebuilt = SCHEMES[scheme](truth.at_frames(keys), metric)(truth.times)
        cost = np.zeros(truth.n_frames)
        if measure.markers is not None:
            distance = world_errors(replace(rebuilt, scales=truth.scales), truth, measure.markers)
            return (distance.max(axis=-1) / (tolerance or 1.0)) ** _POWER
        if measure.location.any():
            distance = np.linalg.norm(world_pose(rebuilt).ends - ends, axis=-1)
            cost += distance**2 @ measure.location
        if measure.rotation.any():
            cost += rotation_errors(rebuilt, truth) @ measure.rotation
        return cost

    return judge


def moved(judge: Judge, keys: np.ndarray, fixed: np.ndarray, rounds: int = _ROUNDS) -> np.ndarray:
    """Move keys, where that makes the sum of costs less.

    Parameters
    ----------
    judge : callable
    keys : array-like of int, shape=[K]
    fixed : array-like of int
        Keys that stay, the first and the last among them.
    rounds : int
        Most passes over all keys.
        Optional, default: enough.

    Returns
    -------
    keys : array-like of int, shape=[K]
    """
    cost = judge(keys)
    for _ in range(rounds):
        before = cost.sum()
        for phase in range(_MOVE_STRIDE):
            for move in _MOVES:
                tried = np.flatnonzero(~np.isin(keys, fixed))[phase::_MOVE_STRIDE]
                to = keys[tried] + move
                tried = tried[(to > keys[tried - 1]) & (to < keys[tried + 1])]
                for _ in range(2):  # all that may move, then those that gain by it
                    if not len(tried):
                        break
                    new = keys.copy()
                    new[tried] += move
                    new_cost = judge(new)
                    gains = _around(cost - new_cost, keys, tried, _MOVE_REACH, np.add)
                    if (gains > 0.0).all():
                        break
                    tried = tried[gains > 0.0]
                if len(tried) and new_cost.sum() < cost.sum():
                    keys, cost = new, new_cost
        if before - cost.sum() <= _LEAST_GAIN * before:
            break
    return keys


def without_needless(judge: Judge, keys: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Remove keys as long as every frame costs no more than 1; see `moved`."""
    while True:
        n_before = len(keys)
        for phase in range(_REMOVE_STRIDE):
            tried = np.flatnonzero(~np.isin(keys, fixed))[phase::_REMOVE_STRIDE]
            while len(tried):
                cost = judge(np.delete(keys, tried))
                if cost.max() <= 1.0:
                    keys = np.delete(keys, tried)
                    break
                worst = _around(cost, keys, tried, _REMOVE_REACH, np.maximum)
                # where no removal is to blame by itself, the costliest is given up
                tried = tried[worst <= 1.0] if (worst > 1.0).any() else np.delete(tried, worst.argmax())
        if len(keys) == n_before:
            return keys


def with_needed(judge: Judge, keys: np.ndarray) -> np.ndarray:
    """Add the costliest frame of every segment until no frame costs more than 1; see `moved`."""
    while True:
        cost = judge(keys)
        if cost.max() <= 1.0:
            return keys
        worst = [a + int(cost[a:b].argmax()) for a, b in zip(keys[:-1], keys[1:], strict=True)]
        keys = np.union1d(keys, [frame for frame in worst if cost[frame] > 1.0])


def thinned(judge: Judge, keys: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Add keys until every frame costs no more than 1, then move and remove as many as can be; see `moved`."""
    keys = with_needed(judge, keys)
    while True:
        fewer = without_needless(judge, moved(judge, keys, fixed, _FEW_ROUNDS), fixed)
        if len(fewer) >= _WORTHWHILE * len(keys):
            return fewer
        keys = fewer


def _around(cost: Array, keys: np.ndarray, tried: np.ndarray, reach: int, combine: np.ufunc) -> Array:
    """Combine the costs of the frames around each of some keys, as far as its influence reaches, in segments."""
    starts, stops = keys[np.maximum(tried - reach, 0)], keys[np.minimum(tried + reach, len(keys) - 1)]
    return np.array([combine.reduce(cost[a : b + 1]) for a, b in zip(starts, stops, strict=True)])
