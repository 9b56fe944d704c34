"""How much of a prediction helps: every second key of the clip is hidden, and predicted from the others."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

SHARES = np.linspace(0.0, 1.0, 11)
_CAUTION, _CAUTION_OF_FEW = 0.03, 0.6
"""A full share has to save this part of the error, and more by so much per hidden key."""


def best_shares(parts: BodyParts, splines: Array, residuals: Array, truth: Array) -> Array:
    """Choose for each part of the body the share of a prediction that helps most.

    Parameters
    ----------
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
    errors = quat.angle(quat.multiply(quat.conjugate(turned), truth)).sum(axis=1)
    caution = (_CAUTION + _CAUTION_OF_FEW / len(truth)) * SHARES
    shares = []
    for joints in parts.joints:
        of_part = errors[:, joints].sum(axis=1)
        shares.append(SHARES[np.argmin(of_part + caution * of_part[0])])
    return np.array(shares)
