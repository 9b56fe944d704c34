"""How far to trust a fitted metric on frames that nobody has seen: blocked cross-validation, one factor a joint.

A metric fitted freely to a clip loses to slerp on the clip's other half. Scaling log alpha and log beta by a factor in
[0, 1] leads from the bi-invariant metric, whose geodesics are slerp, to the fit. Neighbouring segments are alike, so
the folds are contiguous blocks of them, or whole clips where there are several.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from geomstats_anim.learning.gradient import Found, Learnable
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

FACTORS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])

N_FOLDS = 4


class Fold(NamedTuple):
    """What to fit, and what to score the fit on."""

    train: Learnable
    test: Learnable


class Shrinkage(NamedTuple):
    """A shrunk metric.

    Attributes
    ----------
    parameters : MetricParameters
    factors : array-like, shape=[B]
        0 where the identity predicts as well, 1 where the fit is kept as it is.
    score, slerp_score : float
        Cross-validated quality of metrics shrunk by these factors, and of slerp, mean over the folds.
    """

    parameters: MetricParameters
    factors: Array
    score: float
    slerp_score: float


def scaled(parameters: MetricParameters, factors: Array) -> MetricParameters:
    """Move a metric towards the identity, each joint to its share of log alpha and log beta.

    Parameters
    ----------
    parameters : MetricParameters
    factors : array-like, shape=[B]

    Returns
    -------
    scaled : MetricParameters
    """
    return MetricParameters(parameters.alpha**factors, parameters.beta**factors, parameters.axes, parameters.invariance)


def shrink(folds: Sequence[Fold], fitted: MetricParameters, find: Callable[[Learnable], Found]) -> Shrinkage:
    """Choose each joint's factor by cross-validation.

    A joint takes the factor whose gain over slerp is certain to be the largest, at the lower end of its 95 % interval
    over the folds: the identity unless they agree. If the metrics so shrunk do not beat slerp in the quality itself,
    the identity is returned.

    Parameters
    ----------
    folds : sequence of Fold
        Fewer than two say nothing, and the identity is returned.
    fitted : MetricParameters
        Of all frames.
    find : callable
        The search that fitted it.

    Returns
    -------
    shrinkage : Shrinkage
    """
    n_joints = fitted.n_joints
    identity = MetricParameters.identity(n_joints)
    slerp_score = float(np.mean([fold.test.value(identity) for fold in folds])) if folds else np.nan
    nothing = Shrinkage(identity, np.zeros(n_joints), slerp_score, slerp_score)
    if len(folds) < 2:
        return nothing
    fits = [find(fold.train).parameters for fold in folds]
    errors = np.array(
        [
            [fold.test.rotation_errors_by_joint(scaled(fit, np.full(n_joints, factor))) for factor in FACTORS]
            for fold, fit in zip(folds, fits, strict=True)
        ]
    )
    gains = errors[:, :1] - errors
    standard_error = gains.std(axis=0, ddof=1) / np.sqrt(len(folds))
    certain_gain = gains.mean(axis=0) - stdtrit(len(folds) - 1, 0.95) * standard_error
    factors = FACTORS[certain_gain.argmax(axis=0)]
    score = float(np.mean([fold.test.value(scaled(fit, factors)) for fold, fit in zip(folds, fits, strict=True)]))
    if not score < slerp_score:
        return nothing
    return Shrinkage(scaled(fitted, factors), factors, score, slerp_score)


def blocks(n_segments: int, n_folds: int = N_FOLDS) -> list[np.ndarray]:
    """Cut segments into contiguous blocks of nearly equal length, at most one a segment."""
    return [block for block in np.array_split(np.arange(n_segments), n_folds) if len(block)]
