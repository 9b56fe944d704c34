"""Metrics under Geomstats' backends that differentiate: which arrays are followed, and what answers for them."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import geomstats.backend as gs
import numpy as np

from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

_HATS = -np.cross(np.eye(3)[:, None], np.eye(3))


def _functions(arrays: tuple[Any, ...]) -> ModuleType | None:
    """Return the functions for arrays that the backend follows; None where it follows none of them."""
    backend = gs.__name__.rpartition(".")[2]
    if backend == "autograd":
        from autograd.tracer import isbox

        from geomstats_anim.riemannian import autograd_functions

        return autograd_functions if any(isbox(array) for array in arrays) else None
    if backend == "pytorch":
        import torch

        from geomstats_anim.riemannian import torch_functions

        followed = any(isinstance(array, torch.Tensor) and array.requires_grad for array in arrays)
        return torch_functions if followed and torch.is_grad_enabled() else None
    return None


def followed(*arrays: Any) -> bool:
    """Return whether derivatives by one of the arrays are asked for."""
    return _functions(arrays) is not None


class Differentiable:
    """Exponential, logarithm, inner product and distance of a metric, on arrays that are followed.

    Parameters
    ----------
    parameters : MetricParameters
    matrices : array-like, shape=[B, 3, 3]
        At the identity.
    scale : array-like, shape=[B]
        Multiples of the matrices of the parameters that they are.
    has_joints : bool
        Whether points have an axis of joints.
    """

    def __init__(self, parameters: MetricParameters, matrices: Array, scale: Array, has_joints: bool) -> None:
        self._parameters, self._matrices, self._scale = parameters, matrices, scale
        self._has_joints = has_joints

    def exp(self, tangent_vec: Any, base_point: Any) -> Any:
        """Return ends of geodesics, shape=[..., *space.shape]."""
        return self._outer(self._call("exp", tangent_vec, base_point))

    def log(self, point: Any, base_point: Any) -> Any:
        """Return velocities of geodesics, shape=[..., *space.shape]."""
        return self._outer(self._call("log", point, base_point))

    def squared_dist(self, point_a: Any, point_b: Any) -> Any:
        """Return squared distances, shape=[...]."""
        if (self._scale == 1.0).all():
            return self._call("squared_dist", point_b, point_a)
        return float(self._scale[0]) * self._call("squared_dist", point_b, point_a)

    def inner_product(self, tangent_vec_a: Any, tangent_vec_b: Any, base_point: Any) -> Any:
        """Return inner products, shape=[...]."""
        base = self._inner(self._identity() if base_point is None else base_point)
        first, second = (self._velocity(self._inner(vector), base) for vector in (tangent_vec_a, tangent_vec_b))
        return 2.0 * gs.einsum("...bi,bij,...bj->...", first, gs.from_numpy(self._matrices), second)

    def path(self, tangent_vec: Any, base_point: Any) -> Callable[[Any], Any]:
        """Return the function of times, shape=[n_times], that gives points, shape=[..., n_times, *space.shape]."""
        base, vector = self._inner(base_point), self._inner(tangent_vec)

        def path(t: Any) -> Any:
            vectors = gs.einsum("t,...bij->...tbij", gs.to_ndarray(gs.array(t), 1), vector)
            numbers = self._numbers()
            functions = _functions((vectors, base))
            assert functions is not None
            return self._outer(functions.exp(vectors, base[..., None, :, :, :], *numbers))

        return path

    def _call(self, name: str, first: Any, base_point: Any) -> Any:
        functions = _functions((first, base_point))
        assert functions is not None
        base = self._identity() if base_point is None else base_point
        return getattr(functions, name)(self._inner(first), self._inner(base), *self._numbers())

    def _numbers(self) -> tuple[Any, ...]:
        parameters = self._parameters
        axes = None if parameters.axes is None else gs.from_numpy(np.array(parameters.axes))
        alpha, beta = (gs.from_numpy(np.array(values)) for values in (parameters.alpha, parameters.beta))
        return alpha, beta, axes, parameters.invariance

    def _identity(self) -> Any:
        identity = np.tile(np.eye(3), (self._parameters.n_joints, 1, 1))
        return gs.from_numpy(identity if self._has_joints else identity[0])

    def _inner(self, values: Any) -> Any:
        return values if self._has_joints else values[..., None, :, :]

    def _outer(self, values: Any) -> Any:
        return values if self._has_joints else values[..., 0, :, :]

    def _velocity(self, vectors: Any, base: Any) -> Any:
        is_right = gs.from_numpy(self._parameters.is_right[:, None, None])
        back = gs.moveaxis(base, -1, -2)
        seen = gs.where(is_right, gs.matmul(vectors, back), gs.matmul(back, vectors))
        return 0.5 * gs.einsum("kij,...ij->...k", gs.from_numpy(_HATS), seen)
