"""Check of how much of a prediction helps: every second key of the clip is hidden, and predicted from the others."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Skeleton
from geomstats_anim.kinematics import place
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

SHARES = np.linspace(0.0, 1.0, 6)
_CAUTION = 1.2
"""A full share has to save this part of the error, divided by the squared number of hidden keys."""

_LEAST = 1e-9
"""Errors, radians or metres, that are none."""


@dataclass(frozen=True, eq=False)
class HiddenPoses:
    """Poses that are known, and what a spline and a library say of them.

    Parameters
    ----------
    skeleton : Skeleton
    parts : BodyParts
    splines : array-like, shape=[n, B, 4]
        Of the spline.
    residuals : array-like, shape=[n, B, 3]
        Predicted for it.
    truth : array-like, shape=[n, B, 4]
    """

    skeleton: Skeleton
    parts: BodyParts
    splines: Array
    residuals: Array
    truth: Array

    @cached_property
    def _turned(self) -> Array:
        """Return the poses with each share of the residuals, shape=[shares, n, B, 4]."""
        return quat.multiply(self.splines, quat.exp(SHARES[:, None, None, None] * self.residuals))

    @cached_property
    def _ends(self) -> Array:
        return self._ends_of(self.truth)

    @cached_property
    def angles(self) -> Array:
        """Return the errors of angles, shape=[parts, shares, n], means over the joints of each part."""
        found = quat.distance(self._turned, self.truth)
        return np.moveaxis(found @ self.parts.averages, -1, 0)

    @cached_property
    def limb_ends(self) -> Array:
        """Return the distances of bone ends, shape=[limbs, shares, n], with the torso as the spline has it."""
        poses = self._turned.copy()
        poses[:, :, self.parts.joints[0]] = self.splines[:, self.parts.joints[0]]
        return np.moveaxis(self._missed(poses) @ self.parts.averages[:, 1:], -1, 0)

    def torso_ends(self, limbs: np.ndarray) -> Array:
        """Return the distances of all bone ends by the share of the torso, shape=[shares, n].

        Parameters
        ----------
        limbs : array-like of int, shape=[limbs]
            Indices of the shares of the limbs.
        """
        poses = self._turned.copy()
        for joints, share in zip(self.parts.joints[1:], limbs, strict=True):
            poses[:, :, joints] = self._turned[share][:, joints]
        return self._missed(poses).mean(axis=-1)

    def _missed(self, poses: Array) -> Array:
        """Return the distances of bone ends, shape=[..., B]."""
        x, y, z = np.moveaxis(self._ends_of(poses) - self._ends, -1, 0)
        return np.sqrt(x * x + y * y + z * z)

    def _ends_of(self, rotations: Array) -> Array:
        """Return the ends of bones, shape=[..., B, 3], of poses that stand where the rest pose does."""
        flat = rotations.reshape(-1, self.skeleton.n_joints, 4)
        rest = np.broadcast_to(self.skeleton.rest_translations, (*flat.shape[:2], 3))
        return place(self.skeleton, flat, rest).ends.reshape(*rotations.shape[:-1], 3)


def best_shares(hidden: HiddenPoses, doubts: Array) -> Array:
    """Choose for each part of the body the share of a prediction that helps most.

    What counts is the mean of two ratios to the error of the spline: of angles, and of distances of bone ends. The
    limbs come first, with the torso as the spline has it; then the torso, for the bone ends of the whole body, whose
    doubts are those of the limbs and not counted again. Neither ratio may grow, and both are raised before, by as many
    standard deviations from key to key as are doubted.

    Parameters
    ----------
    hidden : HiddenPoses
        Keys that were hidden.
    doubts : array-like, shape=[parts, shares, 2]
        By how many standard deviations the ratios are larger where a prediction is used than where it is checked.

    Returns
    -------
    shares : array-like, shape=[parts]
    """
    n_limbs = len(doubts) - 1
    limbs = _best(hidden.angles[1:], hidden.limb_ends, doubts[1:]) if n_limbs else np.empty(0, dtype=np.intp)
    of_torso = doubts[:1] * [1.0, 0.0] if n_limbs else doubts
    torso = _best(hidden.angles[:1], hidden.torso_ends(limbs)[None], of_torso)
    return SHARES[np.concatenate([torso, limbs])]


def ratios_to_spline(errors: Array) -> Array:
    """Divide errors, shape=[..., shares, n], by the mean of those without any share."""
    return errors / np.maximum(errors[..., :1, :].mean(axis=-1, keepdims=True), _LEAST)


def _best(angles: Array, ends: Array, doubts: Array) -> np.ndarray:
    """Return the index of the best share of each part, from its errors with each, shape=[parts, shares, n]."""
    ratios, n = ratios_to_spline(np.stack([angles, ends])), angles.shape[-1]
    more = ratios - ratios[:, :, :1]
    doubted = more.mean(axis=-1) + doubts.transpose(2, 0, 1) * more.std(axis=-1)
    cost = doubted.mean(axis=0) + _CAUTION / n**2 * SHARES
    return np.where((doubted <= 0.0).all(axis=0), cost, np.inf).argmin(axis=-1)
