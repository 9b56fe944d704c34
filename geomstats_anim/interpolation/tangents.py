r"""Velocities at the keys of a spline, from those with which its segments leave one key and arrive at the next.

A segment is a straight line or a geodesic g from the identity, bent by a cubic c: with u its share of the duration h,

.. math:: c(u) = h (u (1 - u)^2 (v_k - w_k^-) - u^2 (1 - u) (v_{k + 1} - w_k^+))

leads the velocity from its own, w^-, to v at the start, and from w^+ to v at the end. Two choices of v are used:

* local: that of the parabola through three keys (Bessel's tangents), of second order however uneven the keys;
* smooth: such that acceleration is continuous. The body acceleration of :math:`g \exp(c)` is
  :math:`w' - c' \times w + c''` where c = 0, and c' = v - w there, so the condition is linear in v on SO(3) too, where
  `scipy.spatial.transform.RotationSpline` has to iterate.

Local tangents miss what is dense, smooth ones ring where keys are sparse; the mean of both predicts best of all single
choices. The tension leads from the segments themselves (0) to that mean (1), which makes velocity continuous, and on to
the smooth ones (2), which make acceleration continuous.

At both ends c'' is 0, the natural end. Where a segment does not move, v is 0 at both of its keys, so that it stays.
"""

from __future__ import annotations

from copy import copy
from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.kernels import hermite as equations
from geomstats_anim.rotations import Array

STILL = 1e-6
"""Motion in a segment, radians or metres, that is none: what float32 makes of a constant."""


class _Rows(NamedTuple):
    """Equations for the velocities at the keys, one row per key.

    lower v_{k-1} + main v_k + upper v_{k+1} = sources . (w^-_{k-1}, w^+_{k-1}, w^-_k, w^+_k)

    Attributes
    ----------
    matrix : array-like, shape=[3, K, B]
        lower, main and upper.
    sources : array-like, shape=[4, K, B]
    """

    matrix: Array
    sources: Array

    @property
    def transposed(self) -> Array:
        """Return the coefficients of the transposed equations."""
        lower, main, upper = self.matrix
        matrix = np.zeros_like(self.matrix)
        matrix[0, 1:], matrix[1], matrix[2, :-1] = upper[:-1], main, lower[1:]
        return matrix


class KeyVelocities:
    """Velocities at the keys, and how the segments have to be bent for them.

    Parameters
    ----------
    durations : array-like, shape=[n]
        Of the segments, seconds.
    start, end : array-like, shape=[n, B, 3]
        Velocities of the segments where they leave their first key, and where they arrive at their last.
    tension : array-like, shape=[B]
        From 0, no bending, to 2.
    accelerations : pair of array-like, shape=[n, B, 3]
        Body accelerations of geodesics there.
        Optional, default: None, the segments are straight lines.

    Attributes
    ----------
    bends : pair of array-like, shape=[n, B, 3]
        Derivatives of the segments' c by u, at both ends.
    """

    def __init__(
        self,
        durations: Array,
        start: Array,
        end: Array,
        tension: Array,
        accelerations: tuple[Array, Array] | None = None,
    ) -> None:
        self._durations = durations[:, None, None]
        self._start, self._end = start, end
        holds = ((start * self._durations) ** 2).sum(axis=-1) <= STILL**2
        self._local, self._smooth = (_rows(durations, holds, is_smooth) for is_smooth in (False, True))
        self._turn = np.zeros((len(durations) + 1, *start.shape[1:]))
        right = _right_side(self._smooth, start, end)
        if accelerations is not None:
            # only rows of inner keys that move have lower and upper coefficients both
            lower, _, upper = self._smooth.matrix
            self._inner = ((lower * upper)[1:-1] != 0.0)[..., None]
            self._turn[1:-1] = self._inner * (start[1:] - end[:-1])
            right[1:-1] += self._inner * (accelerations[0][1:] - accelerations[1][:-1])
        self._local_velocity = _solve(
            self._local.matrix, np.zeros_like(self._turn), _right_side(self._local, start, end)
        )
        self._smooth_velocity = _solve(self._smooth.matrix, self._turn, right)
        self._tighten(tension)

    def tightened(self, tension: Array) -> KeyVelocities:
        """Take another tension, shape=[B], which is quick."""
        other = copy(self)
        other._tighten(tension)
        return other

    def _tighten(self, tension: Array) -> None:
        self._tension = tension
        self._strength = np.minimum(tension, 1.0)[:, None]
        self._smoothness = 0.5 * np.maximum(tension, 1.0)[:, None]
        velocity = self._local_velocity + self._smoothness * (self._smooth_velocity - self._local_velocity)
        self._change = self._durations * (velocity[:-1] - self._start), self._durations * (velocity[1:] - self._end)
        self.bends = self._strength * self._change[0], self._strength * self._change[1]

    def pull_back(self, bends: tuple[Array, Array]) -> tuple[Array, Array, Array, Array, Array]:
        """Pull the derivative of a scalar by the bends back to one by what they are made of.

        Parameters
        ----------
        bends : pair of array-like, shape=[n, B, 3]

        Returns
        -------
        start, end, start_acceleration, end_acceleration : array-like, shape=[n, B, 3]
        tension : array-like, shape=[B]
        """
        by_change = tuple(self._strength * self._durations * bend for bend in bends)
        by_velocity = np.zeros_like(self._turn)
        by_velocity[:-1] += by_change[0]
        by_velocity[1:] += by_change[1]
        start, end = -by_change[0], -by_change[1]
        by_row = _solve(self._local.transposed, np.zeros_like(self._turn), (1.0 - self._smoothness) * by_velocity)
        equations.add_right_side(self._local.sources, by_row, start, end)
        by_row = _solve(self._smooth.transposed, -self._turn, self._smoothness * by_velocity)
        equations.add_right_side(self._smooth.sources, by_row, start, end)
        by_turn = quat.cross(self._smooth_velocity, by_row)[1:-1] * self._inner
        start[1:] += by_turn
        end[:-1] -= by_turn
        accelerations = np.zeros_like(start), np.zeros_like(end)
        accelerations[0][1:] = self._inner * by_row[1:-1]
        accelerations[1][:-1] = -(self._inner * by_row[1:-1])
        return start, end, *accelerations, self.by_tension(bends)

    def by_tension(self, bends: tuple[Array, Array]) -> Array:
        """Pull the derivative of a scalar by the bends back to one by the tension, shape=[B]."""
        beyond = self._smooth_velocity - self._local_velocity
        total = np.zeros(len(self._tension))
        for bend, change, smoother in zip(bends, self._change, (beyond[:-1], beyond[1:]), strict=True):
            slack = (bend * change).sum(axis=(0, 2))
            tight = 0.5 * (bend * self._durations * smoother).sum(axis=(0, 2))
            total += np.where(self._tension < 1.0, slack, tight)
        return total


def hermite(parameter: Array, order: int = 0) -> tuple[Array, Array]:
    """Return the weights of the two bends of a segment in c, or their derivatives by the parameter.

    Parameters
    ----------
    parameter : array-like, shape=[F]
        Share of the segment, in [0, 1].
    order : int
        0, 1 or 2.
        Optional, default: 0.

    Returns
    -------
    start, end : array-like, shape=[F]
    """
    u = parameter
    if order == 0:
        return equations.weights.py_func(u)
    if order == 1:
        return (1.0 - u) * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)
    return 6.0 * u - 4.0, 6.0 * u - 2.0


def _rows(durations: Array, holds: np.ndarray, is_smooth: bool) -> _Rows:
    rows = _Rows(*(np.zeros((n, len(durations) + 1, holds.shape[1])) for n in (3, 4)))
    equations.fill_rows(np.array(durations), holds, is_smooth, rows.matrix, rows.sources)
    return rows


def _right_side(rows: _Rows, start: Array, end: Array) -> Array:
    right = np.zeros((len(start) + 1, *start.shape[1:]))
    equations.fill_right_side(rows.sources, np.array(start, order="C"), np.array(end, order="C"), right)
    return right


def _solve(matrix: Array, turn: Array, right: Array) -> Array:
    """Solve lower v_{k-1} + main v_k + v_k x turn_k + upper v_{k+1} = right_k for v, shape=[K, B, 3]."""
    out = np.empty_like(right)
    lower, main, upper = matrix
    equations.eliminate(lower, main, upper, turn, right, out)
    return out
