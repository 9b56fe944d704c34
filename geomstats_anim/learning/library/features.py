"""Features of what surrounds a segment, part by part of the body; distances of features tell motions apart."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim.kernels import surroundings
from geomstats_anim.learning.library.context import OFFSETS, Contexts
from geomstats_anim.learning.library.parts import BodyParts
from geomstats_anim.rotations import Array

N_FEATURES = 32
"""Numbers that the features of a part are reduced to."""

_INCREMENT_WEIGHTS = np.array([0.5, 1.0, 1.0, 1.0, 0.5]) / np.sqrt(3.5)
_SCALE_WEIGHT, _MASK_WEIGHT = 0.3, 0.35
_LEAST_UNIT = 1e-3


@dataclass(frozen=True, eq=False)
class Reduction:
    """Principal components of what surrounds one part.

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


@dataclass(frozen=True, eq=False)
class Features:
    """Features of all parts of the body.

    Parameters
    ----------
    parts : BodyParts
    reductions : tuple of Reduction
        Of each part.
    """

    parts: BodyParts
    reductions: tuple[Reduction, ...]

    @classmethod
    def fitted(cls, contexts: Contexts, scales: Array, parts: BodyParts) -> Features:
        """Fit to the segments of a library, given to half precision, in which it is stored."""
        units = np.stack([_units(contexts.poses[:, j], s) for j, s in zip(parts.joints, scales.T, strict=True)])
        reductions = []
        for unit, raw, joints in zip(units, _described(contexts, scales, parts, units), parts.joints, strict=True):
            own = raw[:, : description_width(len(joints))]
            mean = half(own.mean(axis=0))
            _, vectors = np.linalg.eigh((own - mean).T @ (own - mean))
            reductions.append(Reduction(unit, mean, half(vectors[:, ::-1][:, :N_FEATURES])))
        return cls(parts, tuple(reductions))

    def __call__(self, contexts: Contexts, scales: Array) -> Array:
        """Reduce what surrounds segments.

        Parameters
        ----------
        contexts : Contexts
        scales : array-like, shape=[n, parts]

        Returns
        -------
        features : array-like, shape=[parts + 1, n, N]
            Of every part, and last of which neighbours there are; filled up with zeros.
        """
        units, components, shift = self._stacked
        features = np.zeros((len(components) + 1, len(scales), N_FEATURES))
        np.matmul(_described(contexts, scales, self.parts, units), components, out=features[:-1])
        features[:-1] -= shift
        features[-1, :, :OFFSETS] = _MASK_WEIGHT * (1.0 - contexts.is_there)
        return features

    @cached_property
    def _stacked(self) -> tuple[Array, Array, Array]:
        """Return the units, shape=[parts, 3], components, shape=[parts, D, N], and the means of features."""
        width = max(len(each.mean) for each in self.reductions)
        components = np.zeros((len(self.reductions), width, N_FEATURES))
        shift = np.zeros((len(self.reductions), 1, N_FEATURES))
        for p, each in enumerate(self.reductions):
            components[p, : len(each.mean), : each.components.shape[1]] = each.components
            shift[p, :, : each.components.shape[1]] = each.mean @ each.components
        return np.stack([each.units for each in self.reductions]), components, shift


def half(values: Array) -> Array:
    """Round to half precision, in which a library is stored."""
    return np.array(values, dtype=np.float16, order="C").astype(np.float64)


def _units(poses: Array, scale: Array) -> Array:
    """Return the units of a part; see `Reduction`."""
    log_scale = np.log(scale)
    deviation = np.sqrt(((poses - poses.mean(axis=0)) ** 2).sum(axis=(1, 2)).mean())
    return np.array([max(deviation, _LEAST_UNIT), log_scale.mean(), max(log_scale.std(), _LEAST_UNIT)])


def description_width(n_joints: int) -> int:
    """Return how many numbers describe the surroundings of a part."""
    return (3 * OFFSETS + 9) * n_joints + 1


def _described(contexts: Contexts, scales: Array, parts: BodyParts, units: Array) -> Array:
    """Describe the surroundings of every part, shape=[parts, n, D], filled up with zeros."""
    units, scales = units / [1.0, 1.0, _SCALE_WEIGHT], np.ascontiguousarray(scales)
    described = np.zeros((len(units), len(scales), description_width(parts.sizes.max())))
    surroundings.describe(
        contexts.increments, contexts.poses, scales, _INCREMENT_WEIGHTS, parts.table, parts.sizes, units, described
    )
    return described
