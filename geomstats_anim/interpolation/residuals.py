r"""Residuals off a spline: vectors c(t) by which a curve of rotations S(t) is turned to S(t) Exp(c(t)).

In a segment, with u its share of the duration g,

.. math:: c(u) = \sum_n a_n \sin(n \pi u) + g (h(u) e_k - h(1 - u) f_k), \quad h(u) = u - 6 u^3 + 8 u^4 - 3 u^5

so c is 0 at the keys. e and f are what the slopes of the sum lack, at both ends, of the mean of the slopes on both
sides of the key. h has slope 1 at 0, and otherwise no slope and no second derivative at either end; nor has the sum a
second derivative there. So c is twice continuously differentiable, and S Exp(c) is as smooth at the keys as S is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim.rotations import Array


@dataclass(frozen=True, eq=False)
class Residual:
    """Residuals of all segments between keys.

    Parameters
    ----------
    weights : array-like, shape=[K - 1, N + 2, B, 3]
        a_n, then e and f times the duration: of the functions of `basis`. Radians, in the frame of the joint.
    """

    weights: Array

    @classmethod
    def through_keys(cls, sines: Array, durations: Array, holds: np.ndarray) -> Residual:
        """Join segments so that slopes meet at the keys.

        Parameters
        ----------
        sines : array-like, shape=[K - 1, N, B, 3]
            a_n, radians.
        durations : array-like, shape=[K - 1]
        holds : array-like of bool, shape=[K - 1, B]
            Segments in which a joint rests; it has no residual there, and no slope at either end.

        Returns
        -------
        residual : Residual
        """
        if holds.any():
            sines = np.where(holds[:, None, :, None], 0.0, sines)
        order = np.pi * np.arange(1, sines.shape[1] + 1)
        slopes = np.stack([order, order * (-1.0) ** np.arange(1, len(order) + 1)])
        gaps = durations[:, None, None]
        n_segments, n_sines, *shape = sines.shape
        lacks = np.zeros((n_segments, 2, *shape))
        ends = np.matmul(slopes, sines.reshape(n_segments, n_sines, -1)).reshape(lacks.shape) / gaps[..., None]
        start, end = ends[1:, 0], ends[:-1, 1]
        still = (holds[1:] | holds[:-1])[..., None]
        goal = np.where(still, 0.0, 0.5 * (start + end))
        lacks[1:, 0], lacks[:-1, 1] = goal - start, goal - end
        return cls(np.concatenate([sines, gaps[..., None] * lacks], axis=1))

    def shared(self, shares: Array) -> Residual:
        """Take a share, shape=[B], of every joint's residual."""
        return replace(self, weights=self.weights * shares[:, None])

    def at_joints(self, joints: np.ndarray | slice) -> Residual:
        """Take some joints, by their indices, shape=[J]."""
        return replace(self, weights=self.weights[:, :, joints])

    def __call__(self, segment: np.ndarray, fraction: Array, order: int = 0) -> Array:
        """Evaluate c at shares of segments, or a derivative by the share.

        Parameters
        ----------
        segment : array-like of int, shape=[F]
        fraction : array-like, shape=[F]
            In [0, 1].
        order : int
            0, 1 or 2.
            Optional, default: 0.

        Returns
        -------
        vector : array-like, shape=[F, B, 3]
        """
        n_segments, n_functions, n_joints, _ = self.weights.shape
        values = basis(fraction, n_functions - 2, order)
        flat = self.weights.reshape(n_segments, n_functions, 3 * n_joints)
        if len(segment) <= n_segments:  # each segment about once
            return np.matmul(values[:, None], flat[segment]).reshape(-1, n_joints, 3)
        out = np.empty((len(fraction), 3 * n_joints))
        bounds = np.searchsorted(segment, np.arange(n_segments + 1))
        for k in np.unique(segment):
            span = slice(bounds[k], bounds[k + 1])
            np.matmul(values[span], flat[k], out=out[span])
        return out.reshape(-1, n_joints, 3)


def basis(fraction: Array, n_sines: int, order: int = 0) -> Array:
    """Return the functions that residuals are made of, or their derivatives by the share.

    Parameters
    ----------
    fraction : array-like, shape=[F]
    n_sines : int
        N.
    order : int
        0, 1 or 2.
        Optional, default: 0.

    Returns
    -------
    values : array-like, shape=[F, N + 2]
        sin(n pi u), then h(u) and -h(1 - u).
    """
    u, v = fraction[:, None], 1.0 - fraction[:, None]
    n = np.pi * np.arange(1, n_sines + 1)
    sines = (np.sin(n * u), n * np.cos(n * u), -(n**2) * np.sin(n * u))[order]
    return np.concatenate([sines, _ramp(u, order), (-1.0) ** (order + 1) * _ramp(v, order)], axis=1)


def _ramp(u: Array, order: int) -> Array:
    """Return h(u) or a derivative."""
    if order == 0:
        return u * (1.0 - u) ** 3 * (1.0 + 3.0 * u)
    if order == 1:
        return (1.0 - u) ** 2 * (1.0 + 2.0 * u - 15.0 * u**2)
    return -12.0 * u * (1.0 - u) * (3.0 - 5.0 * u)
