r"""Compiled variation of geodesics from the identity by their initial momentum and their metric, exact to rounding.

With the body momentum M, the velocity :math:`w = D^{-1} M` and a body variation x (:math:`dg = g \hat x`),
:math:`M' = M \times w`, :math:`dM' = dM \times w + M \times dw`, :math:`dw = D^{-1} dM + dD^{-1} M` and
:math:`x' = dw + x \times w`. All are power series in time, whose coefficients follow by recurrence; nothing is divided
by the momentum, so that a geodesic that stands still varies as well.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.rigid_body import TOLERANCE

_ORDER = 16
_MOMENTA = 3
_DIRECTIONS = 5
"""The three components of the initial momentum; log alpha and log beta at fixed momentum."""


@compiled
def _add_cross(out, left, right):
    out[0] += left[1] * right[2] - left[2] * right[1]
    out[1] += left[2] * right[0] - left[0] * right[2]
    out[2] += left[0] * right[1] - left[1] * right[0]


@compiled
def _expand(inverse, momentum, velocity, changed, rate, varied):
    """Write the coefficients of M, w, dM, dw and x from their first ones, those of M, dM and x."""
    for k in range(_ORDER + 1):
        for i in range(3):
            velocity[k, i] = inverse[i] * momentum[k, i]
            for d in range(_DIRECTIONS):
                rate[k, d, i] = inverse[i] * changed[k, d, i]
        for i in range(1, 3):
            rate[k, _MOMENTA + i - 1, i] -= velocity[k, i]
        if k == _ORDER:
            return
        momentum[k + 1] = 0.0
        changed[k + 1] = 0.0
        varied[k + 1] = rate[k]
        for j in range(k + 1):
            _add_cross(momentum[k + 1], momentum[j], velocity[k - j])
            for d in range(_DIRECTIONS):
                _add_cross(changed[k + 1, d], changed[j, d], velocity[k - j])
                _add_cross(changed[k + 1, d], momentum[j], rate[k - j, d])
                _add_cross(varied[k + 1, d], varied[j, d], velocity[k - j])
        momentum[k + 1] /= k + 1
        changed[k + 1] /= k + 1
        varied[k + 1] /= k + 1


@compiled
def _step(series):
    """Return the time at which the last two terms of a series, shape=[_ORDER + 1, ...], are small beside the first."""
    first, last, before = series[0].ravel(), series[_ORDER].ravel(), series[_ORDER - 1].ravel()
    second = series[1].ravel()
    largest, scale = 1e-300, 1e-300
    for i in range(len(first)):
        scale = max(scale, abs(first[i]), abs(second[i]))
        largest = max(largest, abs(last[i]), abs(before[i]))
    return min((TOLERANCE * scale / largest) ** (1.0 / _ORDER), 1e3)


@compiled
def _evaluate(series, time, out):
    out[:] = series[_ORDER]
    for k in range(_ORDER - 1, -1, -1):
        out *= time
        out += series[k]


@compiled
def vary(inverse, momentum, first, last, parameter, column, out):
    """Write the body variations of samples of geodesics.

    Parameters
    ----------
    inverse, momentum : array-like, shape=[n, 3]
        Inverse moments, and momenta of geodesics from the identity.
    first, last : array-like of int, shape=[n]
        Geodesic i is sampled at parameter[first[i]:last[i]], which is not negative and does not decrease.
    parameter : array-like, shape=[F]
    column : array-like of int, shape=[n]
    out : array-like, shape=[F, C, 5, 3]
        Written at [first[i]:last[i], column[i]]: by the components of the momentum, by log alpha, by log beta.
    """
    m, w = np.zeros((_ORDER + 1, 3)), np.zeros((_ORDER + 1, 3))
    shape = (_ORDER + 1, _DIRECTIONS, 3)
    dm, dw, x = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    m_next, next_ = np.zeros(3), np.zeros((_DIRECTIONS, 3))
    for n in range(len(inverse)):
        m[0] = momentum[n]
        dm[0] = 0.0
        x[0] = 0.0
        for i in range(3):
            dm[0, i, i] = 1.0
        time, sample = 0.0, first[n]
        while sample < last[n]:
            _expand(inverse[n], m, w, dm, dw, x)
            step = min(_step(m), _step(dm), _step(x))
            while sample < last[n] and parameter[sample] <= time + step:
                _evaluate(x, parameter[sample] - time, out[sample, column[n]])
                sample += 1
            _evaluate(m, step, m_next)
            m[0] = m_next
            for series in (dm, x):
                _evaluate(series, step, next_)
                series[0] = next_
            time += step
