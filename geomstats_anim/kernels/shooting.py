"""Compiled shooting: the momentum whose geodesic from the identity ends at a given rotation.

Each lane works on a problem of its own, and takes the next one when it is done. A problem is a shot, a look at where it
ended, and the next shot:

* Newton steps with the exact Jacobian, cut back where they do not shorten the miss, or leave the ball of curves that
  are no longer than the bi-invariant geodesic: its length bounds the shortest from above.
* The first shots are imprecise: a shot's tolerance follows the square of the miss before it, as Newton's error does.
* Where Newton fails, continuation in the metric: from the bi-invariant metric, whose logarithm is known, along I^tau,
  tau from 0 to 1, in steps that adapt to their success. Newton alone is its first try, one step from 0 to 1.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.rigid_body import (
    SERIES_ROWS,
    TOLERANCE,
    advance_variation,
    evaluate,
    expand,
    expand_variation,
    step_size,
)
from geomstats_anim.kernels.simd import LANES, load, minimum, store
from geomstats_anim.kernels.vectors import rotate_back

CONVERGED, STALLED, MAX_ITERATIONS = 0, 1, 2
_GO_ON = -1

MISS = 1e-12
"""Largest miss of the end point, in radians, of a geodesic that counts as found."""

_MISS_AT_ROUNDING = 2e-11
"""Miss that counts as found where no step makes it smaller, because the motion amplifies rounding."""

_MISS_ON_THE_WAY = 1e-3
"""Miss at which the continuation goes on to its next metric."""

_FIRST_TOLERANCE = 1e-7
_FIRST_CONTINUATION_STEP = 0.25
_SMALLEST_CONTINUATION_STEP = 1.0 / 32.0
_CUT = 0.3
_SMALLEST_CUT = 0.005
_MAX_SHOTS = 100
_MAX_STEPS = 2000
"""Taylor steps of a shot, after which it counts as gone astray; condition 100 needs some hundred."""

_SLACK = 1.2
"""Largest energy of an iterate, as a multiple of the bi-invariant geodesic's."""

LANE = np.dtype(
    [
        ("problem", np.int64),  # -1: idle
        ("moments", np.float64, 3),
        ("vector", np.float64, 3),
        ("target", np.float64, 4),
        ("tau", np.float64),  # the continuation has arrived here,
        ("solved", np.float64, 3),  # with this momentum,
        ("tau_step", np.float64),  # and tries to go on by this
        ("metric", np.float64, 3),  # to these moments
        ("bound", np.float64),
        ("base", np.float64, 3),  # best momentum there,
        ("base_miss", np.float64),  # its miss,
        ("base_tolerance", np.float64),  # seen with this tolerance,
        ("newton", np.float64, 3),  # and the step from it,
        ("cut", np.float64),  # of which this share is tried
        ("trial", np.float64, 3),
        ("tolerance", np.float64),
        ("shots", np.int64),
    ]
)
"""State of a lane."""


@compiled
def _guess(vector, moments):
    """Guess the momentum: half way, the body velocity is nearly that of the bi-invariant geodesic."""
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    scale = np.sin(0.25 * angle) / angle if angle > 0.0 else 0.25
    image = (moments[0] * vector[0], moments[1] * vector[1], moments[2] * vector[2])
    half_turn_back = (-scale * vector[0], -scale * vector[1], -scale * vector[2], np.cos(0.25 * angle))
    return rotate_back(half_turn_back, image)


@compiled
def _begin(lane, problem, moments, vector, start):
    """Give a lane a new problem."""
    lane.problem = problem
    lane.shots = 0
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    sine = np.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    lane.target[3] = np.cos(0.5 * angle)
    for i in range(3):
        lane.moments[i] = moments[i]
        lane.vector[i] = vector[i]
        lane.target[i] = sine * vector[i]
        lane.solved[i] = vector[i]
    lane.tau, lane.tau_step = 0.0, 1.0
    _aim(lane)
    if not np.isnan(start[0]):
        for i in range(3):
            lane.trial[i] = start[i]


@compiled
def _aim(lane):
    """Aim at the continuation's next metric."""
    lane.bound = 0.0
    for i in range(3):
        lane.metric[i] = lane.moments[i] ** (lane.tau + lane.tau_step)
        lane.bound += lane.metric[i] * lane.vector[i] ** 2
    guess = _guess(lane.vector, lane.metric)
    here = _guess(lane.vector, (lane.moments[0] ** lane.tau, lane.moments[1] ** lane.tau, lane.moments[2] ** lane.tau))
    energy = 0.0
    for i in range(3):
        lane.trial[i] = guess[i] + lane.solved[i] - here[i]
        energy += lane.trial[i] ** 2 / lane.metric[i]
    if energy > lane.bound:
        for i in range(3):
            lane.trial[i] *= np.sqrt(lane.bound / energy)
    lane.base_miss = np.inf
    lane.tolerance = _FIRST_TOLERANCE


@compiled
def _judge(lane, rotation, variation, number, may_follow, trusted):
    """Check where a shot ended, and choose the next one or a status."""
    lane.shots += 1
    miss = _miss(lane.target, rotation, number)
    length = np.sqrt(miss[0] ** 2 + miss[1] ** 2 + miss[2] ** 2)
    at_end = lane.tau + lane.tau_step >= 1.0
    precise = lane.tolerance <= TOLERANCE
    energy = 0.0
    for i in range(3):
        energy += lane.trial[i] ** 2 / lane.metric[i]
    within = energy <= _SLACK * lane.bound or lane.base_miss == np.inf
    if length <= MISS or (length < lane.base_miss and within):
        lane.base_miss, lane.base_tolerance = length, lane.tolerance
        for i in range(3):
            lane.base[i] = lane.trial[i]
        if at_end and precise and length <= MISS:
            return CONVERGED
        if not at_end and length <= _MISS_ON_THE_WAY:
            lane.tau += lane.tau_step
            for i in range(3):
                lane.solved[i] = lane.trial[i]
            lane.tau_step = min(2.0 * lane.tau_step, 1.0 - lane.tau)
            _aim(lane)
            return _GO_ON
        _newton(lane, rotation, variation, number, miss)
        if at_end and length <= trusted:
            for i in range(3):
                lane.base[i] += lane.newton[i]
            return CONVERGED
        lane.cut = 1.0
        if at_end:
            lane.tolerance = min(max(1e-4 * length * length, TOLERANCE), _FIRST_TOLERANCE)
    else:
        if at_end and lane.base_tolerance <= TOLERANCE and lane.base_miss <= _MISS_AT_ROUNDING:
            return CONVERGED
        lane.cut *= _CUT
        if not lane.cut >= _SMALLEST_CUT:
            if not may_follow:
                return STALLED
            lane.tau_step = min(0.5 * lane.tau_step, _FIRST_CONTINUATION_STEP)
            if lane.tau_step < _SMALLEST_CONTINUATION_STEP:
                return STALLED
            _aim(lane)
            return _GO_ON
    if lane.shots >= _MAX_SHOTS:
        return MAX_ITERATIONS
    for i in range(3):
        lane.trial[i] = lane.base[i] + lane.cut * lane.newton[i]
    return _GO_ON


@compiled
def _miss(target, rotation, number):
    """Return the rotation vector from a shot's end to its target, in the body frame, exact to second order."""
    x, y, z, w = rotation[0, number], rotation[1, number], rotation[2, number], rotation[3, number]
    scale = 4.0 / (1.0 + max(w * target[3] + x * target[0] + y * target[1] + z * target[2], -0.9))
    return (
        scale * (w * target[0] - target[3] * x - y * target[2] + z * target[1]),
        scale * (w * target[1] - target[3] * y - z * target[0] + x * target[2]),
        scale * (w * target[2] - target[3] * z - x * target[1] + y * target[0]),
    )


@compiled
def _newton(lane, rotation, variation, number, miss):
    """Write the change of momentum that closes the miss to first order."""
    m = (lane.trial[0], lane.trial[1], lane.trial[2])
    q = (rotation[0, number], rotation[1, number], rotation[2, number], rotation[3, number])
    body = rotate_back(q, m)
    scale = 1.0 / max(m[0] ** 2 + m[1] ** 2 + m[2] ** 2, 1e-300)
    columns = np.empty((3, 3))
    for d in range(3):
        unit = rotate_back(q, (1.0 if d == 0 else 0.0, 1.0 if d == 1 else 0.0, 1.0 if d == 2 else 0.0))
        a = (
            variation[3 * d, number] - unit[0],
            variation[3 * d + 1, number] - unit[1],
            variation[3 * d + 2, number] - unit[2],
        )
        along = m[d] / lane.metric[d]
        columns[d, 0] = scale * (a[1] * body[2] - a[2] * body[1] + along * body[0])
        columns[d, 1] = scale * (a[2] * body[0] - a[0] * body[2] + along * body[1])
        columns[d, 2] = scale * (a[0] * body[1] - a[1] * body[0] + along * body[2])
    determinant, energy = 0.0, 0.0
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        normal = (
            columns[e, 1] * columns[f, 2] - columns[e, 2] * columns[f, 1],
            columns[e, 2] * columns[f, 0] - columns[e, 0] * columns[f, 2],
            columns[e, 0] * columns[f, 1] - columns[e, 1] * columns[f, 0],
        )
        if d == 0:
            determinant = normal[0] * columns[0, 0] + normal[1] * columns[0, 1] + normal[2] * columns[0, 2]
        step = normal[0] * miss[0] + normal[1] * miss[1] + normal[2] * miss[2]
        # without motion there is no Jacobian, and no miss either
        lane.newton[d] = step / determinant if determinant != 0.0 else 0.0
        energy += lane.newton[d] ** 2 / lane.metric[d]
    # near a conjugate point the step is wild; a curve within the bound is never further away than this
    if energy > lane.bound:
        for d in range(3):
            lane.newton[d] *= np.sqrt(lane.bound / energy)


@compiled
def _aim_lane(lane, number, inverse, trial, rotation, variation):
    """Put the next shot into its lane, at the identity; an idle lane stays there."""
    for i in range(4):
        rotation[i, number] = 1.0 if i == 3 else 0.0
    for i in range(3):
        inverse[i, number] = 1.0 / lane.metric[i] if lane.problem >= 0 else 1.0
        trial[i, number] = lane.trial[i] if lane.problem >= 0 else 0.0
        for d in range(3):
            variation[3 * d + i, number] = 1.0 if d == i else 0.0


@compiled
def shoot(moments, vector, start, may_follow, trusted, momentum, residual, status, shots):
    """Find the momenta of geodesics from the identity to given rotations.

    Parameters
    ----------
    moments : array-like, shape=[n, 3]
    vector : array-like, shape=[n, 3]
        Rotation vectors of the targets, radians, shorter than 2 pi; one longer than pi asks for the long way round.
    start : array-like, shape=[n, 3]
        Momenta to start from; not a number: guess.
    may_follow : bool
        Whether to follow the metric from the bi-invariant one if Newton fails.
    trusted : float
        Miss in radians whose Newton step is not looked at again; what it leaves is of the order of its square.
    momentum : array-like, shape=[n, 3]
        Written, as are the next.
    residual : array-like, shape=[n]
        Miss of the end point, radians.
    status, shots : array-like of int, shape=[n]
    """
    n = len(moments)
    lanes = np.zeros(LANES, dtype=LANE)
    series = np.zeros((SERIES_ROWS, LANES))
    inverse, trial, rotation = np.ones((3, LANES)), np.zeros((3, LANES)), np.zeros((4, LANES))
    variation = np.zeros((9, LANES))
    time, tolerance = np.zeros((1, LANES)), np.ones((1, LANES))
    steps = np.zeros(LANES, dtype=np.int64)
    rotation[3] = 1.0
    upcoming, n_active = 0, 0
    for number in range(LANES):
        lanes[number].problem = -1
        time[0, number] = 1.0
    while True:
        for number in range(LANES):
            if time[0, number] < 1.0:
                continue
            lane = lanes[number]
            if lane.problem >= 0:
                outcome = _judge(lane, rotation, variation, number, may_follow, trusted)
                if outcome != _GO_ON:
                    p = lane.problem
                    status[p], residual[p], shots[p] = outcome, lane.base_miss, lane.shots
                    for i in range(3):
                        momentum[p, i] = lane.base[i]
                    lane.problem = -1
                    n_active -= 1
            if lane.problem < 0 and upcoming < n:
                _begin(lane, upcoming, moments[upcoming], vector[upcoming], start[upcoming])
                upcoming += 1
                n_active += 1
            time[0, number], steps[number] = 0.0, 0
            tolerance[0, number] = lane.tolerance if lane.problem >= 0 else 1.0
            _aim_lane(lane, number, inverse, trial, rotation, variation)
        if n_active == 0:
            return
        size = expand(series, inverse, trial, rotation)
        expand_variation(series, inverse, variation)
        step = minimum(step_size(size, load(tolerance, 0)), 1.0 - load(time, 0))
        q = evaluate(series, trial, rotation, step)
        for i in range(4):
            store(rotation, i, q[i])
        advance_variation(series, variation, step)
        store(time, 0, load(time, 0) + step)
        for number in range(LANES):
            steps[number] += 1
            if steps[number] >= _MAX_STEPS and time[0, number] < 1.0:
                # no miss is as large as one that is not a number
                time[0, number], rotation[3, number] = 1.0, np.nan
