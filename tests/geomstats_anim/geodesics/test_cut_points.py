"""Geodesics are certified as the shortest exactly as far as they are."""

import numpy as np
import pytest
import samples

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.cut_points import cut_points, states
from geomstats_anim.geodesics.shortest import injectivity_radius, shortest_momenta
from geomstats_anim.kernels.shooting import CONVERGED


def problems(seed, n, condition, low, high):
    rng = np.random.default_rng(seed)
    return rng, samples.moments(rng, n, condition), samples.gaps(rng, n, low, high)


@pytest.mark.parametrize(
    "condition, low, high, n",
    [
        (25.0, 120.0, 179.0, 300),
        (100.0, 40.0, 180.0, 300),
        pytest.param(25.0, 120.0, 179.0, 6000, marks=pytest.mark.slow),
        pytest.param(100.0, 40.0, 180.0, 6000, marks=pytest.mark.slow),
        pytest.param(1000.0, 90.0, 180.0, 500, marks=pytest.mark.slow),
    ],
)
def test_no_start_finds_a_shorter_one_than_a_certified_geodesic(condition, low, high, n):
    rng, moments, vector = problems(0, n, condition, low, high)
    found = shortest_momenta(moments, vector)
    is_shortest = cut_points(moments, found.momentum).is_shortest & (found.status == CONVERGED)
    assert is_shortest.mean() > 0.9
    best = samples.best_of_random_starts(rng, moments, vector, 32)
    assert (np.sqrt(found.energy) <= (1.0 + 1e-9) * np.sqrt(best))[is_shortest].all()


def test_a_geodesic_that_is_longer_than_another_is_not_certified():
    rng, moments, vector = problems(1, 2000, 25.0, 90.0, 179.0)
    shortest = shortest_momenta(moments, vector)
    momentum = np.sqrt(moments * 2.0 * (moments * vector**2).sum(-1, keepdims=True)) * samples.unit_vectors(rng, 2000)
    other = shortest_momenta(moments, quat.log(samples.flow(moments, momentum)))
    longer = (momentum**2 / moments).sum(-1) > (1.0 + 1e-6) * other.energy
    assert 100 < longer.sum() < 2000
    np.testing.assert_array_equal(cut_points(moments, momentum).is_shortest, ~longer)
    assert cut_points(moments, shortest.momentum).is_shortest.all()


@pytest.mark.parametrize("odd", [1.5, 2.5, 4.0, 20.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_turns_about_the_odd_axis_of_two_equal_moments(odd, axis):
    # geodesics nearby turn about their momentum by |m| / I1, see `oracles.two_equal_moments`, and meet after a turn
    moments = np.ones(3)
    moments[axis] = odd
    cut = min(np.pi, 2.0 * np.pi / odd)
    angles = cut * np.array([0.3, 0.9, 0.999, 1.001, 1.05])
    momentum = odd * angles[:, None] * np.eye(3)[axis]
    is_shortest = cut_points(np.tile(moments, (5, 1)), momentum).is_shortest
    assert is_shortest.tolist() == [True, True, True, False, False]


@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-12, 1e-8, 1e-6, 1e-3])
def test_turns_about_the_heaviest_axis_with_rounding(off):
    moments, direction = np.array([[1.0, 1.5, 20.0]]), np.array([off, -off, 1.0])
    for angle, expected in ((0.2, True), (2.5, False)):
        assert cut_points(moments, moments * angle * direction).is_shortest.tolist() == [expected]
        found = shortest_momenta(moments, angle * direction[None])
        assert found.status.tolist() == [CONVERGED] and cut_points(moments, found.momentum).is_shortest.all()
        best = samples.best_of_random_starts(np.random.default_rng(0), moments, angle * direction[None], 64)
        assert np.sqrt(found.energy) <= (1.0 + 1e-9) * np.sqrt(best)


def test_nothing_within_the_injectivity_radius_has_a_cut_point():
    rng = np.random.default_rng(2)
    moments = samples.moments(rng, 3000, 100.0)
    length = injectivity_radius(moments) * rng.uniform(0.0, 1.0, 3000)
    momentum = np.sqrt(moments) * length[:, None] * samples.unit_vectors(rng, 3000)
    assert cut_points(moments, momentum).is_shortest.all()


def test_images_are_as_long_and_end_at_the_image():
    rng, moments, _ = problems(3, 500, 25.0, 0.0, 1.0)
    momentum = 12.0 * np.sqrt(moments) * samples.unit_vectors(rng, 500)
    cuts = cut_points(moments, momentum)
    assert not cuts.is_shortest.all()
    index = np.flatnonzero(~cuts.is_shortest)
    moments, momentum, image = moments[index], momentum[index], cuts.image[index]
    share = np.linalg.norm(image, axis=-1) / np.linalg.norm(momentum, axis=-1)
    energies = [(m**2 / moments).sum(-1) for m in (image, share[:, None] * momentum)]
    np.testing.assert_allclose(*energies, rtol=1e-9)
    ends = samples.flow(moments, share[:, None] * momentum)
    # reversed, and turned by half a turn about no axis or one
    images = [quat.conjugate(ends)] + [
        quat.conjugate(ends) * sign for sign in ([1, -1, -1, 1], [-1, 1, -1, 1], [-1, -1, 1, 1])
    ]
    nearest = np.max([np.abs((each * samples.flow(moments, image)).sum(-1)) for each in images], axis=0)
    np.testing.assert_allclose(nearest, 1.0, atol=1e-9)


def test_body_momentum_keeps_its_size_and_its_energy():
    rng, moments, vector = problems(4, 50, 25.0, 0.0, 170.0)
    turn, body = states(moments, moments * vector, np.linspace(0.1, 1.0, 7))
    np.testing.assert_allclose(np.linalg.norm(turn, axis=-1), 1.0, rtol=1e-14)
    for values, size in ((body**2, 1.0), (body**2, moments[:, None])):
        sums = (values / size).sum(-1)
        np.testing.assert_allclose(sums, np.tile(sums[:, :1], 7), rtol=1e-9)


def test_no_geodesics():
    assert len(cut_points(np.empty((0, 3)), np.empty((0, 3))).is_shortest) == 0


def test_no_motion_is_the_shortest():
    assert cut_points(np.ones((1, 3)), np.zeros((1, 3))).is_shortest.tolist() == [True]
