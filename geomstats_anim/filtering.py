"""Low-pass filters of motion: forwards and backwards, so that nothing is late; rotations about a moving mean."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array

ORDER = 8
"""Of the Butterworth filter, whose passband has no ripples: half of the amplitude is left at the cutoff, a thirtieth at
5/4 of it."""

MEAN = 0.5
"""Cutoff of the moving mean, as a share of the filter's: slower, so that what the mean takes is not taken twice."""

_LONG = 8.0
"""Periods of the cutoff by which both ends are continued: point reflected, so that value and slope carry on."""


def low_pass(values: Array, samples_per_second: float, cutoff: float) -> Array:
    """Filter evenly spaced samples of vectors.

    Parameters
    ----------
    values : array-like, shape=[F, ...]
    samples_per_second : float
    cutoff : float
        Hertz, below half of `samples_per_second`.

    Returns
    -------
    filtered : array-like, shape=[F, ...]

    Raises
    ------
    ValueError
        If the cutoff is not between 0 and half of the rate.
    """
    if not 0.0 < cutoff < samples_per_second / 2.0:
        raise ValueError(f"cutoff must be between 0 and {samples_per_second / 2.0:g} Hz, not {cutoff:g}.")
    if len(values) < 2:
        return np.array(values, dtype=np.float64)
    from scipy.signal import butter, sosfiltfilt

    n_padded = int(np.ceil(_LONG * samples_per_second / cutoff))
    padding = [(n_padded, n_padded), *[(0, 0)] * (np.ndim(values) - 1)]
    padded = np.pad(values, padding, mode="reflect", reflect_type="odd")
    sections = butter(ORDER, cutoff, fs=samples_per_second, output="sos")
    return sosfiltfilt(sections, padded, axis=0, padlen=0)[n_padded:-n_padded]


def low_pass_rotations(rotations: Array, samples_per_second: float, cutoff: float) -> Array:
    """Filter evenly spaced rotations in the tangent spaces of a moving mean.

    The mean is that of the chordal distance: quaternions filtered as vectors, and made unit. What is left of each
    rotation beside its mean is a rotation vector, which is filtered too and put back, so that large turns are filtered
    along geodesics. Turning all rotations by one, on either side, turns the result.

    Parameters
    ----------
    rotations : array-like, shape=[F, ..., 4]
        Unit quaternions.
    samples_per_second : float
    cutoff : float
        Hertz, below half of `samples_per_second`.

    Returns
    -------
    filtered : array-like, shape=[F, ..., 4]
        Sign-continuous along time; the first is nearer to the given one than its negative is.

    Raises
    ------
    ValueError
        If the cutoff is not between 0 and half of the rate.
    """
    continuous = quat.make_continuous(np.asarray(rotations, dtype=np.float64))
    mean = low_pass(continuous, samples_per_second, MEAN * cutoff)
    sizes = np.linalg.norm(mean, axis=-1, keepdims=True)
    # opposite quaternions may cancel out; there the rotation is its own mean
    mean = np.where(sizes > 1e-3, mean / np.maximum(sizes, 1e-3), continuous)
    beside = low_pass(quat.difference(mean, continuous), samples_per_second, cutoff)
    return quat.make_continuous(quat.multiply(mean, quat.exp(beside)))
