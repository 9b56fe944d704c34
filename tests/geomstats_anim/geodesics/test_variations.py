"""Derivatives of geodesics against differences of geodesics."""

import numpy as np
import pytest
import samples

from geomstats_anim import MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.exponential import left_jacobian
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics

TIMES = np.array([0.0, 0.3, 1.0, 2.5])
STEP = 1e-5


@pytest.fixture(params=[1.0, 0.0, 1e-9], ids=["fast", "still", "creeping"])
def speed(request):
    return request.param


def problem(speed, n_joints=12, full=True):
    rng = np.random.default_rng(3)
    parameters = samples.parameters(rng, n_joints, 20.0, full)
    return parameters, samples.quaternions(rng, 1, n_joints), speed * rng.normal(size=(1, n_joints, 3)), rng


def poses(parameters, initial, velocity):
    return PoseGeodesics(initial, velocity, parameters)(np.zeros(len(TIMES), dtype=int), TIMES)


def moved_pose(pose, vector, parameters):
    turn = np.broadcast_to(quat.exp(vector), pose.shape)
    return np.where(parameters.is_right[:, None], quat.multiply(turn, pose), quat.multiply(pose, turn))


def difference(parameters, ahead, behind):
    """Return half the turn from one pose to the other, in the frame where the metric is constant."""
    right = quat.log(quat.multiply(ahead, quat.conjugate(behind)))
    left = quat.log(quat.multiply(quat.conjugate(behind), ahead))
    return np.where(parameters.is_right[:, None], right, left) / (2.0 * STEP)


def test_variations_are_differences(speed):
    parameters, initial, velocity, _ = problem(speed)
    index = np.zeros(len(TIMES), dtype=int)
    found = PoseGeodesics(initial, velocity, parameters).variations(index, TIMES)
    for i, unit in enumerate(STEP * np.eye(3)):
        ends = [poses(parameters, moved_pose(initial, s * unit, parameters), velocity) for s in (1.0, -1.0)]
        np.testing.assert_allclose(found.by_initial[..., i], difference(parameters, *ends), atol=1e-8)
        ends = [poses(parameters, initial, velocity + s * unit) for s in (1.0, -1.0)]
        np.testing.assert_allclose(found.by_velocity[..., i], difference(parameters, *ends), atol=1e-7)
    for d in range(5):
        ends = [poses(samples.moved(parameters, d, s * STEP), initial, velocity) for s in (1.0, -1.0)]
        np.testing.assert_allclose(found.by_metric[..., d], difference(parameters, *ends), atol=1e-7)


def test_the_variation_along_the_velocity_is_the_geodesic_itself():
    parameters, initial, velocity, _ = problem(2.0)
    geodesics = PoseGeodesics(initial, velocity, parameters)
    found = geodesics.variations(np.zeros(len(TIMES), dtype=int), TIMES)
    # faster by a share, it is further by that share of the way: w(t) t
    along = np.einsum("fbij,bj->fbi", found.by_velocity, velocity[0])
    momentum = (parameters.matrices @ velocity[0][..., None])[..., 0]
    carried = np.einsum("fbij,bj->fbi", found.by_initial, momentum)
    # momentum is constant in the fixed frame: in the moving one it is turned back
    now = np.linalg.solve(parameters.matrices, carried[..., None])[..., 0]
    np.testing.assert_allclose(along, TIMES[:, None, None] * now, atol=1e-11)


def test_a_batch_is_its_parts():
    rng = np.random.default_rng(5)
    parameters = samples.parameters(rng, 3, 5.0, True)
    geodesics = PoseGeodesics(samples.quaternions(rng, 4, 3), rng.normal(size=(4, 3, 3)), parameters)
    index, times = np.array([0, 0, 2, 3, 3]), np.array([0.1, 0.7, 0.5, 0.0, 1.5])
    whole = geodesics.variations(index, times)
    for f in range(len(index)):
        alone = PoseGeodesics(geodesics.initial[index[f]][None], geodesics.velocity[index[f]][None], parameters)
        for mine, other in zip(whole, alone.variations(np.zeros(1, dtype=int), times[f : f + 1]), strict=True):
            np.testing.assert_allclose(mine[f], other[0], atol=1e-12)


def test_the_bi_invariant_metric_varies_as_the_exponential():
    rng = np.random.default_rng(6)
    velocity = rng.normal(size=(1, 4, 3))
    identity = MetricParameters.identity(4)
    geodesics = PoseGeodesics(np.tile(quat.IDENTITY, (1, 4, 1)), velocity, identity)
    found = geodesics.variations(np.zeros(1, dtype=int), np.ones(1))
    np.testing.assert_allclose(found.by_velocity, np.moveaxis(left_jacobian(velocity), -1, -2), atol=1e-13)
