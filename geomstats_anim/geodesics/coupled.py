r"""Geodesics of left-invariant metrics that couple the joints: one matrix Z, (3B, 3B), over the whole pose.

The momentum of each joint is constant in space, as for one rigid body, but velocities are coupled,
:math:`w = Z^{-1} (g_b^T m_b)_b`. With :math:`dg_b = g_b \hat x_b`, variations obey
:math:`x' = Z^{-1} (g^T dm + (g^T m) \times x) + x \times w`, whose 3B directions give Newton's method its Jacobian.
Dormand's and Prince's method of eighth order integrates both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from geomstats_anim import rotations as quat
from geomstats_anim.kernels.shooting import CONVERGED, MAX_ITERATIONS, STALLED
from geomstats_anim.rotations import Array

_TOLERANCE = 1e-12
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


class Shot(NamedTuple):
    """A geodesic from the identity to a given pose.

    Attributes
    ----------
    momentum : array-like, shape=[B, 3]
    status : int
    residual : float
        Largest miss of a joint, radians.
    shots : int
    """

    momentum: Array
    status: int
    residual: float
    shots: int


def flow(matrix: Array, momentum: Array, times: Array) -> Array:
    """Follow geodesics from the identity.

    Parameters
    ----------
    matrix : array-like, shape=[3B, 3B]
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
    inverse = np.asarray(np.linalg.inv(matrix), dtype=np.float64)

    def rates(_: float, state: Array) -> Array:
        q = state.reshape(n, n_joints, 4)
        body = quat.rotate(quat.conjugate(q), momentum)
        return _turning(q, _velocity(inverse, body)).ravel()

    start = np.tile(quat.IDENTITY, (n, n_joints, 1)).ravel()
    ends = _integrate(rates, start, times)
    return quat.normalize(np.moveaxis(ends.reshape(n, n_joints, 4, len(times)), -1, 1))


def join(matrix: Array, target: Array) -> Shot:
    """Find a geodesic from the identity to a pose: that which continuation from the bi-invariant metric leads to.

    Parameters
    ----------
    matrix : array-like, shape=[3B, 3B]
        Symmetric positive definite.
    target : array-like, shape=[B, 4]
        Unit quaternions.

    Returns
    -------
    shot : Shot
    """
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


def _newton(matrix: Array, target: Array, momentum: Array, wanted: float) -> Shot:
    """Shoot from a momentum, with steps that are halved where they do not shorten the miss."""
    direct = quat.log(target).ravel()
    bound = _SLACK * direct @ matrix @ direct
    inverse = np.linalg.inv(matrix)
    energy = momentum.ravel() @ inverse @ momentum.ravel()
    if energy > bound:
        momentum = momentum * np.sqrt(bound / energy)
    miss, jacobian = _look(matrix, target, momentum)
    for shots in range(1, _MAX_SHOTS + 1):
        length = float(np.linalg.norm(miss))
        if np.abs(miss).max() <= wanted:
            return Shot(momentum, CONVERGED, float(np.linalg.norm(miss, axis=-1).max()), shots)
        step = np.linalg.lstsq(jacobian, miss.ravel())[0].reshape(momentum.shape)
        for halving in range(_HALVINGS):
            trial = momentum + 0.5**halving * step
            if trial.ravel() @ inverse @ trial.ravel() > bound:
                continue
            trial_miss, trial_jacobian = _look(matrix, target, trial)
            if np.linalg.norm(trial_miss) < length:
                break
        else:
            break
        momentum, miss, jacobian = trial, trial_miss, trial_jacobian
    return Shot(momentum, STALLED, float(np.linalg.norm(miss, axis=-1).max()), _MAX_SHOTS)


def _look(matrix: Array, target: Array, momentum: Array) -> tuple[Array, Array]:
    """Return the rotation vectors from the end to the target, and the derivative of the end by the momentum."""
    n_joints = len(momentum)
    inverse = np.linalg.inv(matrix)
    size, split = 3 * n_joints, 4 * n_joints
    joint = np.arange(n_joints)

    def rates(_: float, state: Array) -> Array:
        q, x = state[:split].reshape(n_joints, 4), state[split:].reshape(size, n_joints, 3)
        back = np.swapaxes(quat.to_matrix(q), -1, -2)
        body = (back @ momentum[..., None])[..., 0]
        velocity = (inverse @ body.ravel()).reshape(n_joints, 3)
        changed = np.cross(body, x)
        # the momentum of direction 3 b + i is e_i of joint b
        changed.reshape(n_joints, 3, n_joints, 3)[joint, :, joint] += np.swapaxes(back, -1, -2)
        moved = (changed.reshape(size, size) @ inverse).reshape(x.shape) + np.cross(x, velocity)
        return np.concatenate([_turning(q, velocity).ravel(), moved.ravel()])

    start = np.concatenate([np.tile(quat.IDENTITY, n_joints), np.zeros(size * size)])
    end = _integrate(rates, start, np.ones(1))[:, 0]
    reached = quat.normalize(end[:split].reshape(n_joints, 4))
    return quat.log(quat.multiply(quat.conjugate(reached), target)), end[split:].reshape(size, size).T


def _velocity(inverse: Array, body: Array) -> Array:
    return (body.reshape(len(body), -1) @ inverse).reshape(body.shape)


def _turning(q: Array, velocity: Array) -> Array:
    """Return the rate of quaternions that turn with a body velocity; those that are too long or short are mended."""
    rate = 0.5 * quat.multiply(q, np.concatenate([velocity, np.zeros((*velocity.shape[:-1], 1))], axis=-1))
    return rate + q * (1.0 - (q**2).sum(axis=-1, keepdims=True))


def _integrate(rates: object, start: Array, times: Array) -> Array:
    """Return states, shape=[size, T], at increasing times."""
    solution = solve_ivp(
        rates, (0.0, max(float(times[-1]), 1e-300)), start, "DOP853", times, rtol=_TOLERANCE, atol=_TOLERANCE
    )
    return np.asarray(solution.y)
