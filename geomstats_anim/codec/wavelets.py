"""Wavelets in time: from samples to coefficients and back, for any number of samples.

The basis is the biorthogonal 9/7 of Cohen, Daubechies and Feauveau (1992), nearly orthonormal, with reflected ends.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from geomstats_anim.kernels import wavelets as kernel
from geomstats_anim.rotations import Array

_FEWEST = 3
"""Scaling coefficients at most, where halving ends."""

_REACH = 8
"""Rows to either side of its own that one level of a basis function covers, at most."""


class Basis(NamedTuple):
    """Basis functions as sparse columns, each without a gap.

    Attributes
    ----------
    pointers : array-like of int, shape=[F + 1]
        Where the values of each function begin in `values`.
    starts : array-like of int, shape=[F]
        First frame of each.
    values : array-like
    """

    pointers: np.ndarray
    starts: np.ndarray
    values: Array


class Wavelets:
    """The transform of a number of frames.

    Parameters
    ----------
    n_frames : int

    Attributes
    ----------
    sizes : array-like of int, shape=[L + 1]
        The number of frames, and of scaling coefficients after each level.
    bands : array-like of int, shape=[L + 2]
        Where each band begins among the coefficients, from coarse to fine, and their number at the end.
    """

    def __init__(self, n_frames: int) -> None:
        sizes = [n_frames]
        while sizes[-1] > _FEWEST:
            sizes.append((sizes[-1] + 1) // 2)
        self.sizes = np.array(sizes, dtype=np.intp)
        self.bands = np.array([0, *sizes[::-1]], dtype=np.intp)

    def analyse(self, samples: Array) -> Array:
        """Return the coefficients, shape=[F, C], of samples, shape=[F, C]."""
        coefficients = np.array(samples, dtype=np.float64, order="C")
        kernel.analyse(coefficients, self.sizes)
        return coefficients

    def synthesise(self, coefficients: Array) -> Array:
        """Return the samples, shape=[F, C], of coefficients, shape=[F, C]."""
        samples = np.array(coefficients, dtype=np.float64, order="C")
        kernel.synthesise(samples, self.sizes)
        return samples

    @cached_property
    def basis(self) -> Basis:
        """Basis functions: the samples of every coefficient, in linear time."""
        coarse = sparse.identity(int(self.sizes[0]), format="csc")
        blocks = []
        for n in self.sizes[:-1]:
            low, high = _one_level(int(n))
            blocks.append(coarse @ high)
            coarse = coarse @ low
        columns = sparse.hstack([coarse, *blocks[::-1]], format="csc")
        columns.sort_indices()
        return _without_gaps(columns)


def _one_level(n: int) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Return the basis functions of one level as matrices: of coarse rows, and of wavelets."""
    half = (n + 1) // 2
    spacing = 2 * _REACH + 2
    combs = np.zeros((n, min(spacing, n)))
    sample = np.arange(n)  # the row that each coefficient belongs to, when bands are interleaved
    row_of = np.where(sample % 2 == 0, sample // 2, half + sample // 2)
    combs[row_of, sample % spacing] = 1.0
    kernel.merge(combs, combs, np.empty_like(combs))
    rows, offsets = np.meshgrid(sample, np.arange(-_REACH, _REACH + 1), indexing="ij")
    owners = rows + offsets
    inside = (owners >= 0) & (owners < n)
    rows, owners = rows[inside], owners[inside]
    values = combs[rows, owners % spacing]
    kept = values != 0.0
    matrix = sparse.csc_matrix((values[kept], (rows[kept], row_of[owners[kept]])), shape=(n, n))
    return matrix[:, :half], matrix[:, half:]


def _without_gaps(columns: sparse.csc_matrix) -> Basis:
    """Store each column from its first row to its last."""
    first, last = columns.indptr[:-1], columns.indptr[1:] - 1
    starts = columns.indices[first].astype(np.intp)
    lengths = columns.indices[last] - starts + 1
    pointers = np.concatenate([[0], np.cumsum(lengths)]).astype(np.intp)
    values = np.zeros(pointers[-1])
    column = np.repeat(np.arange(len(starts)), np.diff(columns.indptr))
    values[pointers[column] + columns.indices - starts[column]] = columns.data
    return Basis(pointers, starts, values)
