"""Exponential, logarithm and distance on SO(3)^B with exact derivatives for PyTorch; see `autograd_functions`.

Numbers are float64 inside; results have the type and the device of the first argument.
"""

from __future__ import annotations

from typing import Any

import numpy as np

try:
    import torch
    from torch.autograd.function import once_differentiable
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "This needs PyTorch, which is not installed; run: pip install 'geomstats-anim[torch]'"
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
    tangent_vec, base_point : tensor or array-like, shape=[..., B, 3, 3]
    alpha, beta : tensor or array-like, shape=[B]
    axes : tensor or array-like, shape=[B, 3]
        Optional, default: None, diagonal matrices.
    invariance : str or sequence of str
        Optional, default: "left".

    Returns
    -------
    end_point : tensor, shape=[..., B, 3, 3]
    """
    return _Exp.apply(*_tensors(tangent_vec, base_point, alpha, beta, axes), invariance)


def log(point: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left") -> Any:
    """Find the velocities of the shortest geodesics from base_point to point; see `exp` for the parameters.

    Returns
    -------
    tangent_vec : tensor, shape=[..., B, 3, 3]

    Raises
    ------
    RuntimeError
        If no geodesic was found for an element.
    """
    return _Log.apply(*_tensors(point, base_point, alpha, beta, axes), invariance)


def squared_dist(
    point: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left"
) -> Any:
    """Measure squared distances, shape=[...], in Geomstats' scale; see `log`."""
    return _SquaredDist.apply(*_tensors(point, base_point, alpha, beta, axes), invariance)


def dist(point: Any, base_point: Any, alpha: Any, beta: Any, axes: Any = None, invariance: Invariance = "left") -> Any:
    """Measure distances, shape=[...], which have no derivative at 0; see `squared_dist`."""
    return torch.sqrt(squared_dist(point, base_point, alpha, beta, axes, invariance))


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
    base_point, point = _tensors(base_point, point)
    vector = log(point, base_point, alpha, beta, axes, invariance)
    times = torch.as_tensor(times, dtype=vector.dtype, device=vector.device)
    vectors = torch.einsum("t,...bij->...tbij", times, vector)
    return exp(vectors, base_point[..., None, :, :, :], alpha, beta, axes, invariance)


def _tensors(*values: Any) -> tuple[Any, ...]:
    return tuple(value if value is None else torch.as_tensor(value) for value in values)


def _plain(value: Any) -> Any:
    return value.detach().cpu().numpy().astype(np.float64) if isinstance(value, torch.Tensor) else value


def _like(values: np.ndarray, other: Any) -> Any:
    return torch.as_tensor(values).to(other)


def _gradients(ctx: Any, arguments: Any, found: pull_backs.Gradients) -> Any:
    """Return the derivatives that are needed, as tensors; the last argument is a word."""
    needed = zip(arguments, found, ctx.needs_input_grad, strict=False)
    return (*(_like(value, argument) if need else None for argument, value, need in needed), None)


class _Exp(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, vector: Any, base: Any, alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> Any:
        ctx.save_for_backward(vector, base, alpha, beta, axes)
        ctx.invariance = invariance
        numbers = metric_of(_plain(alpha), _plain(beta), _plain(axes), invariance)
        return _like(compiled_functions.exp(_plain(vector), _plain(base), numbers), vector)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, g: Any) -> Any:
        vector, base, alpha, beta, axes = (_plain(value) for value in ctx.saved_tensors)
        parameters = metric_of(alpha, beta, axes, ctx.invariance)
        found = pull_backs.pull_back_exp(_plain(g), vector, base, parameters)
        return _gradients(ctx, ctx.saved_tensors, found)


class _Log(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, point: Any, base: Any, alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> Any:
        numbers = metric_of(_plain(alpha), _plain(beta), _plain(axes), invariance)
        vector = _like(compiled_functions.log(_plain(point), _plain(base), numbers), point)
        ctx.save_for_backward(point, base, alpha, beta, axes, vector)
        ctx.invariance = invariance
        return vector

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, g: Any) -> Any:
        *arguments, vector = ctx.saved_tensors
        point, base, alpha, beta, axes = (_plain(value) for value in arguments)
        parameters = metric_of(alpha, beta, axes, ctx.invariance)
        return _gradients(ctx, arguments, pull_backs.pull_back_log(_plain(g), _plain(vector), point, base, parameters))


class _SquaredDist(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, point: Any, base: Any, alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> Any:
        ctx.save_for_backward(point, base, alpha, beta, axes)
        ctx.invariance = invariance
        parameters = metric_of(_plain(alpha), _plain(beta), _plain(axes), invariance)
        vector = compiled_functions.log(_plain(point), _plain(base), parameters)
        return _like(compiled_functions.squared_dist(vector, _plain(base), parameters), point)

    @staticmethod
    def backward(ctx: Any, g: Any) -> Any:
        if any(ctx.needs_input_grad[_POINTS:]):
            return _SquaredDistGradients.apply(g, ctx.needs_input_grad, *ctx.saved_tensors, ctx.invariance)
        point, base, *numbers = ctx.saved_tensors
        ends = ((point, base), (base, point))
        needed = zip(ends, ctx.needs_input_grad, strict=False)
        by_ends = (_by_end(g, *pair, numbers, ctx.invariance) if need else None for pair, need in needed)
        return (*by_ends, None, None, None, None)


class _SquaredDistGradients(torch.autograd.Function):
    """Derivatives by the metric too, which cannot be differentiated again."""

    @staticmethod
    def forward(ctx: Any, g: Any, needed: Any, point: Any, base: Any, *numbers: Any) -> Any:
        parameters = metric_of(*(_plain(value) for value in numbers))
        ends = _plain(point), _plain(base)
        vector = compiled_functions.log(*ends, parameters)
        found = pull_backs.pull_back_squared_dist(_plain(g), vector, *ends, parameters)
        arguments = (point, base, *numbers[:-1])
        values = zip(arguments, found, needed, strict=False)
        return (*(_like(value, argument) if need else None for argument, value, need in values), None)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *g: Any) -> Any:
        raise NotImplementedError("This second derivative is not available; differentiate it by finite differences.")


def _by_end(g: Any, end: Any, other: Any, numbers: Any, invariance: Invariance) -> Any:
    """Return the derivative of the squared distance by one of its ends: -2 times the logarithm from it, lowered."""
    alpha, beta, axes = (_plain(value) for value in numbers)
    parameters = metric_of(alpha, beta, axes, invariance)
    vector = _Log.apply(other, end, *numbers, invariance)
    is_right = torch.as_tensor(parameters.is_right[:, None, None], device=end.device)
    hats, matrices = _like(_AXES, end), _like(-2.0 * parameters.matrices, end)
    back = end.transpose(-1, -2)
    seen = torch.where(is_right, vector @ back, back @ vector)
    velocity = 0.5 * torch.einsum("kij,...ij->...k", hats, seen)
    lowered = torch.einsum("kij,bkl,...bl->...bij", hats, matrices, velocity)
    return (g[..., None, None, None] * torch.where(is_right, lowered @ end, end @ lowered)).sum_to_size(end.shape)


_AXES = -np.cross(np.eye(3)[:, None], np.eye(3))
"""The matrices hat(e_k)."""
