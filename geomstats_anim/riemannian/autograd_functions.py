"""Exponential, logarithm and distance on SO(3)^B with exact derivatives for autograd, by poses and by the metric.

Parameters of all functions are points and tangent vectors, shape=[..., B, 3, 3], as Geomstats has them, and the numbers
of `MetricParameters`. Points are differentiated along the group: of a gradient by a matrix, only the part along it
counts. Derivatives of distances by points can be differentiated once more.
"""

from __future__ import annotations

from typing import Any

import numpy as np

try:
    import autograd.numpy as anp
    from autograd.extend import defvjp_argnums, primitive
    from autograd.tracer import isbox
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "This needs autograd, which is not installed; run: pip install 'geomstats-anim[autograd]'"
    ) from error

from geomstats_anim.riemannian import compiled_functions, pull_backs
from geomstats_anim.riemannian.compiled_functions import Invariance, metric_of

_POINTS = 2
"""Arguments before those of the metric."""


def exp(
    tangent_vec: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left"
) -> Any:
    """Follow geodesics for the unit of time.

    Parameters
    ----------
    tangent_vec, base_point : array-like, shape=[..., B, 3, 3]
    alpha, beta : array-like, shape=[B]
    axes : array-like, shape=[B, 3]
        Optional, default: None, diagonal matrices.
    invariance : str or sequence of str
        Optional, default: "left".

    Returns
    -------
    end_point : array-like, shape=[..., B, 3, 3]
    """
    return _exp(tangent_vec, base_point, alpha, beta, axes, invariance)


def log(point: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left") -> Any:
    """Find the velocities of the shortest geodesics from base_point to point; see `exp` for the parameters.

    Returns
    -------
    tangent_vec : array-like, shape=[..., B, 3, 3]

    Raises
    ------
    RuntimeError
        If no geodesic was found for an element.
    """
    return _log(point, base_point, alpha, beta, axes, invariance)


def squared_dist(
    point: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left"
) -> Any:
    """Measure squared distances, shape=[...], in Geomstats' scale; see `log`."""
    return _squared_dist(point, base_point, alpha, beta, axes, invariance)


def dist(point: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left") -> Any:
    """Measure distances, shape=[...], which have no derivative at 0; see `squared_dist`."""
    return anp.sqrt(_squared_dist(point, base_point, alpha, beta, axes, invariance))


def geodesic(
    base_point: Any,
    point: Any,
    times: Any,
    alpha: Any,
    beta: Any,
    axes: Any = None,
    invariance: Invariance = "left",
) -> Any:
    """Return the poses, shape=[..., n_times, B, 3, 3], at times of the shortest geodesics between points."""
    vector = _log(point, base_point, alpha, beta, axes, invariance)
    vectors = anp.einsum("t,...bij->...tbij", anp.array(times), vector)
    return _exp(vectors, base_point[..., None, :, :, :], alpha, beta, axes, invariance)


@primitive
def _exp(vector: Any, base: Any, alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> Any:
    return compiled_functions.exp(vector, base, metric_of(alpha, beta, axes, invariance))


@primitive
def _log(point: Any, base: Any, alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> Any:
    return compiled_functions.log(point, base, metric_of(alpha, beta, axes, invariance))


@primitive
def _squared_dist(point: Any, base: Any, alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> Any:
    parameters = metric_of(alpha, beta, axes, invariance)
    return compiled_functions.squared_dist(compiled_functions.log(point, base, parameters), base, parameters)


def _once(*values: Any) -> None:
    if any(isbox(value) for value in values):
        raise NotImplementedError("This second derivative is not available; differentiate it by finite differences.")


def _exp_gradients(argnums: Any, end: Any, args: Any, kwargs: Any) -> Any:
    def pull(g: Any) -> Any:
        _once(g, *args)
        vector, base, *numbers = args
        found = pull_backs.pull_back_exp(g, vector, base, metric_of(*numbers))
        return tuple(found[number] for number in argnums)

    return pull


def _log_gradients(argnums: Any, vector: Any, args: Any, kwargs: Any) -> Any:
    def pull(g: Any) -> Any:
        _once(g, *args)
        point, base, *numbers = args
        found = pull_backs.pull_back_log(g, vector, point, base, metric_of(*numbers))
        return tuple(found[number] for number in argnums)

    return pull


def _squared_dist_gradients(argnums: Any, squares: Any, args: Any, kwargs: Any) -> Any:
    def pull(g: Any) -> Any:
        point, base, *numbers = args
        if max(argnums) >= _POINTS:
            _once(g, *args)
            parameters = metric_of(*numbers)
            vector = compiled_functions.log(point, base, parameters)
            found = pull_backs.pull_back_squared_dist(g, vector, point, base, parameters)
            return tuple(found[number] for number in argnums)
        _once(*numbers)
        ends = ((point, base), (base, point))
        return tuple(_by_end(g, *ends[number], numbers) for number in argnums)

    return pull


def _by_end(g: Any, end: Any, other: Any, numbers: Any) -> Any:
    """Return the derivative of the squared distance by one of its ends: -2 times the logarithm from it, lowered."""
    parameters = metric_of(*numbers)
    vector = _log(other, end, *numbers)
    is_right = parameters.is_right[:, None, None]
    back = anp.swapaxes(end, -1, -2)
    seen = anp.where(is_right, vector @ back, back @ vector)
    velocity = 0.5 * anp.einsum("kij,...ij->...k", _AXES, seen)
    lowered = anp.einsum("kij,bkl,...bl->...bij", _AXES, -2.0 * parameters.matrices, velocity)
    gradient = g[..., None, None, None] * anp.where(is_right, lowered @ end, end @ lowered)
    extra = anp.ndim(gradient) - anp.ndim(end)
    repeated = [i for i in range(anp.ndim(end)) if end.shape[i] == 1 != gradient.shape[extra + i]]
    gradient = anp.sum(gradient, axis=tuple(range(extra)))
    return anp.sum(gradient, axis=tuple(repeated), keepdims=True)


_AXES = -np.cross(np.eye(3)[:, None], np.eye(3))
"""The matrices hat(e_k)."""

defvjp_argnums(_exp, _exp_gradients)
defvjp_argnums(_log, _log_gradients)
defvjp_argnums(_squared_dist, _squared_dist_gradients)
