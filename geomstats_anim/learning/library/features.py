"""Features of what surrounds a segment, part by part of the body; distances of features tell motions apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim.learning.library.context import OFFSETS, Contexts
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

N_FEATURES = 32
"""Numbers that the features of a part are reduced to."""

_INCREMENT_WEIGHTS = np.array([0.5, 1.0, 1.0, 1.0, 0.5])
_SCALE_WEIGHT, _MASK_WEIGHT = 0.3, 0.35
_LEAST_UNIT = 1e-3


@dataclass(frozen=True, eq=False)
class Reduction:
    """Principal components of the features of one part.

    Parameters
    ----------
    units : array-like, shape=[3]
        Of poses, the deviation; of the logarithm of the scale, mean and deviation. Over the library.
    mean : array-like, shape=[D]
    components : array-like, shape=[D, N]
    """

    units: Array
    mean: Array
    components: Array

    def __call__(self, contexts: Contexts, scale: Array, joints: np.ndarray) -> Array:
        """Reduce the features of a part, whose joints and scale, shape=[n], are given; shape=[n, N]."""
        return (_raw(contexts, scale, joints, self.units) - self.mean) @ self.components

    @classmethod
    def fitted(cls, contexts: Contexts, scale: Array, joints: np.ndarray) -> Reduction:
        """Fit to the segments of a library, given to half precision, in which it is stored."""
        poses = contexts.poses[:, joints].reshape(len(scale), -1)
        log_scale = np.log(scale)
        deviation = np.sqrt(((poses - poses.mean(axis=0)) ** 2).sum(axis=1).mean())
        units = np.array([max(deviation, _LEAST_UNIT), log_scale.mean(), max(log_scale.std(), _LEAST_UNIT)])
        raw = _raw(contexts, scale, joints, units)
        mean = half(raw.mean(axis=0))
        _, vectors = np.linalg.eigh((raw - mean).T @ (raw - mean))
        return cls(units, mean, half(vectors[:, ::-1][:, :N_FEATURES]))


def half(values: Array) -> Array:
    """Round to half precision, in which a library is stored."""
    return np.array(values, dtype=np.float16, order="C").astype(np.float64)


def _raw(contexts: Contexts, scale: Array, joints: np.ndarray, units: Array) -> Array:
    n = len(scale)
    weights = _INCREMENT_WEIGHTS / np.sqrt(_INCREMENT_WEIGHTS.dot(_INCREMENT_WEIGHTS) * len(joints))
    increments = contexts.increments[:, :, joints] * (weights / scale[:, None])[..., None, None]
    poses = contexts.poses[:, joints] / units[0]
    log_scale = _SCALE_WEIGHT * (np.log(scale) - units[1]) / units[2]
    return np.concatenate([increments.reshape(n, -1), poses.reshape(n, -1), log_scale[:, None]], axis=1)


def features_of(contexts: Contexts, parts: BodyParts, reductions: tuple[Reduction, ...], scales: Array) -> list[Array]:
    """Return the features of every part, shape=[n, N] each, and last of which neighbours there are, shape=[n, 5]."""
    of_parts = [
        reduction(contexts, scales[:, p], joints)
        for p, (reduction, joints) in enumerate(zip(reductions, parts.joints, strict=True))
    ]
    return [*of_parts, _MASK_WEIGHT * (1.0 - contexts.is_there.reshape(-1, OFFSETS))]
