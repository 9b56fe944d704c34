"""Random problems for the tests and the benchmarks, always from a seed."""

import numpy as np

from geomstats_anim import Animation, MetricParameters, Skeleton
from geomstats_anim import rotations as quat
from geomstats_anim.kernels.rigid_body import playback
from geomstats_anim.kernels.shooting import CONVERGED, shoot


def unit_vectors(rng, n):
    """Directions, shape=[n, 3], uniform on the sphere."""
    vectors = rng.normal(size=(n, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def quaternions(rng, *shape):
    """Rotations, shape=[*shape, 4], uniform."""
    return quat.normalize(rng.normal(size=(*shape, 4)))


def moments(rng, n, condition):
    """Principal moments, shape=[n, 3]: condition number log-uniform up to `condition`, the middle one anywhere."""
    largest = condition ** rng.uniform(size=n)
    return rng.permuted(np.stack([np.ones(n), largest ** rng.uniform(size=n), largest], axis=-1), axis=1)


def gaps(rng, n, low, high):
    """Rotation vectors, shape=[n, 3], about any axis, by `low` to `high` degrees."""
    return np.deg2rad(rng.uniform(low, high, n))[:, None] * unit_vectors(rng, n)


def parameters(rng, n, condition, full=False, invariance=None):
    """Metric parameters of n joints; each left or right, at random, if no invariance is given."""
    first, alpha, beta = moments(rng, n, condition).T
    axes = gaps(rng, n, 0.0, 180.0) if full else None
    sides = invariance or tuple(rng.choice(["left", "right"], n))
    return MetricParameters(alpha / first, beta / first, axes, sides)


def moved(parameters, direction, step):
    """Move all joints' log alpha, log beta, or axes, the last by a turn from the left."""
    log_moments, turn = np.log(parameters.moments[:, 1:]), np.zeros(3)
    if direction < 2:
        log_moments[:, direction] += step
    else:
        turn[direction - 2] = step
    axes = quat.log(quat.multiply(quat.exp(turn), parameters.axes_quaternions))
    return MetricParameters(*np.exp(log_moments).T, axes, parameters.invariance)


def flow(inertia, momentum, parameter=1.0):
    """End points, unit quaternions of shape=[n, 4], of geodesics from the identity."""
    index, out = np.arange(len(inertia)), np.empty((len(inertia), 1, 4))
    playback(1.0 / inertia, momentum, index, index + 1, np.full(len(inertia), parameter), 0 * index, out)
    return out[:, 0]


def best_of_random_starts(rng, inertia, vector, n_starts):
    """Squared lengths of the shortest geodesics that shooting finds from random momenta in the energy ball.

    Half of the starts go the short way round, half the long way. Infinite where no start converges.
    """
    n = len(inertia)
    long_way = vector * (1.0 - 2.0 * np.pi / np.linalg.norm(vector, axis=-1, keepdims=True))
    energy = np.minimum((inertia * vector**2).sum(-1), (inertia * long_way**2).sum(-1))
    best = np.full(n, np.inf)
    for start in range(n_starts):
        radius = np.sqrt(energy) * rng.uniform(size=n) ** (1.0 / 3.0)
        trial = np.sqrt(inertia) * radius[:, None] * unit_vectors(rng, n)
        momentum, residual = np.zeros((n, 3)), np.zeros(n)
        status, shots = np.zeros(n, dtype=np.intp), np.zeros(n, dtype=np.intp)
        way = np.ascontiguousarray(long_way if start % 2 else vector)
        shoot(inertia, way, trial, False, 0.0, momentum, residual, status, shots)
        best = np.where(status == CONVERGED, np.minimum(best, (momentum**2 / inertia).sum(-1)), best)
    return best


def skeleton(n_joints):
    """A chain."""
    return Skeleton(
        [f"joint{i}" for i in range(n_joints)],
        np.arange(n_joints) - 1,
        np.tile([0.0, 0.1, 0.0], (n_joints, 1)),
        np.tile(quat.IDENTITY, (n_joints, 1)),
    )


def animation(rng, n_frames, n_joints, step=30.0, scales=False):
    """Motion at uneven times, whose joints turn by `step` degrees about any axis from frame to frame."""
    turns = quat.exp(gaps(rng, n_frames * n_joints, step, step).reshape(n_frames, n_joints, 3))
    rotations = [quaternions(rng, n_joints)]
    for turn in turns[1:]:
        rotations.append(quat.multiply(rotations[-1], turn))
    return Animation(
        skeleton(n_joints),
        np.cumsum(rng.uniform(0.1, 1.0, n_frames)),
        np.array(rotations),
        rng.normal(size=(n_frames, n_joints, 3)),
        rng.uniform(0.5, 2.0, (n_frames, n_joints, 3)) if scales else None,
    )
