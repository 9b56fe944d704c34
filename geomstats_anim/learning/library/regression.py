r"""Kernel ridge regression of residuals, part by part of the body.

The kernel of a part p sees the features f of all parts, its own the most:

.. math:: k_p(f, f') = \exp(- \sum_q w_{pq}^2 |f_q - f_q'|^2), \quad w_{pp} = 1, w_{pq} = .225

and the prediction is the mean of a Gaussian process with few centres (Nystroem; Quinonero-Candela and Rasmussen, "A
unifying view of sparse approximate Gaussian process regression", JMLR 2005, the subset of regressors).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from geomstats_anim.learning.library.features import half
from geomstats_anim.rotations import Array

_OTHER_PARTS = 0.225**2
_JITTER = 1e-3
RIDGE = 0.1


@dataclass(frozen=True, eq=False)
class Centres:
    """Segments of the library that others are compared with.

    Parameters
    ----------
    features : array-like, shape=[parts + 1, C, N]
        Of each part of the body, and of which neighbours there are.
    """

    features: Array

    @cached_property
    def single(self) -> Centres:
        """Return them in single precision, for features in it."""
        return Centres(self.features.astype(np.float32))

    @cached_property
    def _lifted(self) -> Array:
        """Return matrices that turn features f, their square and 1 into minus squared distances, weighted.

        Those of a part are weighted by 1 - w^2, w = w_pq: what its own distances count more than those of others.
        """
        squares = (self.features**2).sum(axis=2)[:, None]
        lifted = np.concatenate([2.0 * self.features.swapaxes(1, 2), -np.ones_like(squares), -squares], axis=1)
        lifted[:-1] *= 1.0 - _OTHER_PARTS
        return np.asarray(lifted)

    def kernels(self, features: np.ndarray) -> Array:
        """Compare segments with the centres.

        Parameters
        ----------
        features : array-like, shape=[parts + 1, ..., n, N]

        Returns
        -------
        kernels : array-like, shape=[parts, ..., n, C]
        """
        squares = np.einsum("...i,...i->...", features, features)[..., None]
        lifted = self._lifted.reshape(len(features), *(1,) * (features.ndim - 3), *self._lifted.shape[1:])
        exponents = np.concatenate([features, squares, np.ones_like(squares)], axis=-1) @ lifted
        kernels, common = exponents[:-1], exponents[:-1].sum(axis=0)
        common *= _OTHER_PARTS / (1.0 - _OTHER_PARTS)
        common += exponents[-1]
        kernels += common
        return np.exp(kernels, out=kernels)

    @cached_property
    def factors(self) -> Array:
        """Return Cholesky factors of the centres' own kernels, shape=[parts, C, C], lower."""
        kernels = self.kernels(self.features)
        return np.asarray(np.linalg.cholesky(kernels + _JITTER * np.eye(kernels.shape[1])), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Regression:
    """The regression of one part of the body.

    Parameters
    ----------
    kernel : array-like, shape=[n, C]
        Of the segments of the library with the centres.
    factor : array-like, shape=[C, C]
        Of the centres' own kernels, lower.
    targets : array-like, shape=[n, T]
    """

    kernel: Array
    factor: Array
    targets: Array

    @cached_property
    def _gram(self) -> Array:
        return np.asarray(self.kernel.T @ self.kernel)

    @cached_property
    def _moment(self) -> Array:
        return np.asarray(self.kernel.T @ self.targets)

    def whitened_weights(self) -> Array:
        """Solve for the weights of whitened kernels, shape=[C, T], in half precision."""
        half_white = solve_triangular(self.factor, self._gram, lower=True)
        white = solve_triangular(self.factor, half_white.T, lower=True)
        system = cho_factor(0.5 * (white + white.T) + RIDGE * np.eye(len(white)), lower=True)
        return half(cho_solve(system, solve_triangular(self.factor, self._moment, lower=True)))

    def predict_left_out(self, group: np.ndarray, centres: np.ndarray) -> Array:
        """Predict the targets of each group of segments by a regression without it.

        Parameters
        ----------
        group : array-like of int, shape=[n]
            Of each segment.
        centres : array-like of int, shape=[C]
            Segments that are centres.

        Returns
        -------
        predicted : array-like, shape=[n, T]
            Zero where no centre is left.
        """
        predicted, of_centre = np.zeros_like(self.targets), group[centres]
        penalty = RIDGE * (self.factor @ self.factor.T)
        for each in np.unique(group):
            own, rest = group == each, np.flatnonzero(of_centre != each)
            if len(rest):
                kernel = self.kernel[own]
                system = (self._gram - kernel.T @ kernel + penalty)[np.ix_(rest, rest)]
                moment = (self._moment - kernel.T @ self.targets[own])[rest]
                predicted[own] = kernel[:, rest] @ cho_solve(cho_factor(system), moment)
        return predicted


def weights_of(whitened: Array, factor: Array) -> Array:
    """Return weights of the kernels themselves, shape=[C, T]."""
    return np.asarray(solve_triangular(factor, whitened, lower=True, trans="T"))
