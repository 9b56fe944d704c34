"""Laws of continuous Euler angles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geomstats_anim import rotations as quat
from geomstats_anim.euler import ORDERS, from_euler, to_euler


@pytest.mark.parametrize("order", ORDERS)
def test_angles_are_those_of_scipy_and_back(order):
    rotations = quat.normalize(np.random.default_rng(0).normal(size=(1, 500, 4)))
    angles = to_euler(rotations, order)
    np.testing.assert_allclose(angles[0], Rotation.from_quat(rotations[0]).as_euler(order), atol=1e-9)
    assert quat.distance(from_euler(angles, order), rotations).max() < 1e-14


@pytest.mark.parametrize("order", ORDERS)
def test_no_angle_jumps_where_the_rotation_does_not(order):
    """Angles that lead through several turns, and through the lock, come back as they were, up to a common name."""
    t = np.linspace(0.0, 6.0, 2001)
    angles = np.stack([9.0 * np.sin(t), 2.0 * t, 5.0 * t], axis=-1)  # the second passes a quarter turn 7 times
    found = to_euler(from_euler(angles, order), order)
    np.testing.assert_allclose(found, angles, atol=1e-6)
    assert np.abs(np.diff(found, axis=0)).max() < 0.1


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("quarter", [-np.pi / 2, np.pi / 2])
def test_in_the_lock_the_third_angle_stays(order, quarter):
    t = np.linspace(0.0, 1.0, 11)
    angles = np.stack([0.3 + t, np.where(t < 0.35, 0.7, quarter), np.full(11, -1.1)], axis=-1)
    rotations = from_euler(angles, order)
    found = to_euler(rotations, order)
    assert quat.distance(from_euler(found, order), rotations).max() < 2e-6
    np.testing.assert_allclose(found[4:, 2], -1.1, atol=1e-6)
    locked = to_euler(rotations[4:], order)
    assert quat.distance(from_euler(locked, order), rotations[4:]).max() < 2e-6
    assert (locked[:, 2] == 0.0).all()


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("n_turns", [0, 1, 2])
def test_fewer_turns_leave_the_other_angles_at_zero(order, n_turns):
    angles = np.random.default_rng(2).uniform(-3.0, 3.0, (300, 3)) * (np.arange(3) < n_turns)
    rotations = from_euler(angles, order)
    found = to_euler(rotations, order, n_turns)
    assert np.abs(found[:, n_turns:]).max() < 1e-12
    assert quat.distance(from_euler(found, order), rotations).max() < 1e-14
    assert np.abs(np.diff(found, axis=0)).max() <= np.pi


def test_many_joints_and_an_order_that_is_none():
    rotations = quat.normalize(np.random.default_rng(1).normal(size=(7, 3, 2, 4)))
    np.testing.assert_array_equal(to_euler(rotations, "ZXY")[:, 1, 0], to_euler(rotations[:, 1, 0], "ZXY"))
    with pytest.raises(ValueError, match="order must be one of XYZ"):
        to_euler(rotations, "XYX")
