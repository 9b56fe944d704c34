"""Many small minimisations at once: each is one of its own, within its bounds, and never ends above its start."""

import numpy as np
import pytest
from scipy.optimize import minimize

from geomstats_anim.learning.batched_bfgs import batched_bfgs

LOWER, UPPER = np.array([-1.0, -2.0, 0.0]), np.array([1.0, 2.0, 2.0])
TOLERANCE = 1e-12


def quadratics(seed, n=20):
    """Bowls whose bottoms lie within the bounds, on them or beyond them."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(n, 3, 3))
    bowls, bottoms = roots @ np.swapaxes(roots, 1, 2) + 0.1 * np.eye(3), rng.normal(scale=1.5, size=(n, 3))

    def evaluate(points, index):
        away = points - bottoms[index]
        gradient = np.einsum("nij,nj->ni", bowls[index], away)
        return 0.5 * (away * gradient).sum(axis=1), gradient

    return evaluate, rng.uniform(LOWER, UPPER, (n, 3))


def rosenbrock(points, index):
    """Valleys that bend the more, the higher the index."""
    x, y, _ = points.T
    bend = 1.0 + index
    value = (1.0 - x) ** 2 + bend * (y - x**2) ** 2
    by_x = -2.0 * (1.0 - x) - 4.0 * bend * x * (y - x**2)
    return value, np.stack([by_x, 2.0 * bend * (y - x**2), np.zeros_like(x)], axis=1)


def run(evaluate, start, rounds=200):
    return batched_bfgs(evaluate, start, LOWER, UPPER, np.full(len(start), TOLERANCE), rounds)


@pytest.mark.parametrize("seed", range(5))
def test_bounded_bowls_against_scipy(seed):
    evaluate, start = quadratics(seed)
    point, value, _ = run(evaluate, start)
    assert (point >= LOWER).all() and (point <= UPPER).all()
    for i in range(len(start)):

        def alone(x, i=i):
            values, gradients = evaluate(x[None], np.array([i]))
            return values[0], gradients[0]

        bounds = list(zip(LOWER, UPPER, strict=True))
        expected = minimize(alone, start[i], jac=True, bounds=bounds, options={"ftol": 1e-14, "gtol": 1e-9}).fun
        assert value[i] == pytest.approx(expected, rel=1e-6, abs=1e-8)


def test_bent_valleys():
    start = np.tile([-1.0, 1.5, 1.0], (10, 1))
    point, value, _ = run(rosenbrock, start)
    np.testing.assert_allclose(point[:, :2], 1.0, atol=1e-3)
    assert (value < 1e-6).all()
    np.testing.assert_array_equal(point[:, 2], 1.0)


@pytest.mark.parametrize("rounds", [0, 1, 2, 5])
def test_never_above_the_start(rounds):
    start = np.random.default_rng(0).uniform(LOWER, UPPER, (30, 3))
    before, _ = rosenbrock(start, np.arange(30))
    point, value, _ = run(rosenbrock, start, rounds)
    assert (value <= before).all()
    np.testing.assert_array_equal(value, rosenbrock(point, np.arange(30))[0])


def test_a_function_does_not_see_the_others():
    evaluate, start = quadratics(7)
    together = run(evaluate, start)
    for i in range(len(start)):
        alone = run(lambda x, index, i=i: evaluate(x, index + i), start[i : i + 1])
        for one, all_ in zip(alone, together, strict=True):
            np.testing.assert_allclose(one[0], all_[i], rtol=1e-9, atol=1e-12)


def test_what_is_finished_is_not_evaluated_again():
    seen = np.zeros(10, dtype=int)

    def evaluate(points, index):
        seen[index] += 1
        flat = index < 5
        values, gradients = rosenbrock(points, index)
        return np.where(flat, 3.0, values), np.where(flat[:, None], 0.0, gradients)

    run(evaluate, np.tile([-1.0, 1.5, 1.0], (10, 1)))
    np.testing.assert_array_equal(seen[:5], 1)
    assert (seen[5:] > 5).all()


def test_nothing_to_minimise():
    point, value, _ = run(rosenbrock, np.zeros((0, 3)))
    assert point.shape == (0, 3) and value.shape == (0,)
