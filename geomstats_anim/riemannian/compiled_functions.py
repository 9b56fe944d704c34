"""Exponential and logarithm on NumPy arrays of poses, as functions of the numbers of the metric as well."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.failures import raise_failures
from geomstats_anim.riemannian.matrices import PoseMatrices
from geomstats_anim.rotations import Array

Invariance = str | Sequence[str]


def metric_of(alpha: Any, beta: Any, axes: Any, invariance: Invariance) -> MetricParameters:
    """Return the parameters of numbers that an automatic differentiation follows."""
    return MetricParameters(alpha, beta, axes, tuple(np.atleast_1d(invariance)))


def exp(tangent_vec: Any, base_point: Any, parameters: MetricParameters) -> Array:
    """Return the ends, shape=[..., B, 3, 3], of geodesics."""
    arrays = PoseMatrices((parameters.n_joints, 3, 3), parameters)
    base = arrays.read_points(base_point, "base_point")
    velocity = arrays.read_velocities(tangent_vec, base, "tangent_vec")
    batch = velocity.shape[:-2]
    geodesics = PoseGeodesics(mat.flat(base, batch, 2), mat.flat(velocity, batch, 2), parameters)
    n = len(geodesics.initial)
    return quat.to_matrix(geodesics(np.arange(n), np.ones(n))).reshape(*batch, -1, 3, 3)


def log(point: Any, base_point: Any, parameters: MetricParameters) -> Array:
    """Return the velocities, shape=[..., B, 3, 3], of the shortest geodesics.

    Raises
    ------
    RuntimeError
        If no geodesic was found for an element.
    """
    arrays = PoseMatrices((parameters.n_joints, 3, 3), parameters)
    base, end = arrays.read_points(base_point, "base_point"), arrays.read_points(point, "point")
    batch = np.broadcast_shapes(base.shape, end.shape)[:-2]
    geodesics = PoseGeodesics.between(mat.flat(base, batch, 2), mat.flat(end, batch, 2), parameters)
    raise_failures(geodesics.status, batch + arrays.per_joint)
    return arrays.tangent_vecs(geodesics.velocity, geodesics.initial, batch)


def squared_dist(tangent_vec: Array, base_point: Any, parameters: MetricParameters) -> Array:
    """Return the squared lengths, shape=[...], of tangent vectors."""
    arrays = PoseMatrices((parameters.n_joints, 3, 3), parameters)
    velocity = arrays.read_velocities(tangent_vec, arrays.read_points(base_point, "base_point"), "tangent_vec")
    along = parameters.along_axes(velocity)
    return 2.0 * (parameters.moments * along**2).sum(axis=(-2, -1))
