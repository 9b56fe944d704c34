r"""Surroundings of a segment between keys: the increments of rotation around it, and the pose in it.

The increments of a joint, in its own frame, are

.. math:: d_o = \frac{g_k}{g_{k + o}} \log(R_{k + o}^{-1} R_{k + o + 1}), \quad o = -2 \ldots 2

with the durations g of the segments. The pose is the mean of the rotation matrices at both keys; of the joints that
carry the heading, only the vertical, seen from the joint. So neither a turn of the whole clip about the vertical nor a
translation of it changes anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

OFFSETS = 5
"""Increments: of the segment, and of two on either side."""

_LEAST_SCALE = np.radians(1.0)
"""Added to the scale, so that what nearly rests is not blown up."""


@dataclass(frozen=True, eq=False)
class Contexts:
    """Surroundings of n segments.

    Parameters
    ----------
    increments : array-like, shape=[n, 5, B, 3]
        Radians; 0 where there is no segment.
    is_there : array-like of bool, shape=[n, 5]
        Which segments there are.
    poses : array-like, shape=[n, B, 9]
        Rows of rotation matrices; of the trunk, the vertical and zeros.
    """

    increments: Array
    is_there: np.ndarray
    poses: Array

    def at(self, segments: np.ndarray) -> Contexts:
        """Take some segments, by indices or a mask."""
        return Contexts(self.increments[segments], self.is_there[segments], self.poses[segments])

    @classmethod
    def joined(cls, contexts: list[Contexts]) -> Contexts:
        """Join contexts one after the other."""
        columns = zip(*((each.increments, each.is_there, each.poses) for each in contexts), strict=True)
        return cls(*map(np.concatenate, columns))

    @property
    def holds(self) -> np.ndarray:
        """Return which joints rest in a segment, shape=[n, B]."""
        return np.asarray((self.increments[:, OFFSETS // 2] ** 2).sum(axis=-1) <= STILL**2)

    def scales(self, parts: BodyParts) -> Array:
        """Return how far the joints of each part turn in a segment, shape=[n, parts], radians."""
        square = (self.increments**2).sum(axis=1).reshape(len(self.poses), -1)
        means = square @ np.repeat(parts.averages, 3, axis=0)
        return _LEAST_SCALE + np.sqrt(means / self.is_there.sum(axis=1)[:, None])


def contexts_of(times: Array, rotations: Array, trunk: np.ndarray, vertical: Array, stride: int = 1) -> Contexts:
    """Describe what surrounds every segment between keys.

    Parameters
    ----------
    times : array-like, shape=[K]
        Seconds.
    rotations : array-like, shape=[..., K, B, 4]
    trunk : array-like of int
        Joints that carry the heading, from the root on.
    vertical : array-like, shape=[3]
        Unit vector upwards in the space of the skeleton.
    stride : int
        s: segments lead from each key to the s-th after it, and their neighbours are those that meet them.
        Optional, default: 1.

    Returns
    -------
    contexts : Contexts
        Of K - s segments, along all leading axes one after the other.
    """
    gaps = times[stride:] - times[:-stride]
    steps = quat.difference(rotations[..., :-stride, :, :], rotations[..., stride:, :, :])
    n_segments = len(gaps)
    neighbours = np.arange(n_segments)[:, None] + stride * np.arange(-(OFFSETS // 2), OFFSETS // 2 + 1)
    is_there = (neighbours >= 0) & (neighbours < n_segments)
    index = np.clip(neighbours, 0, n_segments - 1)
    ratio = np.where(is_there, gaps[:, None] / gaps[index], 0.0)
    increments = ratio[..., None, None] * steps[..., index, :, :]
    rows = _rows(rotations, trunk, vertical)
    poses = 0.5 * (rows[..., :-stride, :, :] + rows[..., stride:, :, :])
    is_there = np.broadcast_to(is_there, increments.shape[:-2])
    n_joints = rotations.shape[-2]
    return Contexts(
        increments.reshape(-1, OFFSETS, n_joints, 3), is_there.reshape(-1, OFFSETS), poses.reshape(-1, n_joints, 9)
    )


def _rows(rotations: Array, trunk: np.ndarray, vertical: Array) -> Array:
    """Return the poses at keys, shape=[..., K, B, 9]."""
    rows = quat.to_matrix(rotations).reshape(*rotations.shape[:-1], 9)
    seen = vertical
    for joint in trunk:
        seen = np.einsum("...i,...ij->...j", seen, rows[..., joint, :].reshape(*rows.shape[:-2], 3, 3))
        rows[..., joint, :3], rows[..., joint, 3:] = seen, 0.0
    return rows
