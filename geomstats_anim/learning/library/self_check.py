"""How much of a prediction helps: every second key of the clip is hidden, and predicted from the others."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Skeleton
from geomstats_anim.kinematics import place
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

SHARES = np.linspace(0.0, 1.0, 6)
_CAUTION, _CAUTION_OF_FEW = 0.03, 0.6
"""A full share has to save this part of the error, and more by so much per hidden key."""

_LEAST = 1e-9
"""Errors, radians or metres, that are none."""


def best_shares(skeleton: Skeleton, parts: BodyParts, splines: Array, residuals: Array, truth: Array) -> Array:
    """Choose for each part of the body the share of a prediction that helps most.

    What counts is the mean of two ratios to the error of the spline: of angles, and of distances of bone ends, which
    are those of the whole body for the torso, with the limbs as the spline has them, and then of each limb. Neither
    may grow.

    Parameters
    ----------
    skeleton : Skeleton
    parts : BodyParts
    splines : array-like, shape=[n, B, 4]
        Of the spline, at hidden keys.
    residuals : array-like, shape=[n, B, 3]
        Predicted for it.
    truth : array-like, shape=[n, B, 4]
        The hidden keys.

    Returns
    -------
    shares : array-like, shape=[parts]
    """
    turned = quat.multiply(splines, quat.exp(SHARES[:, None, None, None] * residuals))
    angles = quat.distance(turned, truth).sum(axis=1)
    goal = _ends(skeleton, truth[None])
    torso, limbs = parts.joints[0], parts.joints[1:]
    poses = np.repeat(splines[None], len(SHARES), axis=0)
    poses[:, :, torso] = turned[:, :, torso]
    ends = np.linalg.norm(_ends(skeleton, poses) - goal, axis=-1).sum(axis=1)
    shares = [_best(angles[:, torso].sum(axis=1), ends.sum(axis=1), len(truth))]
    if limbs:
        turned[:, :, torso] = turned[shares[0], :, torso].transpose(1, 0, 2)
        ends = np.linalg.norm(_ends(skeleton, turned) - goal, axis=-1).sum(axis=1)
        shares += [_best(angles[:, limb].sum(axis=1), ends[:, limb].sum(axis=1), len(truth)) for limb in limbs]
    return SHARES[shares]


def _best(angles: Array, ends: Array, n_hidden: int) -> int:
    """Return the index of the best share, from the errors of each."""
    ratios = np.stack([angles / max(angles[0], _LEAST), ends / max(ends[0], _LEAST)])
    cost = ratios.mean(axis=0) + (_CAUTION + _CAUTION_OF_FEW / n_hidden) * SHARES
    return int(np.argmin(np.where((ratios <= 1.0).all(axis=0) | (SHARES == 0.0), cost, np.inf)))


def _ends(skeleton: Skeleton, rotations: Array) -> Array:
    """Return the ends of bones, shape=[..., B, 3], of poses that stand where the rest pose does."""
    flat = rotations.reshape(-1, skeleton.n_joints, 4)
    rest = np.broadcast_to(skeleton.rest_translations, (*flat.shape[:2], 3))
    return place(skeleton, flat, rest).ends.reshape(*rotations.shape[:-1], 3)
