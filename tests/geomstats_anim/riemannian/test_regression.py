"""Laws of regression along geodesics."""

import numpy as np
import pytest
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from sklearn.base import clone

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric
from geomstats_anim.riemannian.regression import GeodesicRegression

FULL = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])


def so3():
    space = SpecialOrthogonal(3, equip=False)
    return space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=FULL, left=False)


def poses(n_bones=24):
    rng = np.random.default_rng(1)
    numbers = np.exp(0.5 * rng.normal(size=(2, n_bones)))
    sides = ["left", "right"] * (n_bones // 2)
    parameters = MetricParameters(*numbers, axes=rng.normal(size=(n_bones, 3)), invariance=sides)
    return PoseSpace(n_bones, equip=False).equip_with_metric(PoseMetric, parameters=parameters)


@pytest.fixture(params=[so3, poses], ids=["so3", "poses"])
def space(request):
    return request.param()


def line(space, rng, times, speed=1.0):
    base = space.random_point()
    coordinates = speed * rng.normal(size=space.dim)
    vector = space.metric.from_coordinates(coordinates, base)
    return base, vector, space.metric.geodesic(base, initial_tangent_vec=vector)(times)


@pytest.mark.parametrize("center", [True, False])
def test_exact_data_are_recovered(space, center):
    rng, times = np.random.default_rng(0), np.linspace(0.0, 1.0, 30)
    base, vector, points = line(space, rng, times - 0.5 * center)
    regression = clone(GeodesicRegression(space, center_X=center)).fit(times, points)
    np.testing.assert_allclose(regression.intercept_, base, atol=1e-9)
    np.testing.assert_allclose(regression.coef_, vector, atol=1e-8)
    np.testing.assert_allclose(regression.predict(times), points, atol=1e-9)
    assert regression.score(times, points) == pytest.approx(1.0, abs=1e-12)


def test_noisy_data_have_no_better_geodesic_near_by(space):
    rng, times = np.random.default_rng(0), np.sort(np.random.default_rng(2).uniform(size=20))
    base, _, points = line(space, rng, times)
    noise = space.metric.from_coordinates(0.2 * rng.normal(size=(20, space.dim)), points)
    points, weights = space.metric.exp(noise, points), rng.uniform(0.2, 1.0, 20)
    regression = GeodesicRegression(space).fit(times, points, weights)
    metric = space.metric

    def loss(turn, change):
        start = metric.exp(metric.from_coordinates(turn, regression.intercept_), regression.intercept_)
        speed = metric.coordinates(regression.coef_, regression.intercept_) + change
        path = metric.geodesic(start, initial_tangent_vec=metric.from_coordinates(speed, start))
        return (weights * metric.squared_dist(path(times - regression.mean_), points)).sum()

    least = loss(np.zeros(space.dim), np.zeros(space.dim))
    step = 1e-4
    for direction in step * rng.normal(size=(6, 2, space.dim)):
        ahead, behind = loss(*direction), loss(*-direction)
        assert min(ahead, behind) > least
        assert ahead - behind == pytest.approx(0.0, abs=1e-5 * (ahead + behind - 2.0 * least) + 1e-11)
    assert 0.0 < regression.score(times, points, weights) < 1.0


def test_standing_still_has_no_speed(space):
    point = space.random_point()
    regression = GeodesicRegression(space).fit(np.linspace(0.0, 1.0, 5), np.stack([point] * 5))
    np.testing.assert_allclose(regression.intercept_, point, atol=1e-12)
    np.testing.assert_allclose(regression.coef_, 0.0, atol=1e-12)
