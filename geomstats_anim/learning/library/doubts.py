"""Doubts: how much less a prediction helps between keys than the self-check says, which sees only twice their spacing.

They are learned by leaving actions out. Each cluster of clips is predicted by regressions without it, at one length of
segments and at twice that length. Of the clips that a share helps at twice the length, most do not lose more than the
doubt at the length itself. Doubts are in units of the standard deviation of the gain from segment to segment: a gain
that is steady says more of other segments than one that varies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Skeleton
from geomstats_anim.interpolation.residuals import basis
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.learning.library.samples import Samples
from geomstats_anim.learning.library.self_check import SHARES, HiddenPoses, ratios_to_spline
from geomstats_anim.rotations import Array

_MOST_POSES = 1200
"""Segments that are looked at, of one length."""

_QUANTILE = 0.7
"""So many of the clips lose no more than the doubt."""

_PRIOR, _PRIOR_CLIPS = 0.8, 3
"""Doubt without evidence, and how many clips it counts for."""

_LEAST = 1e-9
"""Deviations that are none."""


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Errors of one length of segments, in the middle of which clips are predicted by models without their action.

    Parameters
    ----------
    ratios : array-like, shape=[clips, parts, shares, 2]
        With each share of the prediction, to those of the spline: of angles, and of distances of bone ends. Not a
        number for clips without segments.
    deviations : array-like, shape=[clips, parts, shares, 2]
        Of the ratios from segment to segment.
    """

    ratios: Array
    deviations: Array


def errors_left_out(
    samples: Samples, predicted: Array, skeleton: Skeleton, parts: BodyParts, rng: np.random.Generator
) -> LeftOut:
    """Return the errors on actions that are left out.

    Parameters
    ----------
    samples : Samples
    predicted : array-like, shape=[n, N, B, 3]
        Weights of sines, of models without the action of the clip.
    skeleton : Skeleton
    parts : BodyParts
    rng : Generator
        Chooses the segments.

    Returns
    -------
    errors : LeftOut
    """
    chosen = np.sort(rng.permutation(len(samples.clip))[:_MOST_POSES])
    middle = basis(np.array([0.5]), samples.sines.shape[1])[0, :-2]
    missed: Array = np.asarray(np.tensordot(middle, samples.sines[chosen], (0, 1)), dtype=np.float64)
    found: Array = np.asarray(np.tensordot(middle, predicted[chosen], (0, 1)), dtype=np.float64)
    middles, clips = samples.middles[chosen], samples.clip[chosen]
    hidden = HiddenPoses(skeleton, parts, middles, found, quat.multiply(middles, quat.exp(missed)))
    errors = np.concatenate([hidden.of_torso(np.zeros(len(parts.joints) - 1)), hidden.of_limbs()], axis=1)
    ratios, deviations = np.full((2, samples.clip.max() + 1, len(parts.joints), len(SHARES), 2), np.nan)
    for each in np.unique(clips):
        found = ratios_to_spline(errors[..., clips == each]).transpose(1, 2, 0, 3)
        ratios[each], deviations[each] = found.mean(axis=-1), (found - found[:, :1]).std(axis=-1)
    return LeftOut(ratios, deviations)


def doubts_of(at_gap: LeftOut, at_double: LeftOut | None) -> Array:
    """Return how many standard deviations have to be added to ratios of errors that the self-check finds.

    Parameters
    ----------
    at_gap, at_double : LeftOut
        Of a length of segments and of twice that length; None if there are no errors of that.

    Returns
    -------
    doubts : array-like, shape=[parts, shares, 2]
        At least 0.
    """
    prior = np.broadcast_to(_PRIOR, at_gap.ratios.shape[1:])
    if at_double is None:
        return prior.copy()
    n = min(len(at_gap.ratios), len(at_double.ratios))
    lost, deviations = at_gap.ratios[:n] - at_double.ratios[:n], at_double.deviations[:n]
    helps = (at_double.ratios[:n].mean(axis=-1, keepdims=True) < 1.0) & (deviations > _LEAST)
    lost = np.where(helps, lost / np.maximum(deviations, _LEAST), np.nan)
    known = np.concatenate([lost, np.broadcast_to(prior, (_PRIOR_CLIPS, *prior.shape))])
    return np.round(np.maximum(np.nanquantile(known, _QUANTILE, axis=0), 0.0), 4)
