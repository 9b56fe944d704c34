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
    features : tuple of array-like, shape=[C, N]
        Of each part of the body, and of which neighbours there are.
    """

    features: tuple[Array, ...]

    @cached_property
    def single(self) -> Centres:
        """Return them in single precision, for features in it."""
        return Centres(tuple(each.astype(np.float32) for each in self.features))

    @cached_property
    def _lifted(self) -> list[Array]:
        """Return matrices that turn features f, their square and 1 into squared distances."""
        squares = [(each**2).sum(axis=1)[None] for each in self.features]
        pairs = zip(self.features, squares, strict=True)
        return [np.concatenate([-2.0 * each.T, np.ones_like(square), square]) for each, square in pairs]

    def kernels(self, features: list[Array]) -> Array:
        """Compare segments, given by their features, with the centres; shape=[parts, n, C]."""
        n, dtype = len(features[0]), features[0].dtype
        squares = np.empty((len(features), n, len(self.features[0])), dtype=dtype)
        one = np.ones((n, 1), dtype=dtype)
        for own, each, lifted in zip(squares, features, self._lifted, strict=True):
            square = np.einsum("ij,ij->i", each, each)[:, None]
            np.matmul(np.concatenate([each, square, one], axis=1), lifted, out=own)
        kernels, common = squares[:-1], squares[-1]
        common += _OTHER_PARTS * kernels.sum(axis=0)
        kernels *= _OTHER_PARTS - 1.0
        kernels -= common
        return np.exp(np.minimum(kernels, 0.0, out=kernels), out=kernels)

    @cached_property
    def factors(self) -> Array:
        """Return Cholesky factors of the centres' own kernels, shape=[parts, C, C], lower."""
        kernels = self.kernels(list(self.features))
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
