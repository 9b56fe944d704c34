"""The biorthogonal wavelets 9/7 by lifting (Daubechies and Sweldens, "Factoring wavelet transforms", 1998).

Coefficients are stored from coarse to fine: a band of scaling coefficients, then one band of wavelets per level.
"""

from __future__ import annotations

from geomstats_anim.kernels.compilation import compiled

ALPHA, BETA, GAMMA, DELTA = -1.586134342059924, -0.052980118572961, 0.882911075530934, 0.443506852043971
"""Weights of the four lifting steps."""

SCALE = 1.149604398860241
"""What makes the basis nearly orthonormal."""


@compiled
def lift(values, parity, weight):
    """Add to every other row its two neighbours, shape=[n, C], reflected at the ends; `parity` 0 for even rows."""
    n = len(values)
    for i in range(parity, n, 2):
        left = i - 1 if i > 0 else 1
        right = i + 1 if i + 1 < n else n - 2
        for c in range(values.shape[1]):
            values[i, c] += weight * (values[left, c] + values[right, c])


@compiled
def split(values, bands, buffer):
    """Transform one level.

    Parameters
    ----------
    values : array-like, shape=[n, C]
        Overwritten.
    bands : array-like, shape=[n, C]
        Written: first the (n + 1) // 2 coarse rows, then the n // 2 wavelets. May be `values`.
    buffer : array-like, shape=[n, C]
        Room to work in.
    """
    n = len(values)
    half = (n + 1) // 2
    lift(values, 1, ALPHA)
    lift(values, 0, BETA)
    lift(values, 1, GAMMA)
    lift(values, 0, DELTA)
    for i in range(n):
        row = half + i // 2 if i % 2 else i // 2
        factor = 1.0 / SCALE if i % 2 else SCALE
        for c in range(values.shape[1]):
            buffer[row, c] = factor * values[i, c]
    for i in range(n):
        for c in range(values.shape[1]):
            bands[i, c] = buffer[i, c]


@compiled
def merge(bands, values, buffer):
    """Invert `split`: from bands, shape=[n, C], to values, shape=[n, C], which may be the same array."""
    n = len(values)
    half = (n + 1) // 2
    for i in range(n):
        row = half + i // 2 if i % 2 else i // 2
        factor = SCALE if i % 2 else 1.0 / SCALE
        for c in range(values.shape[1]):
            buffer[i, c] = factor * bands[row, c]
    lift(buffer, 0, -DELTA)
    lift(buffer, 1, -GAMMA)
    lift(buffer, 0, -BETA)
    lift(buffer, 1, -ALPHA)
    for i in range(n):
        for c in range(values.shape[1]):
            values[i, c] = buffer[i, c]


@compiled
def analyse(values, sizes):
    """Transform in place.

    Parameters
    ----------
    values : array-like, shape=[F, C]
        Samples, then coefficients.
    sizes : array-like of int, shape=[L + 1]
        F, and the number of scaling coefficients after every level.
    """
    buffer = values.copy()
    for level in range(len(sizes) - 1):
        n = sizes[level]
        split(values[:n], values[:n], buffer[:n])


@compiled
def synthesise(values, sizes):
    """Invert `analyse`, in place."""
    buffer = values.copy()
    for level in range(len(sizes) - 2, -1, -1):
        n = sizes[level]
        merge(values[:n], values[:n], buffer[:n])


@compiled
def scaled(integers, bands, units, groups, coefficients):
    """Write the coefficients, shape=[F, 3 N], of some groups, shape=[N], of integers, shape=[F, G, 3]."""
    for band in range(len(bands) - 1):
        for k in range(bands[band], bands[band + 1]):
            for i in range(len(groups)):
                unit = units[band, groups[i]]
                for c in range(3):
                    coefficients[k, 3 * i + c] = integers[k, groups[i], c] * unit
