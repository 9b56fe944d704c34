"""The flow against oracles that share nothing with it, and its conserved quantities."""

import numpy as np
import oracles
import pytest
import samples

from geomstats_anim import rotations as quat
from geomstats_anim.kernels.rigid_body import playback

pytestmark = pytest.mark.filterwarnings("error")

BAR = 1e-10  # radians


def fast_turns(rng, inertia, turn=2.0 * np.pi):
    """Momenta whose rotation starts with up to `turn` radians per unit of time, about any axis."""
    velocity = turn * rng.uniform(size=len(inertia))[:, None] * samples.unit_vectors(rng, len(inertia))
    return inertia * velocity


def matrices(inertia, momentum, parameter=1.0):
    return quat.to_matrix(samples.flow(np.atleast_2d(inertia), np.atleast_2d(momentum), parameter))


@pytest.mark.parametrize("condition", [1.0, 4.0, 25.0, 100.0])
@pytest.mark.parametrize("oracle", ["momentum", "velocity"])
def test_flow_agrees_with_runge_kutta(condition, oracle):
    rng = np.random.default_rng(1)
    inertia = samples.moments(rng, 60, condition)
    momentum = fast_turns(rng, inertia)
    if oracle == "momentum":
        expected = oracles.momentum_form(inertia, momentum)[0]
    else:
        expected = oracles.velocity_form(inertia[:, :, None] * np.eye(3), momentum / inertia)[0][0]
    assert oracles.angle_between(matrices(inertia, momentum), expected).max() < BAR


def test_flow_agrees_with_the_elliptic_closed_form_at_condition_100():
    rng = np.random.default_rng(2)
    inertia = rng.permuted(np.stack([np.ones(8), 10.0 ** rng.uniform(0.2, 1.8, 8), np.full(8, 100.0)], 1), axis=1)
    momentum = fast_turns(rng, inertia)
    expected = [oracles.elliptic(*pair) for pair in zip(inertia, momentum, strict=True)]
    assert oracles.angle_between(matrices(inertia, momentum), expected).max() < 1e-12


@pytest.mark.parametrize("offset", [1e-3, 1e-5, 1e-7, 1e-9, 1e-12])
@pytest.mark.parametrize("inertia", [(1.0, 2.0, 3.0), (100.0, 1.0, 10.0)])
@pytest.mark.parametrize("towards", [0, 2])
def test_flow_near_the_separatrix(inertia, offset, towards):
    inertia = np.array(inertia)
    order = np.argsort(inertia)
    direction = np.zeros(3)
    direction[order[1]], direction[order[towards]] = 1.0, offset
    momentum = 2.0 * np.pi * inertia[order[1]] * direction
    expected = oracles.elliptic(inertia, momentum)
    # The motion itself leaves the middle axis exponentially: a rounding error of the momentum grows by up to
    # exp(18) = 6e7 at condition 100, more than any arithmetic in float64 can take back.
    light, middle, heavy = inertia[order]
    rate = 2.0 * np.pi * np.sqrt((middle - light) * (heavy - middle) / (light * heavy))
    error = oracles.angle_between(matrices(inertia, momentum)[0], expected)
    assert error < max(1e-13, np.finfo(float).eps * np.exp(rate))
    if inertia.max() < 100.0:
        assert error < 1e-13


def test_the_oracles_agree_with_one_another():
    rng = np.random.default_rng(3)
    inertia = samples.moments(rng, 5, 25.0)
    momentum = fast_turns(rng, inertia)
    exact = [oracles.elliptic(*pair) for pair in zip(inertia, momentum, strict=True)]
    velocity = oracles.velocity_form(inertia[:, :, None] * np.eye(3), momentum / inertia)[0][0]
    assert oracles.angle_between(oracles.momentum_form(inertia, momentum)[0], exact).max() < 1e-12
    assert oracles.angle_between(velocity, exact).max() < 1e-12


@pytest.mark.parametrize("odd_axis", [0, 1, 2])
@pytest.mark.parametrize("ratio", [0.01, 0.5, 1.0, 2.0, 100.0])
def test_two_or_three_equal_moments(odd_axis, ratio):
    rng = np.random.default_rng(4)
    inertia = np.ones(3)
    inertia[odd_axis] = ratio
    for momentum in fast_turns(rng, np.tile(inertia, (10, 1))):
        expected = oracles.two_equal_moments(inertia, momentum)
        assert oracles.angle_between(matrices(inertia, momentum)[0], expected) < 1e-12


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rotation_about_a_principal_axis_stays_there(axis, sign):
    inertia = np.array([1.0, 7.0, 100.0])
    velocity = sign * 2.0 * np.pi * 0.9 * np.eye(3)[axis]
    expected = oracles.two_equal_moments(np.ones(3), velocity)
    assert oracles.angle_between(matrices(inertia, inertia * velocity)[0], expected) < 1e-13


@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("offset", [1e-12, 1e-8, 1e-4])
def test_near_a_stable_principal_axis(axis, offset):
    inertia = np.array([1.0, 7.0, 100.0])
    direction = np.full(3, offset)
    direction[axis] = 1.0
    momentum = 2.0 * np.pi * inertia[axis] * direction
    assert oracles.angle_between(matrices(inertia, momentum)[0], oracles.elliptic(inertia, momentum)) < 1e-12


@pytest.mark.parametrize("condition", [1.0, 10.0, 100.0])
def test_energy_is_conserved(condition):
    rng = np.random.default_rng(5)
    inertia = samples.moments(rng, 5000, condition)
    momentum = fast_turns(rng, inertia)
    body = quat.rotate(quat.conjugate(samples.flow(inertia, momentum)), momentum)
    np.testing.assert_allclose((body**2 / inertia).sum(-1), (momentum**2 / inertia).sum(-1), rtol=1e-12)


@pytest.mark.parametrize("condition", [1.0, 10.0, 100.0])
def test_spatial_momentum_is_conserved(condition):
    # the body's velocity is integrated without the pose, so that the momentum is not constant by construction
    rng = np.random.default_rng(5)
    inertia = samples.moments(rng, 60, condition)
    momentum = fast_turns(rng, inertia)
    velocity = oracles.velocity_form(inertia[:, :, None] * np.eye(3), momentum / inertia)[1][0]
    shown = quat.rotate(samples.flow(inertia, momentum), inertia * velocity)
    assert (np.linalg.norm(shown - momentum, axis=-1) / np.linalg.norm(momentum, axis=-1)).max() < BAR


def test_poses_are_unit_and_orthogonal():
    rng = np.random.default_rng(6)
    inertia = samples.moments(rng, 5000, 100.0)
    pose = samples.flow(inertia, fast_turns(rng, inertia))
    assert np.abs(np.linalg.norm(pose, axis=-1) - 1.0).max() < 1e-15
    matrix = quat.to_matrix(pose)
    assert np.abs(matrix @ np.swapaxes(matrix, -1, -2) - np.eye(3)).max() < 1e-14


def test_the_flow_of_a_flow():
    rng = np.random.default_rng(7)
    inertia = samples.moments(rng, 500, 100.0)
    momentum = fast_turns(rng, inertia)
    half = samples.flow(inertia, momentum, 0.4)
    rest = samples.flow(inertia, quat.rotate(quat.conjugate(half), momentum), 0.6)
    assert quat.distance(quat.multiply(half, rest), samples.flow(inertia, momentum)).max() < 1e-12


def test_reversal():
    rng = np.random.default_rng(8)
    inertia = samples.moments(rng, 500, 100.0)
    momentum = fast_turns(rng, inertia)
    end = samples.flow(inertia, momentum)
    back = samples.flow(inertia, -quat.rotate(quat.conjugate(end), momentum))
    assert quat.distance(back, quat.conjugate(end)).max() < 1e-12


def test_time_and_momentum_scale_together():
    rng = np.random.default_rng(9)
    inertia = samples.moments(rng, 500, 100.0)
    momentum = fast_turns(rng, inertia)
    assert quat.distance(samples.flow(inertia, momentum, 0.3), samples.flow(inertia, 0.3 * momentum)).max() < 1e-12


def test_without_momentum_nothing_moves():
    np.testing.assert_array_equal(samples.flow(np.array([[1.0, 2.0, 3.0]]), np.zeros((1, 3))), [[0, 0, 0, 1]])


def test_dense_playback_equals_one_pose_at_a_time():
    rng = np.random.default_rng(10)
    n, n_samples = 21, 40
    inertia = samples.moments(rng, n, 100.0)
    momentum = fast_turns(rng, inertia)
    parameter = np.concatenate([[0.0], np.sort(rng.uniform(size=n_samples - 2)), [1.0]])
    out = np.full((n_samples, n, 4), np.nan)
    zeros = np.zeros(n, dtype=np.intp)
    playback(1.0 / inertia, momentum, zeros, zeros + n_samples, parameter, np.arange(n), out)
    for k, t in enumerate(parameter):
        assert quat.distance(out[k], samples.flow(inertia, momentum, t)).max() < 1e-13
    np.testing.assert_allclose(out[0], np.tile(quat.IDENTITY, (n, 1)), atol=1e-16)


def test_playback_of_nothing_writes_nothing():
    none = np.zeros(3, dtype=np.intp)
    out = np.full((2, 3, 4), 7.0)
    playback(np.ones((3, 3)), np.ones((3, 3)), none, none, np.zeros(2), none, out)
    assert (out == 7.0).all()


def test_many_turns():
    inertia, momentum = np.array([1.0, 2.0, 3.0]), np.array([40.0, 55.0, -30.0])
    assert oracles.angle_between(matrices(inertia, momentum)[0], oracles.elliptic(inertia, momentum)) < BAR
