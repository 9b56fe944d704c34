"""Metrics of condition 1000, where motion amplifies rounding: an end point is exact or not found, either way round."""

import numpy as np
import pytest
import samples

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.geodesics.shortest import shortest_momenta

ROUNDING = 3e-11  # radians


@pytest.fixture(scope="module")
def problems():
    """Moments and rotation vectors, shape=[150, 3]."""
    rng = np.random.default_rng(1)
    return samples.moments(rng, 150, 1000.0), samples.gaps(rng, 150, 90.0, 180.0)


@pytest.fixture(scope="module")
def both_ways(problems):
    """Geodesics to the targets, and to their inverses."""
    moments, vector = problems
    return shortest_momenta(moments, vector), shortest_momenta(moments, -vector)


def test_end_points_are_exact_to_rounding(problems, both_ways):
    moments, vector = problems
    for found, target in zip(both_ways, (vector, -vector), strict=True):
        converged = found.status == LogStatus.CONVERGED
        assert converged.mean() > 0.95
        misses = quat.distance(samples.flow(moments, found.momentum), quat.exp(target))
        assert misses[converged].max() <= ROUNDING
        assert found.residual[converged].max() <= ROUNDING


def test_distances_are_symmetric_even_where_the_search_errs(both_ways):
    there, back = both_ways
    both = (there.status == LogStatus.CONVERGED) & (back.status == LogStatus.CONVERGED)
    assert both.mean() > 0.95
    np.testing.assert_allclose(there.energy[both], back.energy[both], rtol=1e-9)
