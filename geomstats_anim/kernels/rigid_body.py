r"""Compiled flow of the free rigid body: the geodesics of a left-invariant metric on SO(3) that start at the identity.

With the principal moments I and the spatial momentum m, which is constant, the body momentum and velocity along
the geodesic g are :math:`M = g^T m` and :math:`w = I^{-1} M`, and :math:`g' = g \hat w`. Only g is a state:

* The body momentum is a power series in time. Euler's equations :math:`M_1' = (1/I_3 - 1/I_2) M_2 M_3` (and cyclic)
  give its coefficients by recurrence, to any order (Jorba & Zou, "A software package for the numerical integration of
  ODEs by means of high-order Taylor methods", 2005).
* The rotation follows from M up to an angle psi about m: with s = M / |m| and s0 = s(0),
  :math:`g(t) = g(0) R(s_0, \psi) A(s \to s_0)`, A the smallest rotation between the two, and
  :math:`\psi' = w \cdot (s + s_0) / (1 + s \cdot s_0)`. So g^T m = M(t) holds by construction.
* The variation of M by the initial momentum obeys the linearised recurrence, and the body variation
  x of g (:math:`dg = g \hat x`) follows from it without another integral, since dg^T m and the energy are known:
  :math:`x = ((dM - g^T dm) \times M + t (w_0 \cdot dm) M) / |m|^2`.

Every lane chooses its own steps, from the size of its last coefficients; no step is ever rejected.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.simd import LANES, fabs, load, maximum, minimum, rint, splat, sqrt, store
from geomstats_anim.kernels.vectors import cross, dot, load3, load4, multiply, rotate_back, store3

ORDER = 16
"""Order of the power series: a power of two, so that the step comes from square roots alone."""

VARIATION_ORDER = 8
"""Order of the variation's series. Its relative error, about 1e-7 in full precision, only slows Newton down."""

TOLERANCE = 1e-15
"""Size of the last coefficients' terms at the end of a step, relative to a unit momentum."""

# Rows of the workspace that holds one step's series, in every lane.
MOMENTUM = 0
_DENOMINATOR = MOMENTUM + 3 * (ORDER + 1)
_ANGLE = _DENOMINATOR + ORDER + 1
_VARIATION = _ANGLE + ORDER + 2
SERIES_ROWS = _VARIATION + 9 * (VARIATION_ORDER + 1)


@compiled
def _sine_cosine(x):
    """Return sine and cosine of every lane, by Taylor polynomials of a quarter of the reduced angle, doubled twice."""
    x = 0.25 * (x - (2.0 * np.pi) * rint(x * (0.5 / np.pi)))
    square = x * x
    sine = splat(1.0)
    cosine = splat(1.0)
    for k in range(8, 0, -1):
        sine = 1.0 - square * sine * (1.0 / (2 * k * (2 * k + 1)))
        cosine = 1.0 - square * cosine * (1.0 / (2 * k * (2 * k - 1)))
    sine = x * sine
    for _ in range(2):
        sine, cosine = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine
    return sine, cosine


@compiled
def expand(series, inverse, momentum, rotation):
    """Write the series of body momentum and angle about the present time to the workspace.

    Arrays have shape [rows, LANES]: inverse moments (3), spatial momentum (3), rotation (4). Returns the largest of the
    last two coefficients, relative to the momentum.
    """
    inv = load3(inverse, 0)
    m = load3(momentum, 0)
    norm = 1.0 / sqrt(maximum(dot(m, m), splat(1e-300)))
    body = rotate_back(load4(rotation, 0), m)
    store3(series, MOMENTUM, body)
    coupling = (inv[2] - inv[1], inv[0] - inv[2], inv[1] - inv[0])
    start = (body[0] * norm, body[1] * norm, body[2] * norm)
    start_velocity = (inv[0] * start[0], inv[1] * start[1], inv[2] * start[2])
    # store the rate of psi as the series of psi itself, one order higher; psi(0) = 0
    store(series, _ANGLE, splat(0.0))
    store(series, _ANGLE + 1, dot(start_velocity, body))
    size = splat(1e-300)
    for k in range(ORDER):
        m1, m2, m3 = splat(0.0), splat(0.0), splat(0.0)
        angle = splat(0.0)
        for j in range(k + 1):
            a = load3(series, MOMENTUM + 3 * j)
            b = load3(series, MOMENTUM + 3 * (k - j))
            m1 += a[1] * b[2]
            m2 += a[0] * b[2]
            m3 += a[0] * b[1]
            if j > 0:
                angle += load(series, _DENOMINATOR + j) * load(series, _ANGLE + k + 2 - j) * (k + 2 - j)
        next_ = 1.0 / (k + 1)
        coefficient = (coupling[0] * m1 * next_, coupling[1] * m2 * next_, coupling[2] * m3 * next_)
        store3(series, MOMENTUM + 3 * (k + 1), coefficient)
        denominator = dot(start, coefficient) * norm
        store(series, _DENOMINATOR + k + 1, denominator)
        angle += denominator * load(series, _ANGLE + 1)
        angle = 0.5 * (dot(start_velocity, coefficient) - angle) / (k + 2)
        store(series, _ANGLE + k + 2, angle)
        if k >= ORDER - 2:
            largest = maximum(fabs(coefficient[0]), maximum(fabs(coefficient[1]), fabs(coefficient[2])))
            size = maximum(size, maximum(largest * norm, fabs(angle)))
    return size


@compiled
def evaluate(series, momentum, rotation, time):
    """Return the rotation in every lane, a time after the step's start, as four vectors of a unit quaternion."""
    m = load3(momentum, 0)
    norm = 1.0 / sqrt(maximum(dot(m, m), splat(1e-300)))
    a = load3(series, MOMENTUM + 3 * ORDER)
    angle = load(series, _ANGLE + ORDER + 1) * time + load(series, _ANGLE + ORDER)
    for k in range(ORDER - 1, -1, -1):
        b = load3(series, MOMENTUM + 3 * k)
        a = (a[0] * time + b[0], a[1] * time + b[1], a[2] * time + b[2])
        angle = angle * time + load(series, _ANGLE + k)
    b = load3(series, MOMENTUM)
    start = (b[0] * norm, b[1] * norm, b[2] * norm)
    end_norm = 1.0 / sqrt(maximum(dot(a, a), splat(1e-300)))
    end = (a[0] * end_norm, a[1] * end_norm, a[2] * end_norm)
    sine, cosine = _sine_cosine(0.5 * angle)
    turn = (start[0] * sine, start[1] * sine, start[2] * sine, cosine)
    axis = cross(end, start)
    q = multiply(multiply(load4(rotation, 0), turn), (axis[0], axis[1], axis[2], 1.0 + dot(end, start)))
    scale = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale)


@compiled
def expand_variation(series, inverse, variation):
    """Write the series of the variation of body momentum, row 3 d + i for component i of direction d."""
    inv = load3(inverse, 0)
    coupling = (inv[2] - inv[1], inv[0] - inv[2], inv[1] - inv[0])
    for row in range(9):
        store(series, _VARIATION + row, load(variation, row))
    for k in range(VARIATION_ORDER):
        next_ = 1.0 / (k + 1)
        for d in range(3):
            v1, v2, v3 = splat(0.0), splat(0.0), splat(0.0)
            for j in range(k + 1):
                a = load3(series, MOMENTUM + 3 * j)
                b = load3(series, _VARIATION + 9 * (k - j) + 3 * d)
                v1 += a[1] * b[2] + a[2] * b[1]
                v2 += a[0] * b[2] + a[2] * b[0]
                v3 += a[0] * b[1] + a[1] * b[0]
            store3(
                series,
                _VARIATION + 9 * (k + 1) + 3 * d,
                (coupling[0] * v1 * next_, coupling[1] * v2 * next_, coupling[2] * v3 * next_),
            )


@compiled
def advance_variation(series, variation, time):
    """Replace the variation by its value after the step."""
    for row in range(9):
        value = load(series, _VARIATION + 9 * VARIATION_ORDER + row)
        for k in range(VARIATION_ORDER - 1, -1, -1):
            value = value * time + load(series, _VARIATION + 9 * k + row)
        store(variation, row, value)


@compiled
def step_size(size, tolerance):
    """Return the step whose last terms are as large as the tolerance (Jorba & Zou, section 3.2)."""
    return sqrt(sqrt(sqrt(sqrt(tolerance / size))))


@compiled
def leave_identity(lane, inverse, momentum, lane_inverse, lane_momentum, rotation):
    """Put a geodesic, at its start, into a lane."""
    for i in range(3):
        lane_inverse[i, lane], lane_momentum[i, lane], rotation[i, lane] = inverse[i], momentum[i], 0.0
    rotation[3, lane] = 1.0


@compiled
def _find_due(problem, sample, last, parameter, time, step, offset, due):
    """Write where the next samples lie in the present step, and which do; return the number of those."""
    n_due = 0
    for lane in range(LANES):
        due[lane] = False
        if problem[lane] >= 0 and sample[lane] < last[problem[lane]]:
            offset[0, lane] = parameter[sample[lane]] - time[0, lane]
            due[lane] = offset[0, lane] <= step[0, lane]
            n_due += due[lane]
    return n_due


@compiled
def playback(inverse, momentum, first, last, parameter, column, out):
    """Evaluate many geodesics at many parameters.

    Parameters
    ----------
    inverse, momentum : array-like, shape=[n, 3]
        Inverse moments, and momentum at parameter 0.
    first, last : array-like of int, shape=[n]
        Geodesic i is evaluated at parameter[first[i]:last[i]], which must not decrease nor be negative.
    parameter : array-like, shape=[F]
        1 at the end of the unit interval.
    column : array-like of int, shape=[n]
    out : array-like, shape=[F, C, 4]
        Written at [first[i]:last[i], column[i]].
    """
    series = np.zeros((SERIES_ROWS, LANES))
    lane_inverse, lane_momentum, rotation = np.ones((3, LANES)), np.zeros((3, LANES)), np.zeros((4, LANES))
    time, remaining, evaluated = np.zeros((1, LANES)), np.zeros((1, LANES)), np.zeros((4, LANES))
    step, offset, due = np.zeros((1, LANES)), np.zeros((1, LANES)), np.zeros(LANES, dtype=np.bool_)
    problem, sample = np.full(LANES, -1), np.zeros(LANES, dtype=np.int64)
    rotation[3] = 1.0
    upcoming, n_active = 0, 0
    while True:
        for lane in range(LANES):
            while problem[lane] < 0 and upcoming < len(first):
                if last[upcoming] > first[upcoming]:
                    problem[lane], sample[lane] = upcoming, first[upcoming]
                    time[0, lane] = 0.0
                    leave_identity(lane, inverse[upcoming], momentum[upcoming], lane_inverse, lane_momentum, rotation)
                    n_active += 1
                upcoming += 1
            if problem[lane] >= 0:
                remaining[0, lane] = parameter[last[problem[lane]] - 1] - time[0, lane]
        if n_active == 0:
            return
        size = expand(series, lane_inverse, lane_momentum, rotation)
        store(step, 0, step_size(size, splat(TOLERANCE)))
        while _find_due(problem, sample, last, parameter, time, step, offset, due) > 0:
            q = evaluate(series, lane_momentum, rotation, load(offset, 0))
            for i in range(4):
                store(evaluated, i, q[i])
            for lane in range(LANES):
                if due[lane]:
                    for i in range(4):
                        out[sample[lane], column[problem[lane]], i] = evaluated[i, lane]
                    sample[lane] += 1
        store(step, 0, minimum(load(step, 0), load(remaining, 0)))
        q = evaluate(series, lane_momentum, rotation, load(step, 0))
        for i in range(4):
            store(rotation, i, q[i])
        for lane in range(LANES):
            time[0, lane] += step[0, lane]
            if problem[lane] >= 0 and sample[lane] >= last[problem[lane]]:
                problem[lane] = -1
                n_active -= 1
