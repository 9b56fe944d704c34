"""The vector of lanes against NumPy, operation by operation."""

import numpy as np
import pytest
from numba import njit

from geomstats_anim.kernels.simd import LANES, fabs, load, maximum, minimum, rint, splat, sqrt, store

BINARY = {
    "add": (njit(lambda a, b: a + b), np.add),
    "subtract": (njit(lambda a, b: a - b), np.subtract),
    "multiply": (njit(lambda a, b: a * b), np.multiply),
    "divide": (njit(lambda a, b: a / b), np.divide),
    "minimum": (minimum, np.minimum),
    "maximum": (maximum, np.maximum),
}
UNARY = {
    "negate": (njit(lambda a: -a), np.negative),
    "sqrt": (sqrt, np.sqrt),
    "fabs": (fabs, np.abs),
    "rint": (rint, np.rint),
}


@pytest.fixture
def values():
    return np.random.default_rng(0).normal(scale=100.0, size=(3, LANES))


@pytest.mark.parametrize("name", BINARY)
def test_binary(name, values):
    operation, expected = BINARY[name]

    @njit(error_model="numpy")
    def kernel(array):
        store(array, 2, operation(load(array, 0), load(array, 1)))

    a, b = values[:2].copy()
    kernel(values)
    np.testing.assert_array_equal(values[2], expected(a, b))


@pytest.mark.parametrize("name", UNARY)
def test_unary(name, values):
    operation, expected = UNARY[name]

    @njit
    def kernel(array):
        store(array, 2, operation(load(array, 0)))

    values[0] = np.abs(values[0]) if name == "sqrt" else values[0]
    kernel(values)
    np.testing.assert_array_equal(values[2], expected(values[0]))


def test_numbers_beside_vectors(values):
    @njit
    def kernel(array):
        a = load(array, 0)
        a = 2 * a + 1.5 - a * 0.25
        a = 1.0 / a
        a += splat(3.0)
        a *= 2.0
        store(array, 2, a)

    kernel(values)
    np.testing.assert_array_equal(values[2], (1.0 / (2 * values[0] + 1.5 - values[0] * 0.25) + 3.0) * 2.0)


def test_minus_zero():
    array = np.zeros((1, LANES))

    @njit
    def kernel(array):
        store(array, 0, -load(array, 0))

    kernel(array)
    assert np.signbit(array).all()
