"""Shrinking a fitted metric for frames that nobody has seen: blocked cross-validation, one factor per joint.

A metric fitted freely to a clip loses to slerp on the clip's other half. Scaling log alpha and log beta by a factor in
[0, 1] leads from the bi-invariant metric, whose geodesics are slerp, to the fit. Neighbouring segments are alike, so
the folds are contiguous blocks of them, or whole clips where there are several.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.names import DEFAULT_SCHEME
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array

FACTORS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])

TENSIONS = (0.0, 0.5, 1.5, 2.0)
"""Tensions that compete with the usual one."""

CONFIDENCE = 0.975
"""Of a gain, one-sided."""

_PERFECT = 1e-9
"""Error at which nothing is left to gain."""

N_FOLDS = 4


class Fold(NamedTuple):
    """A part to fit, and a part to score the fit on."""

    train: Learnable
    test: Learnable


class Shrinkage(NamedTuple):
    """A curve shrunk towards the plain one.

    Attributes
    ----------
    curve : CurveParameters
    factors : array-like, shape=[B]
        0 where the plain curve predicts as well, 1 where the fit is kept as it is.
    score, slerp_score, plain_score : float
        Cross-validated quality of curves shrunk by these factors, of slerp, and of the plain spline, mean over the
        folds.
    """

    curve: CurveParameters
    factors: Array
    score: float
    slerp_score: float
    plain_score: float


def scaled(curve: CurveParameters, factors: Array, plain: CurveParameters) -> CurveParameters:
    """Move a curve towards a plain one, each joint to its share of log alpha, log beta and what its tension is above.

    Parameters
    ----------
    curve : CurveParameters
    factors : array-like, shape=[B]
    plain : CurveParameters
        Bi-invariant. Translations keep its tension, since rotation errors choose the factors.

    Returns
    -------
    scaled : CurveParameters
    """
    fit = curve.metric
    metric = MetricParameters(fit.alpha**factors, fit.beta**factors, fit.axes, fit.invariance)
    tension = plain.tension + factors * (curve.tension - plain.tension)
    return CurveParameters(metric, tension, plain.translation_tension)


def shrink(
    folds: Sequence[Fold],
    fitted: CurveParameters,
    plain: CurveParameters,
    find: Callable[[Learnable], Found],
) -> Shrinkage:
    """Choose each joint's factor by cross-validation, for a spline after one tension for all joints.

    A choice is made for the largest gain that is certain, at the lower end of its 95 % interval over the folds: so it
    falls on the plain curve unless they agree. If the curves so shrunk do not beat the plain one in the quality itself,
    that is returned.

    Parameters
    ----------
    folds : sequence of Fold
        Fewer than two say nothing, and the plain curve is returned.
    fitted : CurveParameters
        Of all frames.
    plain : CurveParameters
        Of the scheme, with the bi-invariant metric.
    find : callable
        The search that fitted it.

    Returns
    -------
    shrinkage : Shrinkage
    """
    n_joints = fitted.metric.n_joints
    none = np.zeros(n_joints)
    slerp = CurveParameters.geodesic(plain.metric)
    spline = CurveParameters.plain(DEFAULT_SCHEME, n_joints)
    scores = [_mean([fold.test.value(curve) for fold in folds]) for curve in (plain, slerp, spline)]
    own_score, slerp_score, plain_score = scores
    if len(folds) < 2:
        return Shrinkage(plain, none, own_score, slerp_score, plain_score)
    base, base_score = _with_one_tension(folds, plain)
    fits = [find(fold.train).curve for fold in folds]
    errors = np.array(
        [
            [fold.test.rotation_errors_by_joint(scaled(fit, np.full(n_joints, factor), base)) for factor in FACTORS]
            for fold, fit in zip(folds, fits, strict=True)
        ]
    )
    factors = FACTORS[_certain_gain(errors).argmax(axis=0)]
    score = _mean([fold.test.value(scaled(fit, factors, base)) for fold, fit in zip(folds, fits, strict=True)])
    if not score < base_score:
        return Shrinkage(base, none, base_score, slerp_score, plain_score)
    return Shrinkage(scaled(fitted, factors, base), factors, score, slerp_score, plain_score)


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _with_one_tension(folds: Sequence[Fold], plain: CurveParameters) -> tuple[CurveParameters, float]:
    """Choose one tension for all joints of a spline, and return its quality."""
    curves = [plain]
    if plain.tension.any():
        tensions = (np.full(plain.metric.n_joints, tension) for tension in TENSIONS)
        curves += [CurveParameters(plain.metric, tension, tension) for tension in tensions]
    errors = np.array([[fold.test.value(curve) for curve in curves] for fold in folds])
    best = int(_certain_gain(errors).argmax())
    return curves[best], float(errors[:, best].mean())


def _certain_gain(errors: Array) -> Array:
    """Return the certain gain over the first choice, as a share, from errors by fold and choice, shape=[n, C, ...]."""
    from scipy.special import stdtrit

    gains = (errors[:, :1] - errors) / np.maximum(errors[:, :1], _PERFECT)
    standard_error = gains.std(axis=0, ddof=1) / np.sqrt(len(errors))
    return gains.mean(axis=0) - stdtrit(len(errors) - 1, CONFIDENCE) * standard_error


def blocks(n_segments: int, n_folds: int = N_FOLDS) -> list[np.ndarray]:
    """Cut segments into contiguous blocks of nearly equal length, at most one per segment."""
    return [block for block in np.array_split(np.arange(n_segments), n_folds) if len(block)]
