"""Wavelets: synthesis inverts analysis for any number of frames, and the basis is what is synthesised."""

import numpy as np
import pytest

from geomstats_anim.codec.wavelets import Wavelets

SIZES = [1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 35, 160, 333]


@pytest.mark.parametrize("n", SIZES)
def test_synthesis_inverts_analysis(n):
    samples = np.random.default_rng(n).normal(size=(n, 4))
    wavelets = Wavelets(n)
    assert np.abs(wavelets.synthesise(wavelets.analyse(samples)) - samples).max() < 1e-13


@pytest.mark.parametrize("n", SIZES)
def test_basis_functions_are_what_units_synthesise(n):
    wavelets = Wavelets(n)
    basis, dense = wavelets.basis, np.zeros((n, n))
    for k in range(n):
        values = basis.values[basis.pointers[k] : basis.pointers[k + 1]]
        dense[basis.starts[k] : basis.starts[k] + len(values), k] = values
    assert np.abs(dense - wavelets.synthesise(np.eye(n))).max() < 1e-14


def test_lines_have_no_wavelets_away_from_the_ends():
    n = 256
    wavelets = Wavelets(n)
    coefficients = wavelets.analyse(np.linspace(0.0, 1.0, n)[:, None])
    finest = coefficients[wavelets.bands[-2] :, 0]
    assert np.abs(finest[4:-4]).max() < 1e-12


def test_constants_have_scaling_coefficients_only():
    wavelets = Wavelets(100)
    coefficients = wavelets.analyse(np.ones((100, 1)))
    assert np.abs(coefficients[wavelets.bands[1] :]).max() < 1e-12


def test_support_grows_linearly():
    lengths = [len(Wavelets(n).basis.values) / n for n in (1000, 8000)]
    assert lengths[1] - lengths[0] < 3 * 12  # one more level covers about nine values per frame, three here
