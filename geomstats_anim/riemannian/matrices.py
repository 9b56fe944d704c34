"""Rotation matrices and their tangent vectors, as Geomstats has them, for kernels that want quaternions and velocities.

A tangent vector at R is the matrix R hat(w) = hat(R w) R: w is the angular velocity in the body frame, R w the one in
the parent's frame.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.rotations import Array

TOLERANCE = 1e-6
"""Largest entry of R^T R - 1 that is taken for rounding, and projected away; float32 leaves 2e-7."""


def read(values: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """Take what a user gave, of any backend and number type, to finite float64 numbers.

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
    array = np.asarray(values, dtype=np.float64)
    if array.shape[array.ndim - len(shape) :] != shape:
        wanted = ", ".join(str(size) for size in shape)
        raise ValueError(f"{name} has shape {array.shape}, but (..., {wanted}) is needed.")
    if not np.isfinite(array).all():
        raise ValueError(f"{at(name, first(~np.isfinite(array)))} is not a finite number.")
    return array


def read_rotations(matrices: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """Take what a user gave to rotation matrices, and project rounding away.

    Parameters
    ----------
    matrices : array-like, shape=[..., *shape]
    shape : tuple of int
        Ends with 3, 3.
    name : str
        What to call them in an error.

    Returns
    -------
    matrices : array-like, shape=[..., *shape]

    Raises
    ------
    ValueError
        If the shape is another, or a matrix is further from a rotation than `TOLERANCE`.
    """
    matrix = read(matrices, shape, name)
    with np.errstate(over="ignore", invalid="ignore"):
        excess = np.swapaxes(matrix, -1, -2) @ matrix - np.eye(3)
    deviation = np.abs(excess).max(axis=(-2, -1))
    if not (deviation <= TOLERANCE).all():
        index = first(~(deviation <= TOLERANCE))
        raise ValueError(
            f"{at(name, index)} is not a rotation: R^T R deviates from the identity by {deviation[index]:.3g}, "
            f"more than {TOLERANCE:g}; project it onto the space before."
        )
    x, y, z = np.moveaxis(matrix, -2, 0)
    reflected = (np.cross(x, y) * z).sum(axis=-1) < 0.0
    if reflected.any():
        raise ValueError(f"{at(name, first(reflected))} is not a rotation but a reflection: its determinant is -1.")
    # one Newton step towards the polar factor, whose error is the square of the deviation
    return matrix - 0.5 * (matrix @ excess)


def first(condition: np.ndarray) -> tuple[int, ...]:
    """Index of the first place where a condition holds."""
    return tuple(int(i) for i in np.argwhere(condition)[0])


def at(name: str, index: tuple[int, ...]) -> str:
    """Name an element of an array, or the array itself if it has only one."""
    return f"{name}[{', '.join(str(i) for i in index)}]" if index else name


def hat(vector: Array) -> Array:
    """Turn vectors w, shape=[..., 3], into the skew matrices with hat(w) v = w x v, shape=[..., 3, 3]."""
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*vector.shape, 3)


def body_velocity(tangent_vec: Array, base_point: Array) -> Array:
    """Angular velocities in the body frame of tangent vectors.

    Parameters
    ----------
    tangent_vec : array-like, shape=[..., 3, 3]
        What of it is not tangent is projected away.
    base_point : array-like, shape=[..., 3, 3]

    Returns
    -------
    velocity : array-like, shape=[..., 3]
    """
    product = np.swapaxes(base_point, -1, -2) @ tangent_vec
    return 0.5 * np.stack(
        [
            product[..., 2, 1] - product[..., 1, 2],
            product[..., 0, 2] - product[..., 2, 0],
            product[..., 1, 0] - product[..., 0, 1],
        ],
        axis=-1,
    )
