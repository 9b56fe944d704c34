"""Arrays of any Geomstats backend in and out: checked, and turned into what the kernels want.

A tangent vector at R is the matrix R hat(w) = hat(R w) R: w is the angular velocity in the body frame, R w the one in
the parent's frame.
"""

from __future__ import annotations

import math
from typing import Any

import geomstats.backend as gs
import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.kernels import matrices as kernel
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

TOLERANCE = 1e-6
"""Largest entry of R^T R - 1 that is taken for rounding, and projected away; float32 leaves 2e-7."""


class PoseMatrices:
    """Points of a space and their tangent vectors, as quaternions and velocities.

    Parameters
    ----------
    shape : tuple of int
        Shape of a point: (B, 3, 3), or (3, 3) for the one joint of SO(3).
    parameters : MetricParameters
        Their sides tell the frame of each joint's velocity: the body's, or the parent's for a right-invariant joint.
    """

    def __init__(self, shape: tuple[int, ...], parameters: MetricParameters) -> None:
        self.shape = tuple(shape)
        self.per_joint = self.shape[:-2]
        self.n_joints = parameters.n_joints
        self._is_right = parameters.is_right

    def read_points(self, points: Any, name: str) -> Array:
        """Read rotation matrices, and project rounding away.

        Parameters
        ----------
        points : array-like, shape=[..., *shape]
            None is the identity.
        name : str
            What to call them in an error.

        Returns
        -------
        quaternions : array-like, shape=[..., B, 4]

        Raises
        ------
        ValueError
            If the shape is another, or a matrix is further from a rotation than `TOLERANCE`.
        """
        if points is None:
            return np.broadcast_to(quat.IDENTITY, (self.n_joints, 4))
        matrices = _floats(points, self.shape, name)
        quaternions = np.empty((*self._batch(matrices), self.n_joints, 4))
        bad = kernel.read_rotations(quat.plain(matrices).reshape(-1, 3, 3), TOLERANCE, quaternions.reshape(-1, 4))
        if bad >= 0:
            _refuse_point(matrices, bad, name)
        return quaternions

    def read_velocities(self, tangent_vecs: Any, base: Array, name: str) -> Array:
        """Read tangent vectors; what is not tangent is projected away.

        Parameters
        ----------
        tangent_vecs : array-like, shape=[..., *shape]
        base : array-like, shape=[..., B, 4]
            Unit quaternions of the base points.
        name : str
            What to call them in an error.

        Returns
        -------
        velocities : array-like, shape=[..., B, 3]

        Raises
        ------
        ValueError
            If the shape is another, or a number is not finite.
        """
        vectors = read(tangent_vecs, self.shape, name)
        batch = np.broadcast_shapes(self._batch(vectors), base.shape[:-2])
        vectors = vectors.reshape(*self._batch(vectors), self.n_joints, 3, 3)
        velocities = np.empty((*batch, self.n_joints, 3))
        kernel.read_velocities(
            flat(vectors, batch, 3), flat(base, batch, 2), self._is_right, velocities.reshape(-1, self.n_joints, 3)
        )
        return velocities

    def write_points(self, quaternions: Array, batch: tuple[int, ...]) -> Any:
        """Write points, shape=[*batch, *shape], in the arrays of the backend."""
        return self.write(quat.to_matrix(quaternions), batch + self.shape)

    def write_tangent_vecs(self, velocities: Array, base: Array, batch: tuple[int, ...]) -> Any:
        """Write tangent vectors, shape=[*batch, *shape], of velocities as `read_velocities` gives them.

        Parameters
        ----------
        velocities : array-like, shape=[n, B, 3]
        base : array-like, shape=[n, B, 4]
            Unit quaternions of the base points.
        batch : tuple of int
            Shape of n elements.
        """
        return self.write(self.tangent_vecs(velocities, base, batch), batch + self.shape)

    def tangent_vecs(self, velocities: Array, base: Array, batch: tuple[int, ...]) -> Array:
        """Return what `write_tangent_vecs` writes, as an array of NumPy."""
        vectors = np.empty((*velocities.shape, 3))
        kernel.write_tangent_vectors(quat.plain(velocities), quat.plain(base), self._is_right, vectors)
        return vectors.reshape(batch + self.shape)

    @staticmethod
    def write(values: np.ndarray, shape: tuple[int, ...]) -> Any:
        """Convert an array to one of the backend."""
        return gs.from_numpy(np.asarray(values).reshape(shape))

    def _batch(self, values: Array) -> tuple[int, ...]:
        return values.shape[: values.ndim - len(self.shape)]


def flat(values: Array, batch: tuple[int, ...], point_ndim: int) -> Array:
    """Broadcast to a batch, and make one axis of its axes, as the kernels want it."""
    point = values.shape[values.ndim - point_ndim :]
    if values.shape != batch + point:
        values = np.broadcast_to(values, batch + point)
    return quat.plain(values).reshape(math.prod(batch), *point)


def read(values: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """Read arrays of any backend and number type as finite float64 numbers.

    Parameters
    ----------
    values : array-like, shape=[..., *shape]
    shape : tuple of int
    name : str
        What to call it in an error.

    Returns
    -------
    values : array-like, shape=[..., *shape]

    Raises
    ------
    ValueError
        If the shape is another, or a number is not finite.
    """
    array = _floats(values, shape, name)
    is_finite = np.isfinite(array)
    if not is_finite.all():
        raise ValueError(f"{at(name, np.argwhere(~is_finite)[0])} is not a finite number.")
    return array


def _floats(values: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.shape[array.ndim - len(shape) :] != shape:
        wanted = ", ".join(str(size) for size in shape)
        raise ValueError(f"{name} has shape {array.shape}, but (..., {wanted}) is needed.")
    return array


def _refuse_point(matrices: Array, number: int, name: str) -> None:
    """Raise the reason why a matrix, counted flat over all axes but the last two, is not a rotation."""
    index = np.unravel_index(number, matrices.shape[:-2])
    matrix = matrices[index]
    if not np.isfinite(matrix).all():
        raise ValueError(f"{at(name, (*index, *np.argwhere(~np.isfinite(matrix))[0]))} is not a finite number.")
    with np.errstate(over="ignore", invalid="ignore"):
        deviation = np.abs(matrix.T @ matrix - np.eye(3)).max()
    if deviation <= TOLERANCE and np.linalg.det(matrix) < 0.0:
        raise ValueError(f"{at(name, index)} is not a rotation but a reflection: its determinant is -1.")
    raise ValueError(
        f"{at(name, index)} is not a rotation: R^T R deviates from the identity by {deviation:.3g}, "
        f"more than {TOLERANCE:g}; project it onto the space first."
    )


def at(name: str, index: ArrayLike) -> str:
    """Name an element of an array, or the array itself if it has only one."""
    numbers = ", ".join(str(int(i)) for i in np.asarray(index))
    return f"{name}[{numbers}]" if numbers else name
