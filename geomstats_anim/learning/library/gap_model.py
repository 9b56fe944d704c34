"""The model of one length of segments: from what surrounds a segment to the residual in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim.learning.library.context import OFFSETS, Contexts
from geomstats_anim.learning.library.features import Features, Reduction, half
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.learning.library.regression import Centres, Regression, weights_of
from geomstats_anim.learning.library.samples import Samples
from geomstats_anim.learning.library.self_check import SHARES
from geomstats_anim.rotations import Array

MOST_CENTRES = 450
_MOST_NUMBERS = 480_000
"""Of a model: less than a megabyte in half precision."""

_AT_ONCE = 64
"""Segments that are compared with the centres at once, so that the numbers stay in the processor's cache."""

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
    features : Features
        Of the surroundings of segments.
    centres : Centres
    whitened : tuple of array-like, shape=[C, N * B_p * 3]
        Weights of the whitened kernels of each part.
    doubts : array-like, shape=[parts, shares, 2]
        See `doubts_of`.
    """

    gap: int
    n_sines: int
    features: Features
    centres: Centres
    whitened: tuple[Array, ...]
    doubts: Array

    @cached_property
    def _weights(self) -> tuple[np.ndarray, ...]:
        pairs = zip(self.whitened, self.centres.factors, strict=True)
        return tuple(weights_of(*pair).astype(np.float32) for pair in pairs)

    @cached_property
    def _order(self) -> np.ndarray:
        """Return the place of each number of the sines, shape=[N * B * 3], in those of one part after the other."""
        parts = self.features.parts
        places = np.arange(self.n_sines * len(parts.of_joint) * 3).reshape(self.n_sines, -1, 3)
        return np.argsort(np.concatenate([places[:, joints].ravel() for joints in parts.joints]))

    def predict(self, contexts: Contexts, n_images: int = 1) -> Array:
        """Predict in single precision, which is that of files.

        Parameters
        ----------
        contexts : Contexts
        n_images : int
            Contexts are of so many images of a clip, one after the other; each is predicted by itself, so that its
            rounding is the same wherever it stands.
            Optional, default: 1.

        Returns
        -------
        sines : array-like, shape=[n, N, B, 3]
            Weights, radians.
        """
        parts = self.features.parts
        scales = contexts.scales(parts)
        features = self.features(contexts, scales).astype(np.float32)
        features = features.reshape(len(features), n_images, -1, features.shape[-1])
        found = np.empty((*features.shape[1:3], len(self._order)), dtype=np.float32)
        columns = np.cumsum([0, *(each.shape[1] for each in self._weights)])
        for start in range(0, found.shape[1], _AT_ONCE):
            rows = slice(start, start + _AT_ONCE)
            kernels = self.centres.single.kernels(features[:, :, rows])
            for p, weights in enumerate(self._weights):
                np.matmul(kernels[p], weights, out=found[:, rows, columns[p] : columns[p + 1]])
        sines = found[..., self._order].reshape(len(scales), self.n_sines, -1, 3)
        return np.asarray(sines * scales[:, None, parts.of_joint, None])


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
    to_features = Features.fitted(contexts, scales, parts)
    features = to_features(contexts, scales)
    chosen = rng.permutation(n)[: _n_centres(to_features.reductions, samples.sines[0].size)]
    centres = Centres(half(features[:, chosen]))
    kernels, whitened, left_out = centres.kernels(features), [], np.empty_like(samples.sines)
    for p, joints in enumerate(parts.joints):
        shape = samples.sines[:, :, joints].shape
        targets = samples.sines[:, :, joints].reshape(n, -1) / scales[:, p, None]
        regression = Regression(kernels[p], centres.factors[p], targets)
        whitened.append(regression.whitened_weights())
        unseen = scales[:, p, None] * regression.predict_left_out(actions[samples.clip], chosen)
        left_out[:, :, joints] = unseen.reshape(shape)
    doubts = np.zeros((len(parts.joints), len(SHARES), 2))
    return GapModel(gap, samples.sines.shape[1], to_features, centres, tuple(whitened), doubts), left_out


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
