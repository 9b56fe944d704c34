"""The model of one length of segments: from what surrounds a segment to the residual in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim.learning.library.context import OFFSETS, Contexts
from geomstats_anim.learning.library.features import Reduction, features_of, half
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.learning.library.regression import Centres, Regression, weights_of
from geomstats_anim.learning.library.samples import Samples
from geomstats_anim.learning.library.self_check import SHARES
from geomstats_anim.rotations import Array

MOST_CENTRES = 450
_MOST_NUMBERS = 480_000
"""Of a model: less than a megabyte in half precision."""

_NEAR = 1.5
"""A model is used for segments up to this ratio longer or shorter than its own."""


@dataclass(frozen=True, eq=False)
class GapModel:
    """Predict the residual in segments of one length.

    Parameters
    ----------
    gap : int
        Frames of 30 per second.
    n_sines : int
    reductions : tuple of Reduction
        Of the features of each part.
    centres : Centres
    whitened : tuple of array-like, shape=[C, N * B_p * 3]
        Weights of the whitened kernels of each part.
    doubts : array-like, shape=[parts, shares, 2]
        See `doubts_of`.
    """

    gap: int
    n_sines: int
    reductions: tuple[Reduction, ...]
    centres: Centres
    whitened: tuple[Array, ...]
    doubts: Array

    @cached_property
    def _weights(self) -> list[Array]:
        return [weights_of(*pair) for pair in zip(self.whitened, self.centres.factors, strict=True)]

    @cached_property
    def _single_weights(self) -> list[Array]:
        return [each.astype(np.float32) for each in self._weights]

    def predict(self, contexts: Contexts, parts: BodyParts, in_single: bool = False) -> Array:
        """Predict the weights of sines, shape=[n, N, B, 3], radians; in single precision if that will do."""
        scales = contexts.scales(parts)
        features = features_of(contexts, parts, self.reductions, scales)
        centres, all_weights = self.centres, self._weights
        if in_single:
            features = [each.astype(np.float32) for each in features]
            centres, all_weights = centres.single, self._single_weights
        kernels = centres.kernels(features)
        kernels *= scales.T[..., None].astype(kernels.dtype)
        sines = np.empty((len(scales), self.n_sines, len(parts.of_joint), 3))
        for kernel, weights, joints in zip(kernels, all_weights, parts.joints, strict=True):
            sines[:, :, joints] = (kernel @ weights).reshape(len(scales), self.n_sines, -1, 3)
        return sines


def fit_gap(
    gap: int, samples: Samples, parts: BodyParts, actions: np.ndarray, rng: np.random.Generator
) -> tuple[GapModel, Array]:
    """Fit the model of one length of segments, without doubts.

    Parameters
    ----------
    gap : int
    samples : Samples
    parts : BodyParts
    actions : array-like of int
        Action of each clip of the library.
    rng : Generator
        Chooses the centres.

    Returns
    -------
    model : GapModel
    left_out : array-like, shape=[n, N, B, 3]
        Weights of sines, radians, that regressions without the action of a segment predict for it.
    """
    contexts, n = samples.contexts, len(samples.clip)
    scales = contexts.scales(parts)
    reductions = tuple(Reduction.fitted(contexts, scales[:, p], joints) for p, joints in enumerate(parts.joints))
    features = features_of(contexts, parts, reductions, scales)
    chosen = rng.permutation(n)[: _n_centres(reductions, samples.sines[0].size)]
    centres = Centres(tuple(half(each[chosen]) for each in features))
    kernels, whitened, left_out = centres.kernels(features), [], np.empty_like(samples.sines)
    for p, joints in enumerate(parts.joints):
        shape = samples.sines[:, :, joints].shape
        targets = samples.sines[:, :, joints].reshape(n, -1) / scales[:, p, None]
        regression = Regression(kernels[p], centres.factors[p], targets)
        whitened.append(regression.whitened_weights())
        unseen = scales[:, p, None] * regression.predict_left_out(actions[samples.clip], chosen)
        left_out[:, :, joints] = unseen.reshape(shape)
    doubts = np.zeros((len(parts.joints), len(SHARES), 2))
    return GapModel(gap, samples.sines.shape[1], reductions, centres, tuple(whitened), doubts), left_out


def _n_centres(reductions: Sequence[Reduction], n_targets: int) -> int:
    """Return how many centres a model may have, for its size."""
    of_reductions = sum(each.components.size + len(each.mean) for each in reductions)
    of_centre = n_targets + OFFSETS + sum(each.components.shape[1] for each in reductions)
    return max(1, min(MOST_CENTRES, (_MOST_NUMBERS - of_reductions) // of_centre))


def nearest_models(models: Sequence[GapModel], gaps: Array) -> np.ndarray:
    """Return the indices of the models that are nearest to lengths of segments, -1 where none is near.

    Parameters
    ----------
    models : sequence of GapModel
    gaps : array-like, shape=[n]
        Frames of 30 per second.

    Returns
    -------
    indices : array-like of int, shape=[n]
    """
    ratio = np.abs(np.log(gaps[:, None] / np.array([model.gap for model in models])))
    return np.where(ratio.min(axis=1) <= np.log(_NEAR), ratio.argmin(axis=1), -1)
