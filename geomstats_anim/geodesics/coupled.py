r"""Geodesics of left-invariant metrics that couple the joints: one matrix Z, (3B, 3B), over the whole pose.

The momentum of each joint is constant in space, as for one rigid body, but velocities are coupled,
:math:`w = C (g_b^T m_b)_b` with the cometric :math:`C = Z^{-1}`. With :math:`dg_b = g_b \hat x_b`, variations obey
:math:`x' = C (g^T dm + (g^T m) \times x) + x \times w`, whose 3B directions give Newton's method its Jacobian.
Dormand's and Prince's method of eighth order integrates both. Joints that are not coupled, not even through others, are
solved apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.kernels.shooting import CONVERGED, MAX_ITERATIONS, STALLED
from geomstats_anim.rotations import Array

_TOLERANCE = 1e-12
_JACOBIAN_TOLERANCE = 1e-9
_MISS = 1e-10
"""Largest miss, in radians, of an end point that counts as reached."""

_MISS_ON_THE_WAY = 1e-3
_MAX_SHOTS = 12
_MAX_SHOTS_IN_ALL = 150
_HALVINGS = 6
_SLACK = 1.2
"""Largest energy of an iterate, as a multiple of the bi-invariant geodesic's, which bounds the shortest's."""

_SMALLEST_STEP = 1.0 / 64.0
"""Of the continuation in the metric."""

_AT_ONCE = 4_000_000
"""Numbers of variations that are integrated at once."""


class Shots(NamedTuple):
    """Geodesics from the identity to given poses.

    Attributes
    ----------
    momentum : array-like, shape=[n, B, 3]
    status : array-like of int, shape=[n, B]
        The same for all joints that are coupled.
    residual : array-like, shape=[n, B]
        Largest miss of the joints that are coupled, radians.
    shots : array-like of int, shape=[n, B]
    """

    momentum: Array
    status: np.ndarray
    residual: Array
    shots: np.ndarray


class _Shot(NamedTuple):
    momentum: Array
    status: int
    residual: float
    shots: int


def components(cometric: Array) -> list[np.ndarray]:
    """Return the indices of joints that are coupled, directly or through others, for each group of them."""
    from scipy.sparse.csgraph import connected_components

    n_joints = len(cometric) // 3
    couples = (cometric.reshape(n_joints, 3, n_joints, 3) != 0.0).any(axis=(1, 3))
    count, label = connected_components(couples, directed=False)
    return [np.flatnonzero(label == each) for each in range(count)]


def block(cometric: Array, joints: np.ndarray) -> Array:
    """Take the rows and columns of some joints, by their indices, shape=[3J, 3J]."""
    rows = (3 * joints[:, None] + np.arange(3)).ravel()
    return np.asarray(cometric[np.ix_(rows, rows)])


def flow(cometric: Array, momentum: Array, times: Array) -> Array:
    """Follow geodesics from the identity.

    Parameters
    ----------
    cometric : array-like, shape=[3B, 3B]
        Symmetric positive definite.
    momentum : array-like, shape=[n, B, 3]
    times : array-like, shape=[T]
        Increasing, from 0 on.

    Returns
    -------
    rotations : array-like, shape=[n, T, B, 4]
        Unit quaternions.
    """
    n, n_joints = momentum.shape[:2]
    if not len(times) or not n:
        return np.zeros((n, len(times), n_joints, 4))

    def rates(_: float, state: Array) -> Array:
        q = state.reshape(n, n_joints, 4)
        body = quat.rotate(quat.conjugate(q), momentum)
        return _turning(q, _coupled(cometric, body)).ravel()

    start = np.tile(quat.IDENTITY, (n, n_joints, 1)).ravel()
    ends = _integrate(rates, start, times, _TOLERANCE)
    return quat.normalize(np.moveaxis(ends.reshape(n, n_joints, 4, len(times)), -1, 1))


def variations(cometric: Array, momentum: Array, times: Array) -> Array:
    """Differentiate geodesics from the identity by their momentum.

    Parameters
    ----------
    cometric : array-like, shape=[3B, 3B]
    momentum : array-like, shape=[n, B, 3]
    times : array-like, shape=[T]
        Increasing, from 0 on.

    Returns
    -------
    varied : array-like, shape=[n, T, 3B, 3B]
        Body variations of the rotations, in the rows, by the momentum.
    """
    n, n_joints = momentum.shape[:2]
    size, split = 3 * n_joints, 4 * n * n_joints
    at_once = max(1, _AT_ONCE // max(1, size * size * len(times)))
    if n > at_once:
        parts = [momentum[first : first + at_once] for first in range(0, n, at_once)]
        return np.concatenate([variations(cometric, part, times) for part in parts])
    joint = np.arange(n_joints)

    def rates(_: float, state: Array) -> Array:
        q, x = state[:split].reshape(n, n_joints, 4), state[split:].reshape(n, size, n_joints, 3)
        back = np.swapaxes(quat.to_matrix(q), -1, -2)
        body = (back @ momentum[..., None])[..., 0]
        velocity = _coupled(cometric, body)
        changed = quat.cross(body[:, None], x)
        # row 3 b + i is the momentum e_i of joint b
        changed.reshape(n, n_joints, 3, n_joints, 3)[:, joint, :, joint] += np.moveaxis(np.swapaxes(back, -1, -2), 1, 0)
        moved = (changed.reshape(-1, size) @ cometric).reshape(x.shape) + quat.cross(x, velocity[:, None])
        return np.concatenate([_turning(q, velocity).ravel(), moved.ravel()])

    start = np.concatenate([np.tile(quat.IDENTITY, n * n_joints), np.zeros(n * size * size)])
    ends = _integrate(rates, start, times, _JACOBIAN_TOLERANCE)[split:]
    return np.moveaxis(ends.reshape(n, size, size, len(times)), (3, 2), (1, 2))


def shoot(cometric: Array, target: Array, near: Array | None = None, effort: Effort = "thorough") -> Shots:
    """Find geodesics from the identity to poses.

    Newton's method starts at a similar geodesic, or at the bi-invariant one; where it does not arrive, the geodesic is
    the one that continuation from the bi-invariant metric leads to.

    Parameters
    ----------
    cometric : array-like, shape=[3B, 3B]
        Symmetric positive definite.
    target : array-like, shape=[n, B, 4]
        Unit quaternions.
    near : array-like, shape=[n, B, 3]
        Velocities of geodesics of a similar metric; not a number where none is known.
        Optional, default: None.
    effort : str
        "thorough", or "quick", for learning: without the continuation.
        Optional, default: "thorough".

    Returns
    -------
    shots : Shots
    """
    shape = target.shape[:2]
    found = Shots(
        np.zeros((*shape, 3)), np.zeros(shape, dtype=np.intp), np.zeros(shape), np.zeros(shape, dtype=np.intp)
    )
    for joints in components(cometric):
        velocity = None if near is None else near[:, joints]
        part = _shoot_together(block(cometric, joints), target[:, joints], velocity, effort)
        for values, mine in zip(found, part, strict=True):
            values[:, joints] = mine
    return found


def _shoot_together(cometric: Array, target: Array, near: Array | None, effort: Effort) -> Shots:
    """Find geodesics of joints that are coupled."""
    vector = quat.log(target)
    n, n_joints = vector.shape[:2]
    matrix = _inverse(cometric)
    guess = vector if near is None else np.where(np.isfinite(near).all(axis=(1, 2), keepdims=True), near, vector)
    momentum, residual = _coupled(matrix, guess), np.full(n, np.inf)
    shots = np.zeros(n, dtype=np.intp)
    largest = _SLACK * _energy(matrix, vector)
    for _ in range(_MAX_SHOTS):
        left = np.flatnonzero(residual > _MISS)
        if not len(left):
            break
        ends = flow(cometric, momentum[left], np.ones(1))[:, 0]
        miss = quat.log(quat.multiply(quat.conjugate(ends), target[left]))
        before, residual[left] = residual[left], np.linalg.norm(miss, axis=-1).max(axis=-1)
        shots[left] += 1
        # what does not come nearer, or goes far away, is left to the continuation
        hopeful = (residual[left] < before) & (_energy(cometric, momentum[left]) <= largest[left] + _MISS**2)
        left, miss = left[hopeful], miss[hopeful]
        going_on = residual[left] > _MISS
        left, miss = left[going_on], miss[going_on]
        if not len(left):
            break
        jacobian = variations(cometric, momentum[left], np.ones(1))[:, 0]
        step = np.linalg.solve(jacobian, miss.reshape(len(left), -1, 1))
        momentum[left] += step.reshape(miss.shape)
    status = np.zeros(n, dtype=np.intp)
    is_long = _energy(cometric, momentum) > largest + _MISS**2
    failed = (residual > _MISS) | is_long | ~np.isfinite(residual)
    status[failed] = STALLED
    for number in np.flatnonzero(failed) if effort == "thorough" else ():
        shot = _continue(matrix, target[number])
        momentum[number], status[number], residual[number] = shot.momentum, shot.status, shot.residual
        shots[number] += shot.shots
    repeated = (np.repeat(values[:, None], n_joints, axis=1) for values in (status, residual, shots))
    return Shots(momentum, *repeated)


def _continue(matrix: Array, target: Array) -> _Shot:
    """Find the geodesic to one pose, shape=[B, 4], that continuation from the bi-invariant metric leads to."""
    values, vectors = np.linalg.eigh(matrix)
    scale = float(np.exp(np.log(values).mean()))

    def along(tau: float) -> Array:
        return (vectors * (scale * (values / scale) ** tau)) @ vectors.T

    velocity, tau, step, shots = quat.log(target), 0.0, 1.0, 0
    while True:
        ahead = along(tau + step)
        guess = (ahead @ velocity.ravel()).reshape(velocity.shape)
        is_end = tau + step >= 1.0
        found = _newton(ahead, target, guess, _MISS if is_end else _MISS_ON_THE_WAY)
        shots += found.shots
        if found.status == CONVERGED:
            if is_end:
                return found._replace(shots=shots)
            tau, step = tau + step, min(2.0 * step, 1.0 - tau - step)
            velocity = np.reshape(np.linalg.solve(ahead, found.momentum.ravel()), velocity.shape).astype(np.float64)
        else:
            step = min(0.5 * step, 0.25)
            if shots > _MAX_SHOTS_IN_ALL:
                return found._replace(shots=shots, status=MAX_ITERATIONS)
            if step < _SMALLEST_STEP:
                return found._replace(shots=shots)


def _newton(matrix: Array, target: Array, momentum: Array, wanted: float) -> _Shot:
    """Shoot from a momentum, with steps that are halved where they do not shorten the miss."""
    cometric, bound = _inverse(matrix), _SLACK * float(_energy(matrix, quat.log(target)))
    energy = float(_energy(cometric, momentum))
    if energy > bound:
        momentum = momentum * np.sqrt(bound / energy)

    def missed(momentum: Array) -> Array:
        end = flow(cometric, momentum[None], np.ones(1))[0, 0]
        return quat.log(quat.multiply(quat.conjugate(end), target))

    miss = missed(momentum)
    for shots in range(1, _MAX_SHOTS + 1):
        length = float(np.linalg.norm(miss))
        if np.abs(miss).max() <= wanted:
            return _Shot(momentum, CONVERGED, float(np.linalg.norm(miss, axis=-1).max()), shots)
        jacobian = variations(cometric, momentum[None], np.ones(1))[0, 0]
        step = np.linalg.lstsq(jacobian, miss.ravel())[0].reshape(momentum.shape)
        for halving in range(_HALVINGS):
            trial = momentum + 0.5**halving * step
            if _energy(cometric, trial) > bound:
                continue
            trial_miss = missed(trial)
            if np.linalg.norm(trial_miss) < length:
                break
        else:
            break
        momentum, miss = trial, trial_miss
    return _Shot(momentum, STALLED, float(np.linalg.norm(miss, axis=-1).max()), _MAX_SHOTS)


def _inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _energy(matrix: Array, vectors: Array) -> Array:
    """Return the squared lengths, shape=[...], of vectors, shape=[..., B, 3]."""
    return np.asarray((vectors * _coupled(matrix, vectors)).sum(axis=(-2, -1)))


def _coupled(matrix: Array, vectors: Array) -> Array:
    """Multiply a symmetric matrix, shape=[3B, 3B], by vectors, shape=[..., B, 3]."""
    return np.asarray((vectors.reshape(*vectors.shape[:-2], -1) @ matrix).reshape(vectors.shape))


def _turning(q: Array, velocity: Array) -> Array:
    """Return the rate of quaternions that turn with a body velocity; those that are too long or short are mended."""
    rate = 0.5 * quat.multiply(q, np.concatenate([velocity, np.zeros((*velocity.shape[:-1], 1))], axis=-1))
    return rate + q * (1.0 - (q**2).sum(axis=-1, keepdims=True))


def _integrate(rates: object, start: Array, times: Array, tolerance: float) -> Array:
    """Return states, shape=[size, T], at increasing times."""
    from scipy.integrate import solve_ivp

    solution = solve_ivp(
        rates, (0.0, max(float(times[-1]), 1e-300)), start, "DOP853", times, rtol=tolerance, atol=tolerance
    )
    return np.asarray(solution.y)
