"""Check of how much of a prediction helps: every second key of the clip is hidden, and predicted from the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Skeleton
from geomstats_anim.kernels.shares import miss
from geomstats_anim.kinematics import breadth_first
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

MOST_HIDDEN = 20
"""Keys that are hidden; of more, these tell as much."""

SHARES = np.linspace(0.0, 1.0, 6)
_CAUTION = 1.2
"""A full share has to save this part of the error, divided by the squared number of hidden keys."""

_MOST_HELPED = 0.75
"""Share of the angles that a spline misses, in the mean over parts, from which on nothing is taken off."""

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

    def of_limbs(self) -> Array:
        """Return the errors of the limbs by their share, with the torso as the spline has it.

        Returns
        -------
        errors : array-like, shape=[2, limbs, shares, n]
            Means over the joints of each limb: angles, radians, then distances of bone ends, metres.
        """
        shares = np.where(self.parts.of_joint > 0, SHARES[:, None], 0.0)
        return np.moveaxis(self._errors(shares) @ self.parts.averages[:, 1:], -1, 1)

    def of_torso(self, limbs: Array) -> Array:
        """Return the errors by the share of the torso.

        Parameters
        ----------
        limbs : array-like, shape=[limbs]
            Shares of the limbs.

        Returns
        -------
        errors : array-like, shape=[2, 1, shares, n]
            Means over the joints of the torso of angles; and over all joints of the distances of bone ends.
        """
        of_limbs = np.concatenate([[0.0], limbs])[self.parts.of_joint]
        angles, distances = self._errors(np.where(self.parts.of_joint > 0, of_limbs, SHARES[:, None]))
        return np.stack([angles @ self.parts.averages[:, 0], distances.mean(axis=-1)])[:, None]

    def _errors(self, shares: Array) -> Array:
        """Return angles, and distances of bone ends where the skeleton stands at rest, shape=[2, shares, n, B].

        Parameters
        ----------
        shares : array-like, shape=[shares, B]
        """
        skeleton, errors = self.skeleton, np.empty((2, len(shares), *self.truth.shape[:2]))
        offsets = np.tile(skeleton.rest_translations, (len(shares) + 1, 1, 1))
        poses = map(quat.plain, (self.splines, self.residuals, self.truth))
        tree = breadth_first(skeleton), np.array(skeleton.parents), np.array(skeleton.bone_ends)
        miss(*tree, offsets, *poses, shares, *errors)
        return errors


def spread(n: int, most: int) -> np.ndarray:
    """Choose indices below n, at most so many, evenly but out of step with what is periodic, as walks are."""
    if n <= most:
        return np.arange(n)
    jitter = np.random.default_rng(0).random(most)
    return np.unique((n / most * (np.arange(most) + jitter)).astype(np.intp))


def best_shares(hidden: HiddenPoses, doubts: Array) -> Array:
    """Choose for each part of the body the share of a prediction that helps most.

    What counts is the mean of two ratios to the error of the spline: of angles, and of distances of bone ends. The
    limbs come first, with the torso as the spline has it; then the torso, for the bone ends of the whole body, whose
    doubts are those of the limbs and not counted again. Neither ratio may grow, and both are raised before, by as many
    standard deviations from key to key as are doubted. A motion that is like those of the library is so in most parts
    of the body: where few are helped, these have less of it.

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
    of_limbs = hidden.of_limbs()
    limbs = _best(of_limbs, doubts[1:])
    of_torso = hidden.of_torso(limbs)
    torso = _best(of_torso, doubts[:1] * [1.0, 0.0] if len(limbs) else doubts)
    shares = np.concatenate([torso, limbs])
    missed = np.concatenate([of_torso, of_limbs], axis=1)[0, :, 0].mean(axis=-1)
    helped = missed.dot(shares) / max(missed.sum(), _LEAST)
    return shares * min(1.0, helped / _MOST_HELPED)


def ratios_to_spline(errors: Array) -> Array:
    """Divide errors, shape=[..., shares, n], by the mean of those without any share."""
    return errors / np.maximum(errors[..., :1, :].mean(axis=-1, keepdims=True), _LEAST)


def _best(errors: Array, doubts: Array) -> Array:
    """Return the best share of each part, from its errors with each, shape=[2, parts, shares, n]."""
    ratios, n = ratios_to_spline(errors), errors.shape[-1]
    more = ratios - ratios[:, :, :1]
    doubted = more.mean(axis=-1) + doubts.transpose(2, 0, 1) * more.std(axis=-1)
    cost = doubted.mean(axis=0) + _CAUTION / n**2 * SHARES
    return SHARES[np.where((doubted <= 0.0).all(axis=0), cost, np.inf).argmin(axis=-1)]
