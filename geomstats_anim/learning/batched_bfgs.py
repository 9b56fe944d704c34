"""Minimise many functions of few variables each, bounded, all at once: a quasi-Newton method with a batch axis.

A round evaluates every function that is not finished once, at a point of its own, so that they can share the work.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geomstats_anim.rotations import Array

_SUFFICIENT = 1e-4
"""Share of the decrease that the slope promises, which a step must bring (Armijo)."""

_FIRST_STEP, _LONGEST_STEP = 0.5, 1.0
_SHORTER, _SHORTEST = (0.1, 0.5), 1e-3
"""Factors by which a step that fails is cut, and where a function is given up."""

Evaluate = Callable[[Array, np.ndarray], tuple[Array, Array]]
"""Take points, shape=[m, d], and the indices of their functions, shape=[m]; return values and gradients."""


def batched_bfgs(
    evaluate: Evaluate, start: Array, lower: Array, upper: Array, tolerance: Array, max_rounds: int
) -> tuple[Array, Array, Array]:
    """Minimise functions by projected BFGS.

    Parameters
    ----------
    evaluate : callable
        See `Evaluate`.
    start : array-like, shape=[n, d]
    lower, upper : array-like, shape=[d]
        Bounds.
    tolerance : array-like, shape=[n]
        Decrease of a function that is not worth another round.
    max_rounds : int

    Returns
    -------
    point : array-like, shape=[n, d]
        Never worse than the start.
    value : array-like, shape=[n]
    curvature : array-like, shape=[n, d]
        Estimate of the second derivatives along the axes.
    """
    point = np.clip(start, lower, upper)
    n, d = point.shape
    value, gradient = evaluate(point, np.arange(n))
    steepness = np.abs(gradient).max(axis=1, initial=0.0)
    hessian = np.maximum(steepness, 1e-300)[:, None, None] / _FIRST_STEP * np.eye(d)
    is_first, share = np.ones(n, dtype=bool), np.ones(n)
    step = _steps(point, gradient, hessian, lower, upper)
    active = np.flatnonzero(-(gradient * step).sum(axis=1) > tolerance)
    for _ in range(max_rounds):
        if not len(active):
            break
        trial = np.clip(point[active] + share[active, None] * step[active], lower, upper)
        trial_value, trial_gradient = evaluate(trial, active)
        move = trial - point[active]
        slope = (gradient[active] * move).sum(axis=1)
        gain = value[active] - trial_value
        succeeds = gain >= -_SUFFICIENT * slope
        failed = active[~succeeds]
        # where the parabola through value, slope and trial is least
        cut = -0.5 * slope / np.maximum(-gain - slope, 1e-300)
        share[failed] *= np.clip(cut[~succeeds], *_SHORTER)
        moved = active[succeeds]
        change = trial_gradient[succeeds] - gradient[moved]
        point[moved], value[moved], gradient[moved] = trial[succeeds], trial_value[succeeds], trial_gradient[succeeds]
        hessian[moved] = _updated(hessian[moved], move[succeeds], change, is_first[moved])
        is_first[moved], share[moved] = False, 1.0
        step[moved] = _steps(point[moved], gradient[moved], hessian[moved], lower, upper)
        promise = -share * (gradient * step).sum(axis=1)
        goes_on = np.where(succeeds, gain > tolerance[active], share[active] > _SHORTEST)
        active = active[goes_on & (promise[active] > tolerance[active])]
    return point, value, hessian[:, np.arange(d), np.arange(d)]


def _steps(point: Array, gradient: Array, hessian: Array, lower: Array, upper: Array) -> Array:
    """Step to the minima of the models, among the variables that are not pressed against a bound."""
    held = ((point <= lower) & (gradient > 0.0)) | ((point >= upper) & (gradient < 0.0))
    apart = held[:, :, None] | held[:, None, :]
    model = np.where(apart, np.eye(point.shape[1]), hessian)
    step = -np.linalg.solve(model, np.where(held, 0.0, gradient)[..., None])[..., 0]
    longest = np.abs(step).max(axis=1, initial=_LONGEST_STEP, keepdims=True)
    return step * (_LONGEST_STEP / longest)


def _updated(hessian: Array, move: Array, change: Array, is_first: np.ndarray) -> Array:
    """Learn from how the gradient has changed (Broyden, Fletcher, Goldfarb, Shanno), where it bends upwards."""
    along, square = (move * change).sum(axis=1), (change**2).sum(axis=1)
    learns = along > 1e-8 * np.sqrt((move**2).sum(axis=1) * square)
    along = np.where(learns, along, 1.0)
    scale = (square / along)[:, None, None] * np.eye(move.shape[1])
    hessian = np.where((learns & is_first)[:, None, None], scale, hessian)
    pushed = np.einsum("nij,nj->ni", hessian, move)
    energy = np.where(learns, (move * pushed).sum(axis=1), 1.0)
    update = change[:, :, None] * change[:, None, :] / along[:, None, None]
    update -= pushed[:, :, None] * pushed[:, None, :] / energy[:, None, None]
    return np.where(learns[:, None, None], hessian + update, hessian)
