"""The derivative that the gradient search follows, by its own coordinates: moments, rotation vectors, tensions."""

import numpy as np
import pytest
import wanderings

from geomstats_anim.learning.descent import Search, by_coordinates
from geomstats_anim.learning.objective import Objective

SIDES = ("left", "right") * (wanderings.N_JOINTS // 2)


@pytest.mark.parametrize("size", [0.3, 2.0])
def test_it_is_that_of_finite_differences(size):
    rng = np.random.default_rng(4)
    objective = Objective(wanderings.wandering(1, 25), np.arange(0, 25, 6), "hyb")
    point = np.concatenate(
        [rng.uniform(-1.0, 1.0, (wanderings.N_JOINTS, 2)), size * rng.uniform(0.3, 1.0, (wanderings.N_JOINTS, 3)),
         rng.uniform(0.5, 0.9, (wanderings.N_JOINTS, 2))],
        axis=1,
    )  # fmt: skip
    _, gradient = objective.value_and_gradient(Search.curve(point, SIDES))
    found = by_coordinates(gradient, point)
    expected = np.empty_like(point)
    step = 1e-5
    for place in np.ndindex(*point.shape):
        values = []
        for sign in (1.0, -1.0):
            moved = point.copy()
            moved[place] += sign * step
            values.append(objective.value_and_gradient(Search.curve(moved, SIDES))[0])
        expected[place] = (values[0] - values[1]) / (2.0 * step)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7)
