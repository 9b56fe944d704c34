"""Metrics, rotations and tangent vectors that the laws of metrics are tested with."""

import numpy as np
from geomstats.geometry.invariant_metric import _InvariantMetricMatrix
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from scipy.spatial.transform import Rotation

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric

DIAGONAL = np.diag([1.0, 3.0, 0.4])
FULL = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])
MATRICES = [np.eye(3), DIAGONAL, FULL]
SIDES = [True, False]
POSE_PARAMETERS = MetricParameters(
    [2.0, 1.0, 5.0],
    [0.5, 1.0, 3.0],
    axes=[[0.1, 0.2, 0.3], [0.0, 0.0, 0.0], [1.0, -0.5, 0.2]],
    invariance=("left", "right", "right"),
)


def so3(matrix=FULL, left=True):
    space = SpecialOrthogonal(3, equip=False)
    return space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=matrix, left=left)


def stock(matrix, left):
    return SpecialOrthogonal(3, equip=False).equip_with_metric(
        _InvariantMetricMatrix, metric_mat_at_identity=matrix, left=left
    )


def pose_space():
    return PoseSpace(3).equip_with_metric(PoseMetric, parameters=POSE_PARAMETERS)


def rotations(rng, *shape):
    return Rotation.random(int(np.prod(shape)), rng).as_matrix().reshape(*shape, 3, 3)


def hat(vector):
    return -np.cross(np.asarray(vector)[..., None, :], np.eye(3))


def tangent(point, velocity, left=True):
    return point @ hat(velocity) if left else hat(velocity) @ point
