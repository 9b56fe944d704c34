r"""Turn the joints above some points as little as possible, so that the points reach goals.

The correction of each frame is the smallest one in the metrics Z of the joints, to second order:

.. math:: \min_{c, d} \sum_j c_j^T Z_j c_j / s_j + |d|^2 / \rho^2 + \sum_p |g_p - p(c, d)|^2 / \lambda_p

where joint j turns by Exp(c_j) in its frame (for a right-invariant metric, in the frame of its parent), s_j is the
share of the body that it does not carry, and the joint that takes the whole body along moves by d. So what moves all of
the body comes last, where the joints below do not suffice. It is found by the Gauss-Newton method, in the multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.contacts.detection import BODY, body_size
from geomstats_anim.interpolation.curves import locate
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.markers import joint_matrices, place_some
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

_ENOUGH = 1e-2
"""Radians: the last step; the next would be its square."""

_CHUNK = 512
"""Frames that are solved for together."""


@dataclass(frozen=True, eq=False)
class Body:
    """Points of a body, and the joints above them.

    Parameters
    ----------
    dense : Animation
        Of these joints only.
    keys : Animation
        Likewise.
    joints : array-like of int, shape=[J]
        Which joints of the whole skeleton these are.
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
    moves_root : bool
    size : float
        Metres.
    """

    dense: Animation
    keys: Animation
    joints: np.ndarray
    points: np.ndarray
    is_above: np.ndarray
    root: int
    units: Array
    is_right: np.ndarray
    moves_root: bool
    size: float

    @classmethod
    def of(
        cls, dense: Animation, keys: Animation, points: np.ndarray, parameters: MetricParameters, moves_root: bool
    ) -> Body:
        """Take what matters for some points, by their joints, shape=[P]; see `plant`."""
        is_above = _ancestors(dense.skeleton, points)
        joints = np.union1d(np.flatnonzero(is_above.any(axis=0)), points)
        travels = (np.ptp(keys.translations[:, joints], axis=0) > 0.0).any(axis=-1)
        carried = _ancestors(dense.skeleton, np.arange(dense.n_joints)).mean(axis=0)[joints]
        lighter = np.maximum(1.0 - carried - 1.0 / dense.n_joints, _LEAST)
        return cls(
            _part(dense, joints),
            _part(keys, joints),
            joints,
            np.searchsorted(joints, points),
            is_above[:, joints],
            int(travels.argmax()),
            np.linalg.cholesky(np.linalg.inv(parameters.at(joints).matrices) * lighter[:, None, None]),
            parameters.is_right[joints],
            moves_root,
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
        rotations, translations : array-like, shape=[F, J, 4], shape=[F, J, 3]
        """
        rotations, translations = self.dense.rotations[frames], self.dense.translations[frames]
        patterns, pattern = np.unique(weights > 0.0, axis=0, return_inverse=True)
        for k in np.flatnonzero(patterns.any(axis=1)):
            active = patterns[k]
            body, alike = self._of_points(active), np.flatnonzero(pattern.ravel() == k)
            for start in range(0, len(alike), _CHUNK):
                some = alike[start : start + _CHUNK]
                goal, weight = (each[some][:, active] for each in (goals, weights))
                rotations[some], translations[some] = body._solved(frames[some], goal, weight)
        return rotations, translations

    def _of_points(self, active: np.ndarray) -> Body:
        """Take some of the points, as a mask."""
        return replace(self, points=self.points[active], is_above=self.is_above[active])

    def _solved(self, frames: np.ndarray, goals: Array, weights: Array) -> tuple[Array, Array]:
        motion = self.dense.at_frames(frames)
        rotations, translations = np.array(motion.rotations), np.array(motion.translations)
        above = np.flatnonzero(self.is_above.any(axis=0))
        units, root_units = self._units(frames, rotations)
        units = units[:, above]
        softness = self.size**2 * (_SOFT * (1.0 - weights) / np.maximum(weights, _NEARLY_NONE) + _DAMPING)
        softness = np.repeat(softness, 3, axis=1)
        matrices, forces = joint_matrices(motion), np.zeros_like(softness)
        for _ in range(_ITERATIONS):
            spread = self._derivative(matrices, motion.world, above, units, root_units)
            missing = (goals - matrices[..., 3][:, self.points]).reshape(len(frames), -1)
            added = _solve(spread @ spread.swapaxes(1, 2), softness, missing - softness * forces)
            forces += added
            moves = (added[:, None] @ spread).reshape(len(frames), -1, 3)
            turns = (units @ moves[:, :-1, :, None])[..., 0]
            rotations[:, above] = quat.multiply(rotations[:, above], quat.exp(turns))
            translations[:, self.root] += root_units[:, None] * moves[:, -1]
            if np.abs(turns).max(initial=0.0) < _ENOUGH:
                break
            place_some(motion, rotations, translations, np.arange(len(self.joints)), matrices)
        return rotations, translations

    def _units(self, frames: np.ndarray, rotations: Array) -> tuple[Array, Array]:
        """Return moves that cost one: turns in the frames of the joints, shape=[F, J, 3, 3], and that of the root.

        What rests from a key to the next is not free there, and comes to be so in the segments beside.
        """
        keys = self.keys
        segment, fraction = locate(keys.times, self.dense.times[frames])
        turn = quat.distance(keys.rotations[1:], keys.rotations[:-1]) >= STILL
        path = (keys.translations[1:, self.root] != keys.translations[:-1, self.root]).any(axis=-1)
        free = _freedom(np.concatenate([turn, path[:, None] & self.moves_root], axis=1), segment, fraction)
        units = free[:, :-1, None, None] * self.units
        right = np.flatnonzero(self.is_right)
        if len(right):
            units[:, right] = quat.to_matrix(rotations[:, right]).swapaxes(-1, -2) @ units[:, right]
        return units, _ROOT * self.size * free[:, -1]

    def _derivative(
        self, matrices: Array, world: Array | None, above: np.ndarray, units: Array, root_units: Array
    ) -> Array:
        """Return how points move with the units of turns of joints above, and of the root, shape=[F, 3 P, 3 A + 3]."""
        axes, origins = matrices[:, above, :, :3], matrices[..., 3]
        if self.dense.scales is not None or world is not None:
            lengths = np.linalg.norm(axes, axis=-2, keepdims=True)
            axes = axes / np.where(lengths > 0.0, lengths, 1.0)
        arms = origins[:, self.points, None] - origins[:, None, above]  # shape=[F, P, A, 3]
        arms *= self.is_above[:, above, None]
        moved = np.empty((len(matrices), len(self.points), 3, len(above) + 1, 3))
        # a turn w of a joint moves a point by (axes w) x arm
        x, y, z = ((axes @ units)[:, None, :, k] for k in range(3))
        u, v, w = (arms[..., k, None] for k in range(3))
        for k, (plus, minus) in enumerate(((y * w, z * v), (z * u, x * w), (x * v, y * u))):
            np.subtract(plus, minus, out=moved[:, :, k, :-1])
        parent = self.dense.skeleton.parents[self.root]
        placed = matrices[:, parent, :, :3] if parent >= 0 else np.eye(3)[None] if world is None else world[:, :, :3]
        moved[:, :, :, -1] = (root_units[:, None, None] * placed)[:, None] * self.is_above[:, self.root, None, None]
        return moved.reshape(len(matrices), 3 * len(self.points), -1)


def _ancestors(skeleton: Skeleton, joints: np.ndarray) -> np.ndarray:
    """Return which joints are above some, shape=[J, B]."""
    is_above = np.zeros((len(joints), skeleton.n_joints), dtype=bool)
    above = skeleton.parents[joints]
    while (above >= 0).any():
        has = above >= 0
        is_above[has, above[has]] = True
        above = np.where(has, skeleton.parents[above], -1)
    return is_above


def _part(animation: Animation, joints: np.ndarray) -> Animation:
    """Take some joints, with each all above it."""
    whole = animation.skeleton
    parents = whole.parents[joints]
    skeleton = Skeleton(
        tuple(whole.joints[joint] for joint in joints),
        np.where(parents >= 0, np.searchsorted(joints, parents), -1),
        whole.rest_translations[joints],
        whole.rest_rotations[joints],
    )
    scales = None if animation.scales is None else animation.scales[:, joints]
    rotations, translations = animation.rotations[:, joints], animation.translations[:, joints]
    return Animation(skeleton, animation.times, rotations, translations, scales, animation.world)


def _solve(normal: Array, softness: Array, vectors: Array) -> Array:
    """Solve (N + diag(s)) x = v, shape=[F, 3 P]; equations are scaled alike first, so that soft ones do no harm."""
    diagonal = np.einsum("fii->fi", normal)
    diagonal += softness
    scale = 1.0 / np.sqrt(diagonal)
    return scale * np.linalg.solve(scale[:, :, None] * normal * scale[:, None], (scale * vectors)[..., None])[..., 0]


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
