import numpy as np
import pytest

from geomstats_anim.interpolation.residuals import Residual, basis


@pytest.fixture
def residual():
    rng = np.random.default_rng(0)
    return Residual.through_keys(
        rng.normal(size=(5, 4, 3, 3)), np.array([0.3, 0.1, 0.5, 0.2, 0.2]), np.zeros((5, 3), bool)
    )


def per_second(residual, durations, order, at):
    segments = np.arange(len(durations))
    return residual(segments, np.full(len(durations), at), order) / durations[:, None, None] ** order


def test_the_functions_are_integrals_of_their_derivatives():
    u = np.linspace(0.0, 1.0, 4001)
    for order in (1, 2):
        slopes = basis(u, 5, order)
        change = np.cumsum(0.5 * (slopes[1:] + slopes[:-1]), axis=0) * (u[1] - u[0])
        np.testing.assert_allclose(basis(u, 5, order - 1)[1:] - basis(u, 5, order - 1)[0], change, atol=2e-3 * 5**order)


def test_it_is_zero_at_keys_and_twice_continuously_differentiable(residual):
    durations = np.array([0.3, 0.1, 0.5, 0.2, 0.2])
    for at in (0.0, 1.0):
        np.testing.assert_allclose(per_second(residual, durations, 0, at), 0.0, atol=1e-14)
        np.testing.assert_allclose(per_second(residual, durations, 2, at), 0.0, atol=1e-10)
    ends, starts = (per_second(residual, durations, 1, at) for at in (1.0, 0.0))
    np.testing.assert_allclose(ends[:-1], starts[1:], atol=1e-10)


def test_what_holds_stays_and_its_neighbours_come_to_rest():
    sines, durations = np.random.default_rng(1).normal(size=(4, 3, 2, 3)), np.full(4, 0.2)
    holds = np.zeros((4, 2), dtype=bool)
    holds[1, 0] = True
    residual = Residual.through_keys(sines, durations, holds)
    u = np.linspace(0.0, 1.0, 20)
    assert not residual(np.ones(20, dtype=int), u)[:, 0].any()
    assert residual(np.ones(20, dtype=int), u)[:, 1].any()
    for segment, at in ((0, 1.0), (2, 0.0)):
        slope = residual(np.array([segment]), np.array([at]), 1)[0, 0]
        np.testing.assert_allclose(slope, 0.0, atol=1e-12)


def test_a_share_of_some_joints_is_that_share_of_them(residual):
    segment, fraction = np.repeat(np.arange(5), 7), np.tile(np.linspace(0.0, 1.0, 7), 5)
    shares = np.array([0.0, 0.3, 1.0])
    for order in range(3):
        whole = residual(segment, fraction, order)
        np.testing.assert_allclose(
            residual.shared(shares)(segment, fraction, order), whole * shares[:, None], atol=1e-11
        )
        np.testing.assert_array_equal(residual.at_joints(np.array([2]))(segment, fraction, order), whole[:, 2:])
