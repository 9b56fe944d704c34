"""The boundary value solver: exact end points, shortest geodesics, every hard place, and the same bits every time."""

import numpy as np
import oracles
import pytest
import samples

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.geodesics.shortest import injectivity_radius, shortest_momenta
from geomstats_anim.kernels import threads

pytestmark = pytest.mark.filterwarnings("error")

BAR = 1e-10  # radians


def solve(inertia, vector):
    """Solve, and check what holds for every problem: numbers, a status, and an exact end point if it converged."""
    inertia, vector = np.atleast_2d(inertia), np.atleast_2d(vector)
    inertia = np.broadcast_to(inertia, vector.shape)
    with np.errstate(all="raise", under="ignore"):
        found = shortest_momenta(inertia, vector)
    assert np.isfinite(found.momentum).all()
    assert np.isfinite(found.residual).all()
    assert set(found.status) <= set(LogStatus)
    converged = found.status == LogStatus.CONVERGED
    np.testing.assert_array_equal(np.isfinite(found.energy), converged)
    misses = quat.distance(samples.flow(inertia, found.momentum), quat.exp(vector))[converged]
    assert misses.max(initial=0.0) < BAR
    assert converged[found.residual > BAR].sum() == 0
    return found


def share_converged(found):
    return (found.status == LogStatus.CONVERGED).mean()


@pytest.mark.parametrize("low, high, at_least", [(0.0, 170.0, 0.999), (170.0, 180.0, 0.99)])
def test_converges_up_to_condition_100(low, high, at_least):
    rng = np.random.default_rng(1)
    inertia, vector = samples.moments(rng, 2000, 100.0), samples.gaps(rng, 2000, low, high)
    found = solve(inertia, vector)
    assert share_converged(found) >= at_least
    some = np.flatnonzero(found.status == LogStatus.CONVERGED)[:200]
    ends = oracles.momentum_form(inertia[some], found.momentum[some])[0]
    assert oracles.angle_between(ends, quat.to_matrix(quat.exp(vector[some]))).max() < BAR


@pytest.mark.parametrize("low, high, at_least", [(0.0, 1e-9, 1.0), (0.0, 45.0, 0.999), (0.0, 170.0, 0.97)])
def test_quick_searches_end_nearly_at_the_target(low, high, at_least):
    rng = np.random.default_rng(7)
    inertia, vector = samples.moments(rng, 2000, 10.0), samples.gaps(rng, 2000, low, high)
    quick, thorough = shortest_momenta(inertia, vector, effort="quick"), solve(inertia, vector)
    found = np.flatnonzero(quick.status == LogStatus.CONVERGED)
    misses = quat.distance(samples.flow(inertia, quick.momentum), quat.exp(vector))[found]
    assert misses.max() < 1e-8
    same = np.abs(quick.momentum - thorough.momentum).max(axis=1) < 1e-7
    assert same.mean() >= at_least


def test_a_momentum_nearby_helps_where_a_guess_is_not_enough():
    rng = np.random.default_rng(8)
    inertia, vector = samples.moments(rng, 300, 100.0), samples.gaps(rng, 300, 150.0, 175.0)
    best = solve(inertia, vector)
    start = np.where(rng.random((300, 1)) < 0.9, 1.001 * best.momentum, np.nan)
    quick = shortest_momenta(inertia, vector, start, "quick")
    alone = shortest_momenta(inertia, vector, effort="quick")
    assert quick.energy.sum() <= alone.energy.sum()
    assert quick.shots.sum() < alone.shots.sum()


@pytest.mark.slow
@pytest.mark.parametrize("low, high, n, at_least", [(0.0, 170.0, 100_000, 0.999), (170.0, 180.0, 20_000, 0.99)])
def test_converges_up_to_condition_100_on_many_pairs(low, high, n, at_least):
    rng = np.random.default_rng(2)
    found = solve(samples.moments(rng, n, 100.0), samples.gaps(rng, n, low, high))
    assert share_converged(found) >= at_least


@pytest.mark.parametrize(
    "n",
    [
        pytest.param(300, id="300 pairs"),
        pytest.param(2000, id="2000 pairs", marks=pytest.mark.slow),
    ],
)
def test_no_longer_than_the_best_of_32_random_starts(n):
    rng = np.random.default_rng(3)
    inertia, vector = samples.moments(rng, n, 25.0), samples.gaps(rng, n, 120.0, 179.0)
    found = solve(inertia, vector)
    best = samples.best_of_random_starts(rng, inertia, vector, 32)
    longer = np.sqrt(found.energy) > (1.0 + 1e-6) * np.sqrt(best)
    assert longer.mean() <= 1e-3


@pytest.mark.parametrize("condition", [1.0, 3.0, 10.0, 100.0])
def test_nothing_is_shorter_than_a_geodesic_below_the_injectivity_radius(condition):
    rng = np.random.default_rng(4)
    n = 300
    inertia = samples.moments(rng, n, condition)
    length = injectivity_radius(inertia) * rng.uniform(0.5, 1.0, n)
    momentum = np.sqrt(inertia) * length[:, None] * samples.unit_vectors(rng, n)
    vector = quat.log(samples.flow(inertia, momentum))
    found = solve(inertia, vector)
    # the one geodesic that short is the one the target was made with
    np.testing.assert_allclose(found.momentum, momentum, atol=1e-9 * np.sqrt(condition))
    assert (length**2 <= (1.0 + 1e-9) * samples.best_of_random_starts(rng, inertia, vector, 64)).all()


@pytest.mark.parametrize(
    "inertia, expected",
    [
        ((1.0, 1.0, 1.0), np.pi),  # half a turn
        ((4.0, 4.0, 4.0), 2.0 * np.pi),  # lengths scale with the square root
        ((1.0, 9.0, 9.0), np.pi),  # the closed geodesic about the lightest axis
        ((1.0, 1.0, 4.0), np.pi / np.sqrt(3.0 * 1.0 - 2.0)),
    ],
)
def test_injectivity_radius_of_known_metrics(inertia, expected):
    radius = injectivity_radius(np.array([inertia]))[0]
    assert radius <= expected * (1.0 + 1e-12)
    assert radius > 0.0


def test_injectivity_radius_is_that_of_the_axes_in_any_order():
    radii = [injectivity_radius(np.array([order]))[0] for order in ([1.0, 2.0, 7.0], [7.0, 1.0, 2.0], [2.0, 1.0, 7.0])]
    np.testing.assert_allclose(radii, radii[0], rtol=1e-14)


@pytest.mark.parametrize("inertia", [(1.0, 1.0, 1.0), (1.0, 2.0, 0.5), (1.0, 100.0, 10.0), (2.0, 2.0, 0.02)])
@pytest.mark.parametrize("gap", [0.0, 1e-300, 1e-12, 1e-8])
def test_gaps_of_nearly_nothing(inertia, gap):
    inertia = np.array([inertia])
    vector = gap * np.array([[0.6, -0.48, 0.64]])
    found = solve(inertia, vector)
    assert share_converged(found) == 1.0
    np.testing.assert_allclose(found.momentum, inertia * vector, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("inertia", [(1.0, 1.0, 1.0), (1.0, 2.0, 0.5), (1.0, 10.0, 0.1), (1.0, 1.0, 25.0)])
@pytest.mark.parametrize(
    "axis", [(1, 0, 0), (0, 1, 0), (0, 0, -1), (1, 1, 0), (0, 1, -1), (1, -2, 3)], ids=lambda axis: str(axis)
)
def test_exactly_half_a_turn(inertia, axis):
    direction = np.array([axis]) / np.linalg.norm(axis)
    inertia = np.array([inertia])
    found = solve(inertia, np.pi * direction)
    assert share_converged(found) == 1.0
    # both ways round are as short; never longer than the half turn about the axis, nor than the other sign's geodesic
    assert found.energy[0] <= (1.0 + 1e-12) * np.pi**2 * (inertia * direction**2).sum()
    other = solve(inertia, -np.pi * direction)
    np.testing.assert_allclose(other.energy, found.energy, rtol=1e-6)


@pytest.mark.parametrize("odd_axis", [0, 1, 2])
@pytest.mark.parametrize("ratio", [0.05, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 20.0])
def test_equal_moments(odd_axis, ratio):
    inertia = np.ones(3)
    inertia[odd_axis] = ratio
    vector = samples.gaps(np.random.default_rng(5), 200, 0.0, 175.0)
    found = solve(inertia, vector)
    assert share_converged(found) == 1.0
    for momentum, target in zip(found.momentum[:20], quat.to_matrix(quat.exp(vector[:20])), strict=True):
        if ratio in (0.05, 1.0, 20.0):
            assert oracles.angle_between(oracles.two_equal_moments(inertia, momentum), target) < BAR


@pytest.mark.parametrize("inertia", [(1.0, 2.0, 4.0), (25.0, 1.0, 5.0)])
@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-6, 1e-2])
def test_targets_near_the_separatrix(inertia, offset):
    inertia = np.array([inertia])
    middle = np.argsort(inertia[0])[1]
    momentum = (
        inertia * (offset * np.array([[0.3, -0.7, 0.5]]) + np.eye(3)[middle]) * np.linspace(0.1, 2.0, 20)[:, None]
    )
    target = quat.log(samples.flow(np.tile(inertia, (20, 1)), momentum))
    found = solve(inertia, target)
    assert share_converged(found) == 1.0
    assert (found.energy <= (1.0 + 1e-9) * (momentum**2 / inertia).sum(-1)).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-6])
def test_targets_near_a_principal_axis(axis, offset):
    inertia = np.array([1.0, 3.0, 10.0])
    vector = 1.2 * (np.eye(3)[axis] + offset * np.array([0.3, -0.7, 0.5]))
    found = solve(inertia, vector)
    assert share_converged(found) == 1.0
    assert found.energy[0] <= (1.0 + 1e-12) * (inertia * vector**2).sum()


def test_no_problems():
    found = solve(np.empty((0, 3)), np.empty((0, 3)))
    assert all(len(values) == 0 for values in found)


@pytest.mark.parametrize("change", ["float32", "not contiguous", "read-only"])
def test_arrays_of_every_kind(change):
    rng = np.random.default_rng(6)
    inertia, vector = samples.moments(rng, 20, 10.0), samples.gaps(rng, 20, 0.0, 90.0)
    if change == "float32":
        inertia, vector = inertia.astype(np.float32), vector.astype(np.float32)
    expected = shortest_momenta(inertia.astype(float), vector.astype(float))
    if change == "not contiguous":
        inertia, vector = np.asfortranarray(inertia), np.repeat(vector, 2, axis=0)[::2]
    if change == "read-only":
        inertia.setflags(write=False)
        vector.setflags(write=False)
    found = shortest_momenta(inertia, vector)
    for mine, wanted in zip(found, expected, strict=True):
        np.testing.assert_array_equal(mine, wanted)


def test_the_same_bits_alone_and_among_others_on_one_thread_and_on_two(monkeypatch):
    rng = np.random.default_rng(7)
    n = 1100
    inertia, vector = samples.moments(rng, n, 30.0), samples.gaps(rng, n, 0.0, 120.0)

    def solve_on(n_processors):
        monkeypatch.setattr(threads.os, "sched_getaffinity", lambda _: set(range(n_processors)), raising=False)
        return shortest_momenta(inertia, vector)

    one, two = solve_on(1), solve_on(2)
    for mine, other in zip(one, two, strict=True):
        np.testing.assert_array_equal(mine, other)
    for some in ([0], [n - 1], slice(3, 14), np.arange(n)[::-7]):
        alone = shortest_momenta(inertia[some], vector[some])
        for mine, other in zip(one, alone, strict=True):
            np.testing.assert_array_equal(mine[some], other)


def test_the_scale_of_the_matrix_does_not_matter():
    rng = np.random.default_rng(8)
    inertia, vector = samples.moments(rng, 300, 25.0), samples.gaps(rng, 300, 0.0, 150.0)
    one, four = solve(inertia, vector), solve(4.0 * inertia, vector)
    np.testing.assert_allclose(four.energy, 4.0 * one.energy, rtol=1e-9)
    ends = [samples.flow(inertia, found.momentum / s, 0.5) for found, s in ((one, 1.0), (four, 4.0))]
    assert np.quantile(quat.distance(*ends), 0.99) < 1e-9


@pytest.mark.parametrize("inertia", [(1.0, 1e-2, 1e2), (1.0, 1e-1, 1e3), (1.0, 1.0, 1e-4)])
def test_condition_10000_end_with_a_status(inertia):
    solve(inertia, samples.gaps(np.random.default_rng(9), 5, 0.0, 179.0))
