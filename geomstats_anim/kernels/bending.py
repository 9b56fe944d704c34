r"""Compiled bending of geodesics: g(u) becomes g(u) exp(c(u)), with the cubic c of `tangents`."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.hermite import weights
from geomstats_anim.kernels.quaternions import exp_of
from geomstats_anim.kernels.vectors import cross, multiply


@compiled
def _cubic(start, end, parameter):
    first, second = weights(parameter)
    return (
        first * start[0] + second * end[0],
        first * start[1] + second * end[1],
        first * start[2] + second * end[2],
    )


@compiled
def bend(turned, index, parameter, start, end):
    """Bend geodesics in place.

    Parameters
    ----------
    turned : array-like, shape=[F, B, 4]
        Unit quaternions at parameter[f] of geodesics index[f].
    index : array-like of int, shape=[F]
    parameter : array-like, shape=[F]
        In [0, 1].
    start, end : array-like, shape=[n, B, 3]
        Bends of the geodesics at both ends.
    """
    for f in range(len(index)):
        for b in range(turned.shape[1]):
            c = _cubic(start[index[f], b], end[index[f], b], parameter[f])
            q = (turned[f, b, 0], turned[f, b, 1], turned[f, b, 2], turned[f, b, 3])
            bent = multiply(q, exp_of(c))
            for i in range(4):
                turned[f, b, i] = bent[i]


@compiled
def unbend(index, parameter, start, end, cotangent, by_start, by_end, by_axes):
    """Pull the derivative by bent geodesics back to one by the geodesics, in place, and to one by the bends.

    A variation of c turns exp(c) by its right Jacobian, whose transpose is the left one (Sola 2017, equation 145).

    Parameters
    ----------
    index, parameter, start, end
        As in `bend`.
    cotangent : array-like, shape=[F, B, 3]
        Derivative by the body variation of the bent geodesics; that by the geodesics' own is written over it.
    by_start, by_end : array-like, shape=[n, B, 3]
        Added to: derivatives by the bends.
    by_axes : array-like, shape=[n, B, 3]
        Added to: what the cotangent loses, as what is outside the bend turns with the axes as a whole.
    """
    for f in range(len(index)):
        u, k = parameter[f], index[f]
        first, second = weights(u)
        for b in range(cotangent.shape[1]):
            c = _cubic(start[k, b], end[k, b], u)
            x = (cotangent[f, b, 0], cotangent[f, b, 1], cotangent[f, b, 2])
            square = c[0] ** 2 + c[1] ** 2 + c[2] ** 2
            angle = np.sqrt(square)
            if angle > 1e-3:
                sine = np.sin(angle) / angle
                versine = (1.0 - np.cos(angle)) / square
                rest = (1.0 - sine) / square
            else:
                # the series, as the quotients cancel; what is left out is below 1e-14
                sine = 1.0 - square / 6.0 + square**2 / 120.0
                versine = 0.5 - square / 24.0 + square**2 / 720.0
                rest = 1.0 / 6.0 - square / 120.0 + square**2 / 5040.0
            once = cross(c, x)
            twice = cross(c, once)
            for i in range(3):
                by_cubic = x[i] + versine * once[i] + rest * twice[i]
                by_start[k, b, i] += first * by_cubic
                by_end[k, b, i] += second * by_cubic
                turned = sine * once[i] + versine * twice[i]
                by_axes[k, b, i] -= turned
                cotangent[f, b, i] = x[i] + turned


@compiled
def gather(index, parameter, cotangent, by_start, by_end):
    """Pull the derivative by points, shape=[F, B, 3], that c has been added to back to one by the bends, and add it."""
    for f in range(len(index)):
        k = index[f]
        first, second = weights(parameter[f])
        for b in range(cotangent.shape[1]):
            for i in range(3):
                by_start[k, b, i] += first * cotangent[f, b, i]
                by_end[k, b, i] += second * cotangent[f, b, i]
