"""Laws of the metrics: what must hold whatever finds the geodesics, and against stock Geomstats where that is right."""

import numpy as np
import pytest
from geomstats.geometry.invariant_metric import BiInvariantMetric, _InvariantMetricMatrix
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.learning.frechet_mean import FrechetMean
from invariant_metrics import (
    DIAGONAL,
    FULL,
    MATRICES,
    POSE_PARAMETERS,
    SIDES,
    hat,
    pose_space,
    rotations,
    so3,
    stock,
    tangent,
)
from oracles import angle_between, velocity_form

from geomstats_anim import PoseSpace

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture
def rng():
    return np.random.default_rng(0)


@pytest.fixture(params=[(i, left) for i in range(3) for left in SIDES], ids=lambda p: f"{p[0]}-{'lr'[not p[1]]}")
def space(request):
    index, left = request.param
    return so3(MATRICES[index], left)


# stock Geomstats, where it is right


@pytest.mark.parametrize("left", SIDES)
def test_agrees_with_stock_on_diagonal_matrices(rng, left):
    ours, theirs = so3(DIAGONAL, left).metric, stock(DIAGONAL, left).metric
    base, x, y, z = rotations(rng, 5), *(hat(rng.normal(size=(3, 5, 3))))
    a, b = (tangent(base, rng.normal(size=(5, 3)), left) for _ in range(2))
    np.testing.assert_allclose(ours.inner_product(a, b, base), theirs.inner_product(a, b, base), rtol=1e-12)
    np.testing.assert_allclose(ours.norm(a, base), theirs.norm(a, base), rtol=1e-12)
    np.testing.assert_allclose(ours.normalize(a, base), theirs.normalize(a, base), rtol=1e-12)
    np.testing.assert_allclose(ours.dual_adjoint(x, y), theirs.dual_adjoint(x, y), atol=1e-12)
    np.testing.assert_allclose(ours.structure_constant(x, y, z), theirs.structure_constant(x, y, z), rtol=1e-12)
    np.testing.assert_allclose(ours.connection(a, b, base), theirs.connection(a, b, base), atol=1e-12)
    state = np.stack([base, x], axis=-3)
    np.testing.assert_allclose(ours.geodesic_equation(state), theirs.geodesic_equation(state), atol=1e-12)
    basis = so3().lie_algebra.basis
    np.testing.assert_allclose(ours.normal_basis(basis), theirs.normal_basis(basis), atol=1e-14)
    if left:
        np.testing.assert_allclose(ours.curvature(a, b, a, base), theirs.curvature(a, b, a, base), atol=1e-12)


@pytest.mark.parametrize("left", SIDES)
def test_agrees_with_stock_exp_and_log_at_small_gaps(rng, left):
    ours, theirs = so3(DIAGONAL, left).metric, stock(DIAGONAL, left).metric
    base, velocity = rotations(rng), 0.15 * rng.normal(size=3)
    vec = tangent(base, velocity, left)
    np.testing.assert_allclose(ours.exp(vec, base), theirs.exp(vec, base), atol=1e-4)
    point = ours.exp(vec, base)
    np.testing.assert_allclose(ours.log(point, base), theirs.log(point, base), atol=1e-7)
    times = np.linspace(0.0, 1.0, 4)
    path, stock_path = ours.geodesic(base, end_point=point), theirs.geodesic(base, end_point=point)
    assert path(times).shape == stock_path(times).shape
    ivp, stock_ivp = (m.geodesic(base, initial_tangent_vec=vec) for m in (ours, theirs))
    for t in (0.5, np.array(0.5), np.array([0.5]), times):
        assert ivp(t).shape == stock_ivp(t).shape


def test_bi_invariant_metric_is_slerp(rng):
    space = so3(None)
    base, point = rotations(rng, 2, 6)
    angle = angle_between(base, point)
    np.testing.assert_allclose(space.metric.dist(base, point), np.sqrt(2.0) * angle, rtol=1e-12)
    bi_invariant = SpecialOrthogonal(3, equip=False).equip_with_metric(BiInvariantMetric).metric
    np.testing.assert_allclose(space.metric.log(point, base), bi_invariant.log(point, base), atol=1e-8)
    poses = PoseSpace(6)
    np.testing.assert_allclose(poses.metric.dist(base, point), np.sqrt(2.0 * (angle**2).sum()), rtol=1e-12)
    np.testing.assert_allclose(poses.log(point, base), poses.metric.log(point, base), atol=1e-12)
    middle = poses.metric.geodesic(base, end_point=point)(0.5)[0]
    np.testing.assert_allclose(angle_between(base, middle), angle / 2.0, atol=1e-12)


# symmetries


@pytest.mark.parametrize("matrix", MATRICES)
def test_left_is_right_by_inversion(rng, matrix):
    left, right = so3(matrix, True).metric, so3(matrix, False).metric
    a, b = rotations(rng, 2, 20)
    np.testing.assert_allclose(left.dist(a, b), right.dist(a.swapaxes(-1, -2), b.swapaxes(-1, -2)), rtol=1e-10)


@pytest.mark.parametrize("left", SIDES)
def test_full_matrix_is_diagonal_by_conjugation(rng, left):
    moments, axes = np.linalg.eigh(FULL)
    axes *= np.linalg.det(axes)
    full, diagonal = so3(FULL, left).metric, so3(np.diag(moments), left).metric
    a, b = rotations(rng, 2, 20)
    np.testing.assert_allclose(full.dist(a, b), diagonal.dist(axes.T @ a @ axes, axes.T @ b @ axes), rtol=1e-10)


def test_distance_is_invariant_symmetric_and_obeys_the_triangle(rng, space):
    metric = space.metric
    a, b, c = rotations(rng, 3, 30)
    moved = (c @ a, c @ b) if metric.left else (a @ c, b @ c)
    dist = metric.dist(a, b)
    np.testing.assert_allclose(metric.dist(*moved), dist, rtol=1e-9)
    np.testing.assert_allclose(metric.dist(b, a), dist, rtol=1e-9)
    np.testing.assert_allclose(metric.norm(metric.log(b, a), a), dist, rtol=1e-12)
    assert (metric.dist(a, c) <= dist + metric.dist(b, c) + 1e-9).all()


def test_scale_changes_lengths_and_not_geodesics(rng, space):
    scaled = so3(9.0 * space.metric.metric_mat_at_identity, space.metric.left).metric
    a, b = rotations(rng, 2, 10)
    for other in (scaled, 9.0 * space.metric, space.metric * 9.0):
        np.testing.assert_allclose(other.log(b, a), space.metric.log(b, a), atol=1e-10)
        np.testing.assert_allclose(other.dist(a, b), 3.0 * space.metric.dist(a, b), rtol=1e-12)
        np.testing.assert_allclose(other.log_solver.solve(b, a).length, other.dist(a, b), rtol=1e-10)
    with pytest.raises(ValueError, match="positive"):
        -1.0 * space.metric


def test_pose_metric_is_the_sum_of_its_bones(rng):
    space = pose_space()
    a, b = rotations(rng, 2, 5, 3)
    vec = space.metric.log(b, a)
    spaces = [so3(POSE_PARAMETERS.matrices[i], not POSE_PARAMETERS.is_right[i]) for i in range(3)]
    logs = [bone.metric.log(b[:, i], a[:, i]) for i, bone in enumerate(spaces)]
    np.testing.assert_allclose(vec, np.stack(logs, axis=1), atol=1e-10)
    squares = [bone.metric.squared_dist(a[:, i], b[:, i]) for i, bone in enumerate(spaces)]
    np.testing.assert_allclose(space.metric.squared_dist(a, b), np.sum(squares, axis=0), rtol=1e-10)
    result = space.metric.log_solver.solve(b, a)
    np.testing.assert_allclose(result.length**2, np.stack(squares, axis=1), rtol=1e-10)
    assert (result.residual < 1e-10).all() and (result.iterations > 0).all()
    np.testing.assert_allclose((4.0 * space.metric).dist(a, b), 2.0 * space.metric.dist(a, b), rtol=1e-12)
    transported = space.metric.parallel_transport(vec[::-1], a[0], direction=vec[0])
    expected = [
        bone.metric.parallel_transport(vec[::-1, i], a[0, i], direction=vec[0, i]) for i, bone in enumerate(spaces)
    ]
    np.testing.assert_allclose(transported, np.stack(expected, axis=1), atol=1e-12)


# geodesics


@pytest.mark.parametrize("left", SIDES)
def test_geodesic_agrees_with_runge_kutta(rng, left):
    space = so3(FULL, left)
    base, velocity = rotations(rng, 4), rng.normal(size=(4, 3))
    path = space.metric.geodesic(base, initial_tangent_vec=tangent(base, velocity, left))
    for sign in (1.0, -1.0):
        times = np.array([0.3, 1.0, 2.5])
        poses, _ = velocity_form(FULL, sign * velocity, base, not left, times)
        assert angle_between(path(sign * times), poses.swapaxes(0, 1)).max() < 1e-10


def test_geodesic_has_its_ends_and_constant_speed_at_any_times(rng, space):
    metric = space.metric
    a, b = rotations(rng, 2, 6)
    path = metric.geodesic(a, end_point=b)
    np.testing.assert_allclose(path([0.0, 1.0]), np.stack([a, b], axis=1), atol=1e-11)
    dist = metric.dist(a, b)
    times = np.array([2.0, -0.02, 0.5, 0.0, 0.52, -1.5, 0.5])
    points = path(times)
    assert points.shape == (6, 7, 3, 3)
    for i, t in enumerate(times):
        np.testing.assert_array_equal(points[:, i], path(t)[:, 0])
        step = metric.dist(points[:, i], path(t + 0.02)[:, 0])
        np.testing.assert_allclose(step, 0.02 * dist, rtol=1e-8)
    assert path([]).shape == (6, 0, 3, 3)
    for bad in ([[0.0]], np.nan):
        with pytest.raises(ValueError, match="^t"):
            path(bad)


def test_geodesic_equation_is_the_derivative_of_the_geodesic(rng, space):
    metric = space.metric
    base, velocity = rotations(rng), rng.normal(size=3)
    path = metric.geodesic(base, initial_tangent_vec=tangent(base, velocity, metric.left))
    h = 1e-4
    p = path([-h, 0.0, h])
    rate = metric.geodesic_equation(np.stack([base, hat(velocity)]))
    np.testing.assert_allclose((p[2] - p[0]) / (2.0 * h), rate[0], atol=1e-7)
    second = rate[0] @ hat(velocity) if metric.left else hat(velocity) @ rate[0]
    second += base @ rate[1] if metric.left else rate[1] @ base
    np.testing.assert_allclose((p[2] - 2.0 * p[1] + p[0]) / h**2, second, atol=1e-6)


def test_inner_product_is_twice_the_matrix_product(rng, space):
    left, matrix = space.metric.left, space.metric.metric_mat_at_identity
    base, (a, b) = rotations(rng, 7), rng.normal(size=(2, 7, 3))
    expected = 2.0 * np.einsum("ni,ij,nj->n", a, matrix, b)
    product = space.metric.inner_product(tangent(base, a, left), tangent(base, b, left), base)
    np.testing.assert_allclose(product, expected, rtol=1e-12)
    np.testing.assert_allclose(space.metric.inner_product_at_identity(hat(a), hat(b)), expected, rtol=1e-12)
    np.testing.assert_allclose(space.metric.squared_norm(hat(a)), space.metric.norm(hat(a)) ** 2, rtol=1e-12)


# what follows from the connection


def test_distances_of_neighbours_measure_the_curvature(rng, space):
    """d(exp(sx), exp(sy))^2 = s^2 |x - y|^2 - s^4 / 3 <R(x, y)y, x> + ..., for vectors that are not orthonormal."""
    metric = space.metric
    base, s = rotations(rng), 0.02
    x, y = (tangent(base, v, metric.left) for v in rng.normal(size=(2, 3)))
    squares = [metric.squared_dist(metric.exp(t * x, base), metric.exp(t * y, base)) for t in (s, -s)]
    measured = 3.0 * (metric.squared_norm(x - y, base) - np.mean(squares) / s**2) / s**2
    area = metric.squared_norm(x, base) * metric.squared_norm(y, base) - metric.inner_product(x, y, base) ** 2
    assert metric.sectional_curvature(x, y, base) * area == pytest.approx(measured, rel=5e-3)
    curvature = metric.inner_product(metric.curvature(x, y, x, base), y, base)
    assert curvature == pytest.approx(measured, rel=5e-3)
    tidal = metric.inner_product(metric.directional_curvature(x, y, base), x, base)
    assert tidal == pytest.approx(measured, rel=5e-3)
    assert metric.sectional_curvature(x, 2.0 * x, base) == 0.0


def test_sectional_curvature_is_milnors(rng):
    # Milnor, "Curvatures of left invariant metrics on Lie groups", 1976, section 4, in the metric 2 Z
    moments = np.array([1.0, 3.0, 0.4])
    structure = moments / np.sqrt(2.0 * moments.prod())
    mu = 0.5 * structure.sum() - structure
    basis = so3().lie_algebra.basis
    for left in SIDES:
        metric = so3(np.diag(moments), left).metric
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            expected = structure[k] * mu[k] - mu[i] * mu[j]
            assert metric.sectional_curvature_at_identity(basis[i], basis[j]) == pytest.approx(expected, rel=1e-12)


def test_second_bianchi_identity(rng, space):
    x, y, z, w = hat(rng.normal(size=(4, 3)))
    derivative = space.metric.curvature_derivative_at_identity
    total = derivative(x, y, z, w) + derivative(y, z, x, w) + derivative(z, x, y, w)
    np.testing.assert_allclose(total, 0.0, atol=1e-12)


def test_parallel_transport(rng, space):
    metric = space.metric
    base = rotations(rng)
    v, w = (tangent(base, velocity, metric.left) for velocity in 0.8 * rng.normal(size=(2, 3)))
    moved, end = metric.parallel_transport(w, base, direction=v, return_endpoint=True)
    np.testing.assert_allclose(end, metric.exp(v, base), atol=1e-12)
    runge_kutta = _InvariantMetricMatrix.parallel_transport(metric, w, base, direction=v, n_steps=200)
    np.testing.assert_allclose(moved, runge_kutta, atol=1e-8)
    ladder = metric.ladder_parallel_transport(w, base, v, n_rungs=32)["transported_tangent_vec"]
    np.testing.assert_allclose(moved, ladder, atol=2e-3)
    along = metric.parallel_transport(v, base, end_point=end)
    np.testing.assert_allclose(metric.exp(-along, end), base, atol=1e-8)
    assert metric.inner_product(moved, along, end) == pytest.approx(metric.inner_product(w, v, base), rel=1e-12)
    with pytest.raises(ValueError, match="direction or an end_point"):
        metric.parallel_transport(w, base)


@pytest.mark.parametrize("make", [so3, pose_space])
def test_normal_basis_is_orthonormal(rng, make):
    space = make()
    base = space.random_point()
    basis = space.random_tangent_vec(base, n_samples=space.dim)
    normal = space.metric.normal_basis(basis, base)
    gram = [[space.metric.inner_product(a, b, base) for a in normal] for b in normal]
    np.testing.assert_allclose(gram, np.eye(space.dim), atol=1e-10)
    units = space.metric.random_unit_tangent_vec(base, n_vectors=4)
    np.testing.assert_allclose(space.metric.norm(units, base), 1.0, rtol=1e-12)
    assert space.is_tangent(units, base, atol=1e-12).all()
    with pytest.raises(ValueError, match="linearly independent"):
        space.metric.normal_basis(np.zeros_like(basis), base)


@pytest.mark.parametrize("make", [so3, pose_space])
def test_sets_of_points(rng, make):
    space = make()
    points = space.random_point(4)
    dist = space.metric.dist(points[:, None], points[None, :])
    np.testing.assert_allclose(space.metric.dist_pairwise(points), dist, atol=1e-9)
    np.testing.assert_allclose(space.metric.dist_broadcast(points[:3], points), dist[:3], atol=1e-9)
    assert space.metric.diameter(points) == pytest.approx(dist.max())
    assert space.metric.closest_neighbor_index(points[0], points[1:]) == dist[0, 1:].argmin()
    mean = FrechetMean(space).fit(points[:2]).estimate_
    middle = space.metric.geodesic(points[0], end_point=points[1])(0.5)[0]
    np.testing.assert_allclose(mean, middle, atol=1e-3)


@pytest.mark.parametrize("make", [so3, pose_space])
@pytest.mark.parametrize(
    "method",
    [
        "riemann_tensor",
        "covariant_riemann_tensor",
    ],
)
def test_what_has_no_meaning_for_matrices_refuses(make, method):
    space = make()
    with pytest.raises(NotImplementedError, match="not implemented"):
        getattr(space.metric, method)(space.identity)


def test_what_geomstats_differentiates_is_refused():
    for space in (so3(), pose_space()):
        with pytest.raises(RuntimeError, match="[Aa]uto"):
            space.metric.inner_product_derivative_matrix(space.identity)


def test_no_axis_vectors_of_full_matrices():
    with pytest.raises(ValueError, match="diagonal"):
        _ = so3(FULL).metric.reshaped_metric_matrix


# batches


@pytest.mark.parametrize(
    ("point_batch", "base_batch"),
    [
        ((), ()),
        ((0,), ()),
        ((1,), (1,)),
        ((2, 3), ()),
        ((), (2, 3)),
        ((3,), (2, 1)),
        ((2, 0, 3), (3,)),
        ((4, 1, 2), (3, 1)),
    ],
)
@pytest.mark.parametrize("make", [so3, lambda: so3(DIAGONAL, False), pose_space], ids=["so3", "right", "pose"])
def test_batches_of_any_shape(rng, make, point_batch, base_batch):
    space = make()
    bones = space.shape[:-2]
    point, base = rotations(rng, *point_batch, *bones), rotations(rng, *base_batch, *bones)
    batch = np.broadcast_shapes(point_batch, base_batch)
    result = space.metric.log_solver.solve(point, base)
    assert result.tangent_vec.shape == (*batch, *space.shape)
    assert all(values.shape == (*batch, *bones) for values in result[1:])
    vec = space.metric.log(point, base)
    end = space.metric.exp(vec, base)
    np.testing.assert_allclose(end, np.broadcast_to(point, end.shape), atol=1e-10)
    assert end.shape == vec.shape
    assert space.metric.dist(base, point).shape == space.metric.norm(vec, base).shape == batch
    path = space.metric.geodesic(base, end_point=point)
    assert path([0.1, 0.2]).shape == (*batch, 2, *space.shape)
    assert space.metric.geodesic(base, initial_tangent_vec=vec)(0.3).shape == (*batch, 1, *space.shape)
    assert space.metric.parallel_transport(vec, base, direction=vec, n_steps=2).shape == vec.shape
    for index in np.ndindex(*batch):
        one_point = np.broadcast_to(point, vec.shape)[index]
        one_base = np.broadcast_to(base, vec.shape)[index]
        np.testing.assert_allclose(vec[index], space.metric.log(one_point, one_base), atol=1e-10)


def test_base_point_defaults_to_the_identity(rng):
    for space in (so3(), pose_space()):
        point, identity = space.random_point(), space.identity
        vec = space.metric.log(point)
        np.testing.assert_array_equal(vec, space.metric.log(point, identity))
        np.testing.assert_array_equal(space.metric.exp(vec), space.metric.exp(vec, identity))
        assert space.metric.norm(vec) == space.metric.norm(vec, identity)


# hard places
