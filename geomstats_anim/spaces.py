"""Values that are compared along time: rotations and points, with one interface; in plain NumPy, for short work."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array


class Space(Protocol):
    """Operations on values that the rules need, shape=[..., C].

    Attributes
    ----------
    farthest : float
        Distance from which on being farther away counts no more than in proportion.
    """

    farthest: float

    def distance(self, left: Array, right: Array) -> Array:
        """Return distances, shape=[...]: radians, or lengths in a unit."""

    def same(self, left: Array, right: Array) -> np.ndarray:
        """Return whether values mean the same, bit for bit, shape=[...]."""

    def between(self, left: Array, right: Array, parameter: Array) -> Array:
        """Return values on the way at parameters, shape=[...], from 0 to 1."""

    def before(self, first: Array, second: Array) -> Array:
        """Return the values from which a step leads to the first that is as the one from there to the second."""


class Turns:
    """Quaternions of any length but zero, as rotations; in plain NumPy, for looking for faults is short."""

    farthest = np.pi

    def distance(self, left: Array, right: Array) -> Array:
        """Return angles, shape=[...], in radians."""
        return quat.distance(_unit(left), _unit(right))

    def same(self, left: Array, right: Array) -> np.ndarray:
        """Return whether quaternions are the same or each other's negative, shape=[...]."""
        return (left == right).all(axis=-1) | (left == -right).all(axis=-1)

    def between(self, left: Array, right: Array, parameter: Array) -> Array:
        """Return unit quaternions on the chord."""
        left, right = _unit(left), _unit(right)
        right = np.where((left * right).sum(axis=-1, keepdims=True) < 0.0, -right, right)
        return _unit(left + parameter[..., None] * (right - left))

    def before(self, first: Array, second: Array) -> Array:
        """Return the second quaternions, mirrored at the first."""
        first, second = _unit(first), _unit(second)
        return 2.0 * (first * second).sum(axis=-1, keepdims=True) * first - second


class Points:
    """Vectors.

    Parameters
    ----------
    unit : float
        Length that means as much as a turn of one radian.
    """

    farthest = 1.0

    def __init__(self, unit: float) -> None:
        self.unit = unit

    def distance(self, left: Array, right: Array) -> Array:
        """Return distances, shape=[...], in the unit."""
        return np.linalg.norm(np.asarray(left, dtype=np.float64) - right, axis=-1) / self.unit

    def same(self, left: Array, right: Array) -> np.ndarray:
        """Return whether points are the same, shape=[...]."""
        return (left == right).all(axis=-1)

    def between(self, left: Array, right: Array, parameter: Array) -> Array:
        """Return points on the line."""
        return left + parameter[..., None] * (np.asarray(right, dtype=np.float64) - left)

    def before(self, first: Array, second: Array) -> Array:
        """Return the second points, mirrored at the first."""
        return 2.0 * np.asarray(first, dtype=np.float64) - second


def _unit(quaternion: Array) -> Array:
    return quat.normalize(np.asarray(quaternion, dtype=np.float64))
