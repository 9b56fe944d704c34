r"""Turn the joints above some points as little as possible, so that the points reach goals.

The correction of each frame is the smallest one in the metrics Z of the joints, to second order:

.. math:: \min_{c, d} \sum_j c_j^T Z_j c_j / s_j + |d|^2 / \rho^2 + \sum_p |g_p - p(c, d)|^2 / \lambda_p

where joint j turns by Exp(c_j) in its frame (for a right-invariant metric, in the frame of its parent), s_j is the
share of the body that it does not carry, and the joint that takes the whole body along moves by d. So what moves all of
the body comes last, where the joints below do not suffice. It is found by the Gauss-Newton method, in the multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.contacts.detection import BODY, body_size
from geomstats_anim.interpolation.curves import locate
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.kernels import reaching as kernel
from geomstats_anim.markers import joint_matrices
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

_ROOT = 0.08
"""rho, as a share of the size of the body: how far the root moves for one radian of a joint."""

_SOFT = 0.1
"""lambda of a point of weight 1/2, as a share of the squared size: about what a radian does to a point."""

_DAMPING = 1e-6
"""lambda of a point of weight 1, likewise: what is out of reach is left so."""

_LEAST = 0.01
"""Share of the body that a joint does not carry, at least."""

_NEARLY_NONE = 1e-9
"""Weight that no point is below."""

_ITERATIONS = 8

_ENOUGH = 1e-3
"""Radians: the last step of a frame; the next would be its square."""


@dataclass(frozen=True, eq=False)
class Body:
    """Points of a body, and the joints above them.

    Parameters
    ----------
    dense : Animation
        Of the whole skeleton.
    key_times : array-like, shape=[K]
        Seconds.
    moves : array-like of bool, shape=[K - 1, J + 1]
        Which of them turn from each key to the next, and whether the root may move there.
    joints : array-like of int, shape=[J]
        Which joints of the whole skeleton these are.
    parents : array-like of int, shape=[J]
        Which of them is above each, or -1.
    points : array-like of int, shape=[P]
        Which of them are points.
    is_above : array-like of bool, shape=[P, J]
        Which of them move which points.
    root : int
        Which of them moves with the whole body.
    units : array-like, shape=[J, 3, 3]
        Turns that cost one: L in the inverse L L^T of each metric.
    is_right : array-like of bool, shape=[J]
        Whose metric is right-invariant.
    size : float
        Metres.
    """

    dense: Animation
    key_times: Array
    moves: np.ndarray
    joints: np.ndarray
    parents: np.ndarray
    points: np.ndarray
    is_above: np.ndarray
    root: int
    units: Array
    is_right: np.ndarray
    size: float

    @classmethod
    def of(
        cls, dense: Animation, keys: Animation, points: np.ndarray, parameters: MetricParameters, moves_root: bool
    ) -> Body:
        """Take what matters for some points, by their joints, shape=[P]; see `plant`."""
        is_above = _ancestors(dense.skeleton, points)
        joints = np.union1d(np.flatnonzero(is_above.any(axis=0)), points)
        parents = dense.skeleton.parents[joints]
        root = int((np.ptp(keys.translations[:, joints], axis=0) > 0.0).any(axis=-1).argmax())
        lighter = np.maximum(1.0 - _carried(dense.skeleton)[joints], _LEAST)
        turns = quat.distance(keys.rotations[1:, joints], keys.rotations[:-1, joints]) >= STILL
        path = (keys.translations[1:, joints[root]] != keys.translations[:-1, joints[root]]).any(axis=-1)
        return cls(
            dense,
            keys.times,
            np.concatenate([turns, path[:, None] & moves_root], axis=1),
            joints,
            np.where(parents >= 0, np.searchsorted(joints, parents), -1),
            np.searchsorted(joints, points),
            is_above[:, joints],
            root,
            np.linalg.cholesky(np.linalg.inv(parameters.matrices[joints]) * lighter[:, None, None]),
            parameters.is_right[joints],
            body_size(joint_matrices(keys)[..., 3]) or BODY,
        )

    def reached(self, frames: np.ndarray, goals: Array, weights: Array) -> tuple[Array, Array]:
        """Turn the joints, and move the root, so that points reach goals.

        Parameters
        ----------
        frames : array-like of int, shape=[F]
        goals : array-like, shape=[F, P, 3]
            In the world, metres.
        weights : array-like, shape=[F, P]
            From 0, where a point is free, to 1, where it has to reach its goal.

        Returns
        -------
        rotations, translations : array-like, shape=[F, B, 4], shape=[F, B, 3]
            Of all joints.
        """
        dense, number = self.dense, len(frames)
        rotations, translations = dense.rotations[frames], dense.translations[frames]
        hold = np.maximum(weights, _NEARLY_NONE)
        softness = self.size**2 * np.where(weights > 0.0, _SOFT * (1.0 - weights) / hold + _DAMPING, np.inf)
        scales = np.ones(translations.shape) if dense.scales is None else dense.scales[frames]
        world = np.broadcast_to(np.eye(3, 4), (number, 3, 4)) if dense.world is None else dense.world[frames]
        kernel.reach(
            self.joints,
            self.parents,
            self.points,
            np.concatenate([self.is_above, self.is_above[:, [self.root]]], axis=1),
            self.root,
            np.concatenate([self.units, _ROOT * self.size * np.eye(3)[None]]),
            self.is_right,
            _freedom(self.moves, *locate(self.key_times, dense.times[frames])),
            quat.plain(world),
            scales,
            quat.plain(goals),
            softness,
            _ENOUGH,
            _ITERATIONS,
            rotations,
            translations,
        )
        return rotations, translations


def _ancestors(skeleton: Skeleton, joints: np.ndarray) -> np.ndarray:
    """Return which joints are above some, shape=[J, B]."""
    is_above = np.zeros((len(joints), skeleton.n_joints), dtype=bool)
    above = skeleton.parents[joints]
    while (above >= 0).any():
        has = above >= 0
        is_above[has, above[has]] = True
        above = np.where(has, skeleton.parents[above], -1)
    return is_above


def _carried(skeleton: Skeleton) -> Array:
    """Return the share of all joints that each carries, itself included, shape=[B]."""
    carried, parents = [1] * skeleton.n_joints, skeleton.parents.tolist()
    for joint in range(skeleton.n_joints - 1, 0, -1):  # parents come before their children
        if parents[joint] >= 0:
            carried[parents[joint]] += carried[joint]
    return np.array(carried) / skeleton.n_joints


def smooth(share: Array) -> Array:
    """Ease from 0 to 1, at rest at both ends."""
    return share**2 * (3.0 - 2.0 * share)


def _freedom(moves: np.ndarray, segment: np.ndarray, fraction: Array) -> Array:
    """Return a weight, shape=[F, J], that is 0 in segments without motion, and eases to 1 away from them.

    Parameters
    ----------
    moves : array-like of bool, shape=[K - 1, J]
    segment, fraction : array-like, shape=[F]
    """
    edge = np.ones((1, moves.shape[1]), dtype=bool)
    padded = np.concatenate([edge, moves, edge])
    rise, fall = (smooth(np.minimum(2.0 * share, 1.0))[:, None] for share in (fraction, 1.0 - fraction))
    before, after = (np.where(padded[segment + k], 1.0, ease) for k, ease in ((0, rise), (2, fall)))
    return moves[segment] * before * after
