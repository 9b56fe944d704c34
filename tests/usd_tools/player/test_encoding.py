"""Numbers for pages: what is packed comes out again, and what stands still costs nothing."""

import numpy as np
import pytest
from unpacking import decoded, whole_numbers

from usd_tools.player.encoding import Steps, encoded


@pytest.mark.parametrize("kind", ["<f4", "<u2", "<i2", "<u4"])
def test_encoding_is_reversible(kind):
    values = np.arange(40).astype(kind)
    np.testing.assert_array_equal(decoded(encoded(values, kind), kind), values)


def test_packing_is_reversible():
    values = np.random.default_rng(0).integers(-32_000, 32_000, (7, 12)).astype(float)
    steps = Steps(np.zeros(12), np.ones(12))
    np.testing.assert_array_equal(whole_numbers(steps.packed(values), 7), values)


def test_values_are_within_half_a_step():
    rng = np.random.default_rng(1)
    motions = [100.0 * rng.normal(size=(9, 1)) * [1.0, 1e-3, 0.0] + 5.0 for _ in range(3)]
    steps = Steps.of(motions, 1e-4)
    for values in motions:
        found = steps.base + steps.unit * whole_numbers(steps.packed(values), 9)
        assert (np.abs(found - values) <= 0.5001 * steps.unit).all()
    assert (steps.unit >= 0.9999e-4).all() and steps.unit[0] < 0.02


def test_what_stands_still_costs_next_to_nothing():
    still = np.tile(np.random.default_rng(2).normal(size=(1, 300)), (500, 1))
    assert len(Steps.of([still], 1e-5).packed(still)) < 600
