"""Batched quaternion helpers, scalar last (x, y, z, w), that work on any number of leading axes.

Names and conventions follow `scipy.spatial.transform.Rotation`, which lacks array axes and keeps no track of signs.
The formulae are those of Sola, "Quaternion kinematics for the error-state Kalman filter", 2017 (arXiv:1711.02508).
"""

from __future__ import annotations

from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

IDENTITY: Array = np.array([0.0, 0.0, 0.0, 1.0])
IDENTITY.setflags(write=False)


def multiply(left: Array, right: Array) -> Array:
    """Compose rotations: the product `left right`, which applies `right` first.

    Parameters
    ----------
    left, right : array-like, shape=[..., 4]
        Quaternions, broadcast against each other.

    Returns
    -------
    product : array-like, shape=[..., 4]
    """
    return _each("multiply", 4, left, right)


def conjugate(quaternion: Array) -> Array:
    """Invert unit quaternions, shape=[..., 4]."""
    return quaternion * np.array([-1.0, -1.0, -1.0, 1.0])


def normalize(quaternion: Array) -> Array:
    """Scale quaternions, shape=[..., 4], to unit length."""
    return quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)


def norm(quaternion: Array) -> Array:
    """Return the lengths, shape=[...], of quaternions, shape=[..., 4], faster than `numpy.linalg.norm`."""
    squares = quaternion * quaternion
    return np.sqrt(squares[..., 0] + squares[..., 1] + squares[..., 2] + squares[..., 3])


def cross(left: Array, right: Array) -> Array:
    """Multiply vectors, shape=[..., 3], many times faster than `numpy.cross` for short arrays."""
    return _each("cross", 3, left, right)


def rotate(quaternion: Array, vector: Array) -> Array:
    """Rotate vectors, shape=[..., 3], by unit quaternions, shape=[..., 4]."""
    return _each("rotate", 3, quaternion, vector)


def exp(rotation_vector: Array) -> Array:
    """Turn rotation vectors, shape=[..., 3] in radians, into unit quaternions, shape=[..., 4]."""
    return _each("exp", 4, rotation_vector)


def log(quaternion: Array) -> Array:
    """Turn unit quaternions into the shortest rotation vectors.

    At exactly 180 degrees both signs of the axis are as short; that of the given vector part is returned.

    Parameters
    ----------
    quaternion : array-like, shape=[..., 4]

    Returns
    -------
    rotation_vector : array-like, shape=[..., 3]
        Radians, at most pi long.
    """
    return _each("log", 3, quaternion)


def difference(left: Array, right: Array) -> Array:
    """Return the shortest rotation vectors, shape=[..., 3], from `left` to `right`, in the frame of `left`."""
    return _each("difference", 3, left, right)


def angle(quaternion: Array) -> Array:
    """Return the angles, in [0, pi] radians, of unit quaternions, shape=[..., 4]; accurate near 0, unlike arccos."""
    return 2.0 * np.arctan2(np.linalg.norm(quaternion[..., :3], axis=-1), np.abs(quaternion[..., 3]))


def distance(left: Array, right: Array) -> Array:
    """Return the angles, in [0, pi] radians, between the rotations of unit quaternions, shape=[..., 4]."""
    # plain NumPy, as that is all that reading a clip needs
    a, b, c, d = np.moveaxis(np.asarray(left, dtype=np.float64), -1, 0)
    x, y, z, w = np.moveaxis(np.asarray(right, dtype=np.float64), -1, 0)
    vector = d * x - a * w - b * z + c * y, d * y + a * z - b * w - c * x, d * z - a * y + b * x - c * w
    sine = np.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
    return 2.0 * np.arctan2(sine, np.abs(d * w + a * x + b * y + c * z))


def make_continuous(quaternion: Array, axis: int = 0) -> Array:
    """Choose the signs of quaternions so that neighbours along an axis lie in one half-space.

    Parameters
    ----------
    quaternion : array-like, shape=[..., 4]
    axis : int
        Time axis.
        Optional, default: 0.

    Returns
    -------
    continuous : array-like, shape=[..., 4]
        The first along the axis keeps its sign.
    """
    moved = np.moveaxis(quaternion, axis, 0)
    flips = np.einsum("t...i,t...i->t...", moved[1:], moved[:-1]) < 0.0
    if not flips.any():
        return quaternion.copy()
    signs = np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
    continuous = np.concatenate([moved[:1], moved[1:] * signs[..., None]])
    return np.moveaxis(continuous, 0, axis)


def slerp(start: Array, end: Array, parameter: ArrayLike) -> Array:
    """Interpolate along the shorter great arc (Shoemake, "Animating rotation with quaternion curves", 1985).

    Parameters
    ----------
    start, end : array-like, shape=[..., 4]
        Unit quaternions.
    parameter : array-like, shape=[...]
        0 at the start, 1 at the end.

    Returns
    -------
    quaternion : array-like, shape=[..., 4]
    """
    return multiply(start, exp(np.asarray(parameter)[..., None] * difference(start, end)))


def to_matrix(quaternion: Array) -> Array:
    """Turn unit quaternions, shape=[..., 4], into rotation matrices, shape=[..., 3, 3]."""
    return _each("to_matrix", 9, quaternion).reshape(*quaternion.shape[:-1], 3, 3)


def from_matrix(matrix: Array) -> Array:
    """Turn rotation matrices, shape=[..., 3, 3], into unit quaternions, shape=[..., 4]."""
    return _each("from_matrix", 4, matrix.reshape(*matrix.shape[:-2], 9))


@cache
def _kernels() -> ModuleType:
    """Import the compiled loops on first use, since Numba takes long to load."""
    from geomstats_anim.kernels import quaternions

    return quaternions


def _each(kernel: str, width: int, *operands: Array) -> Array:
    """Apply a compiled loop along all leading axes, broadcast against each other; shape=[..., width]."""
    shape = operands[0].shape[:-1]
    if any(operand.shape[:-1] != shape for operand in operands):
        shape = np.broadcast_shapes(*(operand.shape[:-1] for operand in operands))
        operands = tuple(np.broadcast_to(operand, (*shape, operand.shape[-1])) for operand in operands)
    out = np.empty((*shape, width))
    getattr(_kernels(), kernel)(
        *(plain(operand).reshape(-1, operand.shape[-1]) for operand in operands), out.reshape(-1, width)
    )
    return out


def plain(operand: Array) -> Array:
    """Copy arrays that are read-only, strided or of another type, for which kernels would be compiled once more."""
    is_plain = operand.flags.carray and operand.dtype == np.float64
    return operand if is_plain else np.array(operand, dtype=np.float64, order="C")
