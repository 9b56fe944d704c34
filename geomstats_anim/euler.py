"""Euler angles that are continuous along time, for formats and programs that have no quaternions."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
"""Orders of three axes, each turned by the ones before: ZYX is R = R_z R_y R_x, and matrices of columns."""

LOCK = 1e-6
"""Cosine of the second angle below which the first and the third turn about one axis."""


def to_euler(rotations: Array, order: str, n_turns: int = 3) -> Array:
    """Return the angles of three turns, as continuous along time as they can be.

    Of both triples of angles that are one rotation, and of all full turns, those are taken that are nearest to the
    frame before, so that no angle jumps where the rotation does not. Where the first and the third axis fall together,
    the third angle stays as it was.

    Parameters
    ----------
    rotations : array-like, shape=[F, ..., 4]
        Unit quaternions.
    order : str
        One of `ORDERS`.
    n_turns : int
        How many of the three turns there are, if the rotations allow that: the angles of the others are as near to 0 as
        can be.
        Optional, default: 3.

    Returns
    -------
    angles : array-like, shape=[F, ..., 3]
        Radians, in the order of the axes. If there are three turns, the second of the first frame is within a quarter.

    Raises
    ------
    ValueError
        If there is no such order.
    """
    if order not in ORDERS:
        raise ValueError(f"order must be one of {', '.join(ORDERS)}, not {order!r}.")
    i, j, k = ("XYZ".index(axis) for axis in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    matrices = quat.to_matrix(np.asarray(rotations, dtype=np.float64))
    cosine = np.hypot(matrices[..., i, i], matrices[..., i, j])
    second = np.arctan2(sign * matrices[..., i, k], cosine)
    third = _last_known(np.arctan2(-sign * matrices[..., i, j], matrices[..., i, i]), cosine > LOCK)
    if n_turns < 3:  # it is none, or a half turn that the other name takes away
        third = np.where(np.abs(third) > np.pi / 2.0, np.pi, 0.0)
    # with the third turn undone, the first is left in the plane that the second turns about
    c, s = np.cos(third), np.sin(third)
    first = np.arctan2(
        c * sign * matrices[..., k, j] + s * matrices[..., k, i],
        c * matrices[..., j, j] + s * sign * matrices[..., j, i],
    )
    return _continuous(np.stack([first, second, third], axis=-1), n_turns)


def from_euler(angles: Array, order: str) -> Array:
    """Return the unit quaternions, shape=[..., 4], of turns by angles, shape=[..., 3] in radians; see `to_euler`."""
    turns = [quat.exp(angles[..., n, None] * np.eye(3)["XYZ".index(axis)]) for n, axis in enumerate(order)]
    return quat.multiply(quat.multiply(turns[0], turns[1]), turns[2])


def _last_known(angles: Array, is_known: np.ndarray) -> Array:
    """Put, where an angle is not known, the last that is; before that the first, and 0 where none is."""
    frames = np.arange(len(angles)).reshape(-1, *[1] * (angles.ndim - 1))
    last = np.maximum.accumulate(np.where(is_known, frames, -1), axis=0)
    first = np.argmax(is_known, axis=0)[None]
    filled = np.take_along_axis(angles, np.where(last < 0, first, last), axis=0)
    return np.where(is_known.any(axis=0), filled, 0.0)


def _continuous(angles: Array, n_turns: int) -> Array:
    """Choose between both names of each rotation, and among full turns."""
    other = np.stack([angles[..., 0] + np.pi, np.pi - angles[..., 1], angles[..., 2] + np.pi], axis=-1)
    is_other = np.zeros(angles.shape[:-1], dtype=bool)
    if n_turns < 3:
        is_other = _sizes(other[..., n_turns:]) < _sizes(angles[..., n_turns:])
    else:
        # two names differ from two others as their other names do, so it is enough to know where the name changes
        stays, changes = (_sizes(after[1:] - angles[:-1]) for after in (angles, other))
        is_other[1:] = np.cumsum(changes < stays, axis=0) % 2 == 1
    chosen = np.where(is_other[..., None], other, angles)
    chosen[..., n_turns:] = _wrapped(chosen[..., n_turns:])
    return np.unwrap(chosen, axis=0)


def _sizes(angles: Array) -> Array:
    return np.abs(_wrapped(angles)).sum(axis=-1)


def _wrapped(angles: Array) -> Array:
    """Take away full turns, so that angles are within a half."""
    return angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi))
