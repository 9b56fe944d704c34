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

    def scales(self, parts: BodyParts) -> Array:
        """Return how far the joints of each part turn in a segment, shape=[n, parts], radians."""
        square = (self.increments**2).sum(axis=(1, 3))
        count = self.is_there.sum(axis=1)
        means = [square[:, joints].sum(axis=1) / (count * len(joints)) for joints in parts.joints]
        return _LEAST_SCALE + np.sqrt(np.stack(means, axis=1))


def contexts_of(times: Array, rotations: Array, trunk: np.ndarray, vertical: Array) -> Contexts:
    """Describe what surrounds every segment between keys.

    Parameters
    ----------
    times : array-like, shape=[K]
        Seconds.
    rotations : array-like, shape=[K, B, 4]
    trunk : array-like of int
        Joints that carry the heading, from the root on.
    vertical : array-like, shape=[3]
        Unit vector upwards in the space of the skeleton.

    Returns
    -------
    contexts : Contexts
        Of K - 1 segments.
    """
    gaps, steps = np.diff(times), quat.difference(rotations[:-1], rotations[1:])
    n_segments = len(gaps)
    neighbours = np.arange(n_segments)[:, None] + np.arange(-(OFFSETS // 2), OFFSETS // 2 + 1)
    is_there = (neighbours >= 0) & (neighbours < n_segments)
    index = np.clip(neighbours, 0, n_segments - 1)
    ratio = np.where(is_there, gaps[:, None] / gaps[index], 0.0)
    increments = ratio[..., None, None] * steps[index]
    return Contexts(increments, is_there, _poses(rotations, trunk, vertical))


def _poses(rotations: Array, trunk: np.ndarray, vertical: Array) -> Array:
    rows = quat.to_matrix(rotations).reshape(*rotations.shape[:2], 9)
    in_world = rotations[:, trunk[0]]
    for i, joint in enumerate(trunk):
        if i:
            in_world = quat.multiply(in_world, rotations[:, joint])
        rows[:, joint] = 0.0
        rows[:, joint, :3] = quat.rotate(quat.conjugate(in_world), np.broadcast_to(vertical, (len(in_world), 3)))
    return 0.5 * (rows[:-1] + rows[1:])
