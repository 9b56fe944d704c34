"""The model of one length of segments: from what surrounds a segment to the residual in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim.learning.library.context import OFFSETS, Contexts
from geomstats_anim.learning.library.features import Reduction, features_of, half
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.learning.library.regression import Centres, weights_of, whitened_weights
from geomstats_anim.learning.library.samples import Samples
from geomstats_anim.rotations import Array

MOST_CENTRES = 450
_MOST_NUMBERS = 480_000
"""Of a model: less than a megabyte in half precision."""


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
    """

    gap: int
    n_sines: int
    reductions: tuple[Reduction, ...]
    centres: Centres
    whitened: tuple[Array, ...]

    @cached_property
    def _weights(self) -> list[Array]:
        return [weights_of(*pair) for pair in zip(self.whitened, self.centres.factors, strict=True)]

    def predict(self, contexts: Contexts, parts: BodyParts) -> Array:
        """Predict the weights of sines, shape=[n, N, B, 3], radians."""
        scales = contexts.scales(parts)
        kernels = self.centres.kernels(features_of(contexts, parts, self.reductions, scales))
        n, n_joints = len(scales), contexts.increments.shape[2]
        sines = np.empty((n, self.n_sines, n_joints, 3))
        for p, joints in enumerate(parts.joints):
            found = scales[:, p, None] * (kernels[p] @ self._weights[p])
            sines[:, :, joints] = found.reshape(n, self.n_sines, len(joints), 3)
        return sines

    @classmethod
    def fitted(cls, gap: int, samples: Samples, parts: BodyParts, rng: np.random.Generator) -> GapModel:
        """Fit to segments of a library."""
        contexts, n = samples.contexts, len(samples.clip)
        scales = contexts.scales(parts)
        reductions = tuple(Reduction.fitted(contexts, scales[:, p], joints) for p, joints in enumerate(parts.joints))
        features = features_of(contexts, parts, reductions, scales)
        chosen = rng.permutation(n)[: _n_centres(reductions, samples.sines[0].size)]
        centres = Centres(tuple(half(each[chosen]) for each in features))
        kernels = centres.kernels(features)
        whitened = []
        for p, joints in enumerate(parts.joints):
            targets = samples.sines[:, :, joints].reshape(n, -1) / scales[:, p, None]
            whitened.append(whitened_weights(kernels[p], centres.factors[p], targets))
        return cls(gap, samples.sines.shape[1], reductions, centres, tuple(whitened))


def _n_centres(reductions: Sequence[Reduction], n_targets: int) -> int:
    """Return how many centres a model may have, for its size."""
    of_reductions = sum(each.components.size + len(each.mean) for each in reductions)
    of_centre = n_targets + OFFSETS + sum(each.components.shape[1] for each in reductions)
    return max(1, min(MOST_CENTRES, (_MOST_NUMBERS - of_reductions) // of_centre))
