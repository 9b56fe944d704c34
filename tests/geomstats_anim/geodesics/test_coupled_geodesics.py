"""Laws of geodesics and splines of metrics that couple joints, between keys, and of their derivatives."""

import dataclasses

import numpy as np
import pytest
import samples

from geomstats_anim import LearnedMetric, LogStatus, MetricParameters, PoseSpace
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics import coupled
from geomstats_anim.geodesics.coupled_geodesics import CoupledGeodesics, Nodes, cometric
from geomstats_anim.interpolation.curves import locate
from geomstats_anim.interpolation.splines import CoupledSpline, PoseSpline
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.riemannian.coupled import CoupledPoseMetric

N, RANK = 3, 2


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def keys_of(rng, n_keys=4, n_joints=N):
    return samples.animation(rng, n_keys, n_joints, 40.0, False)


def curve_of(rng, tension=0.0, coupling=0.7, sides=("left", "right", "left")):
    metric = MetricParameters([2.0, 0.6, 1.3], [0.7, 1.8, 0.4], rng.normal(size=(N, 3)), sides)
    tensions = np.full(N, tension)
    return CurveParameters(metric, tensions, tensions, coupling * rng.normal(size=(N, 3, RANK)))


def frames(keys, n=23):
    return locate(keys.times, np.linspace(keys.times[0], keys.times[-1], n))


@pytest.mark.parametrize("tension", [0.0, 1.4])
def test_without_coupling_it_is_the_product(rng, tension):
    keys, curve = keys_of(rng), curve_of(rng, tension, 0.0)
    samples_at = frames(keys)
    product = PoseSpline(keys.times, keys.rotations, curve.metric, curve.tension)
    whole = CoupledSpline(keys.times, keys.rotations, curve)
    assert quat.distance(whole(*samples_at), product(*samples_at)).max() < 1e-9
    np.testing.assert_allclose(whole.geodesics.velocity, product.geodesics.velocity, atol=1e-9)
    for mine, theirs in zip(whole.rates(*samples_at), product.rates(*samples_at), strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-7 * np.abs(theirs).max())
    cotangent = rng.normal(size=(len(samples_at[0]), N, 3))
    mine, theirs = (spline.pull_back(*samples_at, spline(*samples_at), cotangent) for spline in (whole, product))
    np.testing.assert_allclose(mine[0][:, :5], theirs[0], atol=1e-7)
    np.testing.assert_allclose(mine[1], theirs[1], atol=1e-8)
    assert not mine[0][:, 5:].any()


@pytest.mark.parametrize("side", ["left", "right"])
def test_it_is_the_coupled_metric_of_geomstats_face(rng, side):
    keys, curve = keys_of(rng, 2), curve_of(rng, sides=(side,))
    geodesics = CoupledGeodesics(keys.rotations[:1], keys.rotations[1:], curve.metric, curve.coupling)
    assert (geodesics.status == LogStatus.CONVERGED).all()
    matrix = np.linalg.inv(cometric(curve.metric, curve.coupling))
    space = PoseSpace(N, equip=False)
    space.equip_with_metric(CoupledPoseMetric, metric_mat_at_identity=matrix, left=side == "left")
    start, end = quat.to_matrix(keys.rotations)
    times = np.linspace(0.0, 1.0, 7)
    expected = space.metric.geodesic(start, end_point=end)(times)
    index = np.zeros(7, dtype=int)
    found = geodesics.poses(index, geodesics.turns(index, times))
    np.testing.assert_allclose(quat.to_matrix(found), expected, atol=1e-9)


def test_keys_are_met_and_energy_is_constant(rng):
    keys, curve = keys_of(rng), curve_of(rng)
    geodesics = CoupledGeodesics(keys.rotations[:-1], keys.rotations[1:], curve.metric, curve.coupling)
    index = np.repeat(np.arange(3), 5)
    turned = geodesics.turns(index, np.tile(np.linspace(0.0, 1.0, 5), 3))
    ends = geodesics.poses(index, turned)[[0, 4, 5, 9, 10, 14]]
    assert quat.distance(ends, keys.rotations[[0, 1, 1, 2, 2, 3]]).max() < 1e-9
    velocity, acceleration = (values.reshape(15, -1) for values in geodesics.turn_rates(index, turned))
    matrix = np.linalg.inv(geodesics._cometric)
    energy = np.einsum("fi,ij,fj->f", velocity, matrix, velocity).reshape(3, 5)
    np.testing.assert_allclose(energy, energy[:, :1].repeat(5, axis=1), rtol=1e-9)
    assert np.abs(np.einsum("fi,ij,fj->f", acceleration, matrix, velocity)).max() < 1e-9 * energy.max()


@pytest.mark.parametrize("tension", [*(pytest.param(t, marks=pytest.mark.slow) for t in (0.0, 0.6)), 1.7])
def test_derivatives_are_those_of_finite_differences(rng, tension):
    keys, curve = keys_of(rng), curve_of(rng, tension)
    index, fraction = frames(keys, 11)
    cotangent = rng.normal(size=(11, N, 3))
    middle = CoupledSpline(keys.times, keys.rotations, curve)
    rotations = middle(index, fraction)
    gradient, by_tension = middle.pull_back(index, fraction, rotations, cotangent)

    def value(curve):
        turned = CoupledSpline(keys.times, keys.rotations, curve, middle.geodesics.velocity)(index, fraction)
        return (quat.difference(rotations, turned) * cotangent).sum()

    def varied(joint, column, step):
        metric = curve.metric
        alpha, beta, coupling = metric.alpha.copy(), metric.beta.copy(), curve.coupling.copy()
        axes = metric.axes_quaternions.copy()
        if column < 2:
            (alpha, beta)[column][joint] *= np.exp(step)
        elif column < 5:
            axes[joint] = quat.multiply(quat.exp(step * np.eye(3)[column - 2]), axes[joint])
        else:
            coupling[joint].flat[column - 5] += step
        metric = MetricParameters(alpha, beta, quat.log(axes), metric.invariance)
        return dataclasses.replace(curve, metric=metric, coupling=coupling)

    step = 1e-4
    for joint, column in [(0, 0), (1, 1), (2, 2), (1, 3), (0, 4), (0, 5), (1, 6), (2, 10)]:
        ahead, behind = (value(varied(joint, column, sign * step)) for sign in (1.0, -1.0))
        assert gradient[joint, column] == pytest.approx((ahead - behind) / (2.0 * step), abs=2e-6)
    if tension:
        more, less = (dataclasses.replace(curve, tension=curve.tension + s * step * np.eye(N)[1]) for s in (1.0, -1.0))
        assert by_tension[1] == pytest.approx((value(more) - value(less)) / (2.0 * step), abs=1e-7)


def test_groups_of_joints_are_solved_apart(rng):
    matrix = np.eye(12)
    matrix[0, 8] = matrix[8, 0] = 0.4
    assert [group.tolist() for group in coupled.components(matrix)] == [[0, 2], [1], [3]]
    target = quat.exp(0.8 * rng.normal(size=(2, 4, 3)))
    alone, pair = coupled.shoot(matrix, target), coupled.shoot(matrix[:9, :9], target[:, :3])
    np.testing.assert_allclose(alone.momentum[:, :3], pair.momentum, atol=1e-9)
    np.testing.assert_allclose(alone.momentum[:, [1, 3]], quat.log(target)[:, [1, 3]], atol=1e-9)


def test_nodes_integrate_and_interpolate_polynomials():
    nodes, u = Nodes(9), np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(nodes.integral @ (4.0 * nodes.times**3), nodes.times**4, atol=1e-13)
    found = nodes.at(u, np.zeros(5, dtype=int), (nodes.times**7)[None, :, None, None])
    np.testing.assert_allclose(found.ravel(), u**7, atol=1e-13)


def test_a_coupling_is_checked_stored_and_matched_by_name(rng):
    curve = curve_of(rng)
    metric = LearnedMetric(("a", "a/b", "c"), curve.metric, coupling=curve.coupling)
    again = LearnedMetric.from_json(metric.to_json())
    np.testing.assert_array_equal(again.coupling, curve.coupling)
    assert again.to_json() == metric.to_json()
    assert "coupling" not in LearnedMetric(("a", "a/b", "c"), curve.metric).to_json()
    picked, missing = metric.for_joints(["c", "new", "a"])
    assert missing == ("new",)
    np.testing.assert_array_equal(
        picked.coupling, np.stack([curve.coupling[2], 0.0 * curve.coupling[0], curve.coupling[0]])
    )
    with pytest.raises(ValueError, match=r"coupling has shape \(2, 3, 2\)"):
        dataclasses.replace(metric, coupling=curve.coupling[:2])
    with pytest.raises(ValueError, match="above 10000"):
        dataclasses.replace(metric, coupling=100.0 * curve.coupling)
