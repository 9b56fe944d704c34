r"""Compiled derivative of geodesics between fixed end points by their metric, pulled back onto a scalar.

The papers say that the criterion has no gradient, because the geodesics have no closed form. Implicit differentiation
gives it all the same: the end point x(1) of the variation is known, so the variation of the initial momentum is
:math:`dm = J^{-1} (x(1) - x_D(1))`, where J is the Jacobian that the boundary value solver uses, and x_D the variation
by the moments at fixed momentum. Pulled back, a segment costs one linear solve for :math:`\lambda = J^{-T} S_m`.

The variation of body momentum by the moments obeys the linearised Euler equations with a forcing term. The body
variation follows from it as in `rigid_body`, but the energy now changes by :math:`m \cdot dD^{-1} m / 2`, and
:math:`x \cdot M` grows with the integral of :math:`M \cdot dD^{-1} M / 2` besides.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.rigid_body import (
    MOMENTUM,
    SERIES_ROWS,
    TOLERANCE,
    VARIATION_ORDER,
    evaluate,
    expand,
    leave_identity,
    step_size,
)
from geomstats_anim.kernels.simd import LANES, load, minimum, splat, store
from geomstats_anim.kernels.vectors import cross, dot, load3, rotate_back, store3

# Directions: the three components of the initial momentum, log alpha, log beta. Row 3 d + i is component i.
_MOMENTA = 3
_DIRECTIONS = 5
_ROWS = 3 * _DIRECTIONS
# The integrals of the squares of body momentum's second and third component follow.
_STATE_ROWS = _ROWS + 2
# Sums over samples: by momentum (3), by moments (2), by axes (3).
_SUM_ROWS = 8


@compiled
def _expand_variation(series, inverse, variation, expansion):
    """Write the series of the variation and of the integrals, _STATE_ROWS rows per coefficient."""
    inv = load3(inverse, 0)
    coupling = (inv[2] - inv[1], inv[0] - inv[2], inv[1] - inv[0])
    for row in range(_STATE_ROWS):
        store(expansion, row, load(variation, row))
    for k in range(VARIATION_ORDER):
        next_ = 1.0 / (k + 1)
        p1, p2, p3 = splat(0.0), splat(0.0), splat(0.0)
        s2, s3 = splat(0.0), splat(0.0)
        for j in range(k + 1):
            a, b = load3(series, MOMENTUM + 3 * j), load3(series, MOMENTUM + 3 * (k - j))
            p1 += a[1] * b[2]
            p2 += a[0] * b[2]
            p3 += a[0] * b[1]
            s2 += a[1] * b[1]
            s3 += a[2] * b[2]
        row = _STATE_ROWS * (k + 1)
        store(expansion, row + _ROWS, s2 * next_)
        store(expansion, row + _ROWS + 1, s3 * next_)
        for d in range(_DIRECTIONS):
            v1, v2, v3 = splat(0.0), splat(0.0), splat(0.0)
            for j in range(k + 1):
                a = load3(series, MOMENTUM + 3 * j)
                b = load3(expansion, _STATE_ROWS * (k - j) + 3 * d)
                v1 += a[1] * b[2] + a[2] * b[1]
                v2 += a[0] * b[2] + a[2] * b[0]
                v3 += a[0] * b[1] + a[1] * b[0]
            v1, v2, v3 = coupling[0] * v1, coupling[1] * v2, coupling[2] * v3
            if d == _MOMENTA:
                v1, v3 = v1 + inv[1] * p1, v3 - inv[1] * p3
            elif d == _MOMENTA + 1:
                v1, v2 = v1 - inv[2] * p1, v2 + inv[2] * p2
            store3(expansion, row + 3 * d, (v1 * next_, v2 * next_, v3 * next_))


@compiled
def _advance(expansion, time, out):
    """Write the variation and the integrals at a time after the step's start."""
    for row in range(_STATE_ROWS):
        value = load(expansion, _STATE_ROWS * VARIATION_ORDER + row)
        for k in range(VARIATION_ORDER - 1, -1, -1):
            value = value * time + load(expansion, _STATE_ROWS * k + row)
        store(out, row, value)


@compiled
def _body_variations(inverse, momentum, q, variation, time, out):
    """Write the body variation of the rotation in every direction, row 3 d + i for component i."""
    inv, m = load3(inverse, 0), load3(momentum, 0)
    body = rotate_back(q, m)
    scale = 1.0 / (dot(m, m) + 1e-300)
    one, zero = splat(1.0), splat(0.0)
    for d in range(_DIRECTIONS):
        dm = load3(variation, 3 * d)
        if d == 0:
            fixed, along = rotate_back(q, (one, zero, zero)), time * inv[0] * m[0]
        elif d == 1:
            fixed, along = rotate_back(q, (zero, one, zero)), time * inv[1] * m[1]
        elif d == 2:
            fixed, along = rotate_back(q, (zero, zero, one)), time * inv[2] * m[2]
        elif d == _MOMENTA:
            fixed, along = (zero, zero, zero), -0.5 * inv[1] * (time * m[1] * m[1] + load(variation, _ROWS))
        else:
            fixed, along = (zero, zero, zero), -0.5 * inv[2] * (time * m[2] * m[2] + load(variation, _ROWS + 1))
        x = cross((dm[0] - fixed[0], dm[1] - fixed[1], dm[2] - fixed[2]), body)
        store3(
            out,
            3 * d,
            (scale * (x[0] + along * body[0]), scale * (x[1] + along * body[1]), scale * (x[2] + along * body[2])),
        )


@compiled
def _add_sample(q, variations, cotangent, sums):
    """Add a sample's share to the sums, in every lane; a cotangent of zero adds nothing."""
    c = load3(cotangent, 0)
    for d in range(_DIRECTIONS):
        store(sums, d, load(sums, d) + dot(c, load3(variations, 3 * d)))
    turned = rotate_back((-q[0], -q[1], -q[2], q[3]), c)
    for i in range(3):
        store(sums, _DIRECTIONS + i, load(sums, _DIRECTIONS + i) + (c[i] - turned[i]))


@compiled
def _finish(sums, variations, rotation, lane, out):
    """Write the derivative by log alpha, log beta and the axes, from the sums and the variations at the end."""
    x, y, z = variations[0:3, lane], variations[3:6, lane], variations[6:9, lane]
    yz, zx, xy = cross(y, z), cross(z, x), cross(x, y)
    determinant = dot(x, yz)
    solved = np.zeros(3)
    # without motion nothing depends on the metric
    if determinant != 0.0:
        for i in range(3):
            solved[i] = (sums[0, lane] * yz[i] + sums[1, lane] * zx[i] + sums[2, lane] * xy[i]) / determinant
    for d in range(2):
        out[d] = sums[_MOMENTA + d, lane] - dot(solved, variations[9 + 3 * d : 12 + 3 * d, lane])
    q = (-rotation[0, lane], -rotation[1, lane], -rotation[2, lane], rotation[3, lane])
    turned = rotate_back(q, (solved[0], solved[1], solved[2]))
    for i in range(3):
        out[2 + i] = sums[_DIRECTIONS + i, lane] + turned[i] - solved[i]


@compiled
def _find_due(problem, sample, last, parameter, column, cotangent, time, step, offset, due_cotangent):
    """Take the next sample of every lane that has one in the present step, and return their number.

    Its place in the step and its cotangent are written; a lane without one has a cotangent of zero.
    """
    n_due = 0
    for lane in range(LANES):
        due_cotangent[:, lane] = 0.0
        p = problem[lane]
        if p >= 0 and sample[lane] < last[p] and parameter[sample[lane]] <= time[0, lane] + step[0, lane]:
            offset[0, lane] = parameter[sample[lane]] - time[0, lane]
            for i in range(3):
                due_cotangent[i, lane] = cotangent[sample[lane], column[p], i]
            sample[lane] += 1
            n_due += 1
    return n_due


@compiled
def pull_back(inverse, momentum, first, last, parameter, column, cotangent, partial, out):
    """Pull the derivative of a scalar by sampled rotations back to one by the metric.

    Parameters
    ----------
    inverse, momentum : array-like, shape=[n, 3]
        Inverse moments, and momenta of geodesics from the identity.
    first, last : array-like of int, shape=[n]
        Geodesic i is sampled at parameter[first[i]:last[i]], which lies in [0, 1] and does not decrease.
    parameter : array-like, shape=[F]
    column : array-like of int, shape=[n]
    cotangent : array-like, shape=[F, C, 3]
        Derivative of the scalar by the body variation of the sample at [first[i]:last[i], column[i]].
    partial : array-like, shape=[n, 8]
        Derivatives of what else depends on the geodesics: by the initial momentum (3), by log alpha and log beta at
        fixed momentum (2), by a turn of the axes at fixed momentum (3).
    out : array-like, shape=[n, 5]
        Written: derivatives by log alpha, log beta, and a rotation vector that turns the axes from the left.
    """
    n = len(inverse)
    series = np.zeros((SERIES_ROWS, LANES))
    expansion = np.zeros((_STATE_ROWS * (VARIATION_ORDER + 1), LANES))
    lane_inverse, lane_momentum, rotation = np.ones((3, LANES)), np.zeros((3, LANES)), np.zeros((4, LANES))
    variation, sampled = np.zeros((_STATE_ROWS, LANES)), np.zeros((_STATE_ROWS, LANES))
    variations, sums, due_cotangent = np.zeros((_ROWS, LANES)), np.zeros((_SUM_ROWS, LANES)), np.zeros((3, LANES))
    time, step, offset = np.ones((1, LANES)), np.zeros((1, LANES)), np.zeros((1, LANES))
    problem, sample = np.full(LANES, -1), np.zeros(LANES, dtype=np.int64)
    rotation[3] = 1.0
    upcoming, n_active = 0, 0
    while True:
        for lane in range(LANES):
            if time[0, lane] < 1.0:
                continue
            if problem[lane] >= 0:
                _finish(sums, variations, rotation, lane, out[problem[lane]])
                problem[lane] = -1
                n_active -= 1
            time[0, lane] = 0.0
            for row in range(_SUM_ROWS):
                sums[row, lane] = partial[upcoming, row] if upcoming < n else 0.0
            for row in range(_STATE_ROWS):
                variation[row, lane] = 1.0 if row < 9 and row % 4 == 0 else 0.0
            if upcoming < n:
                leave_identity(lane, inverse[upcoming], momentum[upcoming], lane_inverse, lane_momentum, rotation)
                problem[lane], sample[lane] = upcoming, first[upcoming]
                upcoming += 1
                n_active += 1
            else:
                leave_identity(lane, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), lane_inverse, lane_momentum, rotation)
        if n_active == 0:
            return
        size = expand(series, lane_inverse, lane_momentum, rotation)
        _expand_variation(series, lane_inverse, variation, expansion)
        store(step, 0, minimum(step_size(size, splat(TOLERANCE)), 1.0 - load(time, 0)))
        while _find_due(problem, sample, last, parameter, column, cotangent, time, step, offset, due_cotangent) > 0:
            q = evaluate(series, lane_momentum, rotation, load(offset, 0))
            _advance(expansion, load(offset, 0), sampled)
            now = load(time, 0) + load(offset, 0)
            _body_variations(lane_inverse, lane_momentum, q, sampled, now, variations)
            _add_sample(q, variations, due_cotangent, sums)
        q = evaluate(series, lane_momentum, rotation, load(step, 0))
        _advance(expansion, load(step, 0), variation)
        for i in range(4):
            store(rotation, i, q[i])
        store(time, 0, load(time, 0) + load(step, 0))
        _body_variations(lane_inverse, lane_momentum, q, variation, load(time, 0), variations)
