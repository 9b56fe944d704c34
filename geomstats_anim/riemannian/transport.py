"""Parallel transport along geodesics from the identity.

In an orthonormal invariant frame the transport is a rotation, with the velocity of the geodesic times rates that are
constant along it (Milnor, "Curvatures of left invariant metrics on Lie groups", 1976, section 4). Steps of Magnus'
method of fourth order integrate it, so that it keeps inner products exactly.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

_GAUSS_NODES = 0.5 + np.array([-1.0, 1.0]) * np.sqrt(3.0) / 6.0
"""Of a step, where Magnus' method evaluates the velocity."""


def transport(parameters: MetricParameters, velocity: Array, vector: Array, n_steps: int) -> tuple[Array, Array]:
    """Transport vectors along the geodesics that leave the identity.

    Parameters
    ----------
    parameters : MetricParameters
    velocity : array-like, shape=[n, B, 3]
        Of the geodesics at the start, in the frame where the metric is constant.
    vector : array-like, shape=[n, B, 3]
        What to transport, in that frame.
    n_steps : int

    Returns
    -------
    turn : array-like, shape=[n, B, 4]
        Where the geodesics end.
    transported : array-like, shape=[n, B, 3]
        In the frame where the metric is constant.
    """
    n, n_joints = velocity.shape[:2]
    times = np.append((np.arange(n_steps)[:, None] + _GAUSS_NODES) / n_steps, 1.0)
    geodesics = PoseGeodesics(np.tile(quat.IDENTITY, (n, n_joints, 1)), velocity, parameters)
    turned = geodesics(np.repeat(np.arange(n), len(times)), np.tile(times, n)).reshape(n, len(times), n_joints, 4)

    frame = np.broadcast_to(quat.IDENTITY, (n, n_joints, 4))
    for step in np.moveaxis(_magnus_steps(parameters, velocity, turned[:, :-1]), 1, 0):
        frame = quat.multiply(step, frame)
    axes, root = parameters.axes_quaternions, np.sqrt(parameters.moments)
    transported = quat.rotate(frame, root * quat.rotate(axes, vector)) / root
    return turned[:, -1], quat.rotate(quat.conjugate(axes), transported)


def _magnus_steps(parameters: MetricParameters, velocity: Array, turned: Array) -> Array:
    """Return the rotations of the orthonormal frame in each step, shape=[n, n_steps, B, 4]; turned: at Gauss nodes."""
    is_right, moments = parameters.is_right[:, None], parameters.moments
    # the momentum is constant in space if the metric is left-invariant, and in the body if it is right-invariant
    momentum = (parameters.matrices @ velocity[..., None])[..., 0]
    towards = np.where(is_right, turned, quat.conjugate(turned))
    principal = quat.rotate(parameters.axes_quaternions, quat.rotate(towards, momentum[:, None])) / moments
    sums = 0.5 * moments.sum(axis=-1, keepdims=True) - moments
    rates = sums * np.sqrt(moments / moments.prod(axis=-1, keepdims=True))
    n_steps = turned.shape[1] // 2
    spin = np.where(is_right, rates, -rates) * principal / n_steps
    early, late = spin[:, ::2], spin[:, 1::2]
    return quat.exp(0.5 * (early + late) + np.sqrt(3.0) / 12.0 * quat.cross(late, early))
