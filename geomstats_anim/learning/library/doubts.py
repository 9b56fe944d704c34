"""Doubts: how much less a prediction helps between keys than the self-check says, which sees only twice their spacing.

They are learned by leaving actions out. Each cluster of clips is predicted by regressions without it, at one length of
segments and at twice that length. Of the clips that a share helps at twice the length, most do not lose more than the
doubt at the length itself. Where errors at twice the length are much the larger, they say less of those at the length,
and more is doubted.
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

_PER_DOUBLING = 0.1
"""Doubt of a full share where errors at twice the length are four times as large; twice as much at eight times."""

_PRIOR, _PRIOR_CLIPS = 0.1, 3
"""Doubt of a full share without evidence, and how many clips it counts for."""

_LEAST = 1e-9
"""Errors, radians or metres, that are none."""


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Errors of one length of segments, in the middle of which clips are predicted by models without their action.

    Parameters
    ----------
    ratios : array-like, shape=[clips, parts, shares, 2]
        With each share of the prediction, to those of the spline: of angles, and of distances of bone ends. Not a
        number for clips without segments.
    splines : array-like, shape=[parts, 2]
        Errors of the spline, radians and metres.
    """

    ratios: Array
    splines: Array


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
    ends = np.stack([hidden.torso_ends(np.zeros(len(parts.joints) - 1, dtype=np.intp)), *hidden.limb_ends])
    errors = np.stack([hidden.angles, ends], axis=1)
    ratios = np.full((samples.clip.max() + 1, len(parts.joints), len(SHARES), 2), np.nan)
    for clip in np.unique(clips):
        ratios[clip] = ratios_to_spline(errors[..., clips == clip]).mean(axis=-1).transpose(0, 2, 1)
    return LeftOut(ratios, errors[:, :, 0].mean(axis=-1))


def doubts_of(at_gap: LeftOut, at_double: LeftOut | None) -> Array:
    """Return what has to be added to ratios of errors that the self-check finds.

    Parameters
    ----------
    at_gap, at_double : LeftOut
        Of a length of segments and of twice that length; None if there are no errors of that.

    Returns
    -------
    doubts : array-like, shape=[parts, shares, 2]
        At least 0.
    """
    prior = np.broadcast_to(_PRIOR * SHARES[:, None], at_gap.ratios.shape[1:])
    if at_double is None:
        return prior.copy()
    n = min(len(at_gap.ratios), len(at_double.ratios))
    lost = at_gap.ratios[:n] - at_double.ratios[:n]
    lost[~(at_double.ratios[:n].mean(axis=-1) < 1.0)] = np.nan
    known = np.concatenate([lost, np.broadcast_to(prior, (_PRIOR_CLIPS, *prior.shape))])
    doublings = np.log2(np.maximum(at_double.splines, _LEAST) / np.maximum(at_gap.splines, _LEAST))
    of_size = _PER_DOUBLING * np.maximum(doublings - 1.0, 0.0)[:, None] * SHARES[:, None]
    return np.round(np.maximum(np.nanquantile(known, _QUANTILE, axis=0), 0.0) + of_size, 4)
