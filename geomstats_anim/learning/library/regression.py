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
    def _norms(self) -> list[Array]:
        return [(each**2).sum(axis=1) for each in self.features]

    @cached_property
    def _transposed(self) -> list[Array]:
        return [np.ascontiguousarray(-2.0 * each.T) for each in self.features]

    def kernels(self, features: list[Array]) -> Array:
        """Compare segments, given by their features, with the centres; shape=[parts, n, C]."""
        squares = []
        for each, norms, transposed in zip(features, self._norms, self._transposed, strict=True):
            squares.append(each @ transposed + (each**2).sum(axis=1)[:, None] + norms)
        own, common = np.stack(squares[:-1]), squares[-1]
        if len(own) > 1:
            common = common + _OTHER_PARTS * own.sum(axis=0)
            own *= 1.0 - _OTHER_PARTS
        return np.exp(np.minimum(-(own + common), 0.0))

    @cached_property
    def factors(self) -> Array:
        """Return Cholesky factors of the centres' own kernels, shape=[parts, C, C], lower."""
        kernels = self.kernels(list(self.features))
        return np.asarray(np.linalg.cholesky(kernels + _JITTER * np.eye(kernels.shape[1])), dtype=np.float64)


def whitened_weights(kernel: Array, factor: Array, targets: Array) -> Array:
    """Solve for the weights of whitened kernels, shape=[C, T], in half precision.

    Parameters
    ----------
    kernel : array-like, shape=[n, C]
        Of the segments of the library.
    factor : array-like, shape=[C, C]
    targets : array-like, shape=[n, T]
    """
    white = solve_triangular(factor, kernel.T, lower=True)
    system = cho_factor(white @ white.T + RIDGE * np.eye(len(white)), lower=True)
    return half(cho_solve(system, white @ targets))


def weights_of(whitened: Array, factor: Array) -> Array:
    """Return weights of the kernels themselves, shape=[C, T]."""
    return np.asarray(solve_triangular(factor, whitened, lower=True, trans="T"))
