"""Laws of curvature, Christoffel symbols and Jacobi fields, most of them against differences of geodesics."""

import numpy as np
import pytest
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from scipy.spatial.transform import Rotation

from geomstats_anim import MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric

FULL = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.0], [0.1, 0.0, 4.0]])
PARAMETERS = MetricParameters(
    [2.0, 1.0, 5.0],
    [0.5, 1.0, 3.0],
    axes=[[0.1, 0.2, 0.3], [0.0, 0.0, 0.0], [1.0, -0.5, 0.2]],
    invariance=("left", "right", "right"),
)


def so3(left):
    space = SpecialOrthogonal(3, equip=False)
    return space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=FULL, left=left)


def poses():
    return PoseSpace(3, equip=False).equip_with_metric(PoseMetric, parameters=PARAMETERS)


@pytest.fixture(params=[lambda: so3(True), lambda: so3(False), poses], ids=["left", "right", "poses"])
def space(request):
    return request.param()


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def point_at(chart, space):
    """Return points of rotation vectors, shape=[..., dim]."""
    vectors = chart.reshape(-1, 3)
    return Rotation.from_rotvec(vectors).as_matrix().reshape(*chart.shape[:-1], *space.shape)


def chart_of(points, space):
    vectors = Rotation.from_matrix(points.reshape(-1, 3, 3)).as_rotvec()
    return vectors.reshape(*points.shape[: points.ndim - len(space.shape)], space.dim)


def vectors(rng, space, base, n):
    return space.metric.from_coordinates(rng.normal(size=(n, space.dim)), base)


# the chart


def test_the_metric_matrix_measures_velocities_of_the_chart(rng, space):
    chart, (u, v) = rng.normal(size=space.dim), rng.normal(size=(2, space.dim))
    step, base = 1e-6, point_at(chart, space)
    a, b = ((point_at(chart + step * w, space) - point_at(chart - step * w, space)) / (2 * step) for w in (u, v))
    matrix = space.metric.metric_matrix(base)
    assert u @ matrix @ v == pytest.approx(space.metric.inner_product(a, b, base), rel=1e-8)
    np.testing.assert_allclose(space.metric.cometric_matrix(base) @ matrix, np.eye(space.dim), atol=1e-9)
    batch = np.stack([base, space.identity])
    np.testing.assert_allclose(space.metric.metric_matrix(batch)[0], matrix, atol=1e-14)
    np.testing.assert_allclose(space.metric.metric_matrix(), space.metric.metric_matrix(batch)[1], atol=1e-14)


def test_christoffels_are_koszuls(rng, space):
    chart = rng.normal(size=space.dim)
    step = 1e-5
    units = step * np.eye(space.dim)
    ahead, behind = (space.metric.metric_matrix(point_at(chart + sign * units, space)) for sign in (1.0, -1.0))
    by = np.moveaxis((ahead - behind) / (2.0 * step), 0, -1)  # g_ij by k
    lower = 0.5 * (by + np.moveaxis(by, -1, -2) - np.moveaxis(by, -1, 0))  # l, i, j after raising the first
    base = point_at(chart, space)
    expected = np.einsum("kl,lij->kij", space.metric.cometric_matrix(base), lower)
    np.testing.assert_allclose(space.metric.christoffels(base), expected, atol=1e-7)
    batch = space.metric.christoffels(np.stack([space.identity, base]))
    np.testing.assert_allclose(batch[1], space.metric.christoffels(base), atol=1e-13)


def test_geodesics_obey_the_christoffels(rng, space):
    base = point_at(0.3 * rng.normal(size=space.dim), space)
    vector = space.metric.from_coordinates(0.4 * rng.normal(size=space.dim), base)
    step = 1e-3
    path = chart_of(space.metric.geodesic(base, initial_tangent_vec=vector)(step * np.arange(-2, 3)), space)
    first = (8.0 * (path[3] - path[1]) - (path[4] - path[0])) / (12.0 * step)
    second = (16.0 * (path[3] + path[1]) - (path[4] + path[0]) - 30.0 * path[2]) / (12.0 * step**2)
    np.testing.assert_allclose(second, -np.einsum("kij,i,j", space.metric.christoffels(base), first, first), atol=1e-7)


def test_cotangent_vectors_are_of_the_chart(rng, space):
    base = point_at(rng.normal(size=space.dim), space)
    p, v = rng.normal(size=(2, space.dim))
    lowered = space.metric.metric_matrix(base) @ v
    assert space.metric.inner_coproduct(p, lowered, base) == pytest.approx(p @ v, rel=1e-9)
    energy = 0.5 * v @ lowered
    assert space.metric.hamiltonian((base, lowered)) == pytest.approx(energy, rel=1e-9)


# curvature


def test_curvature_is_that_of_the_connection(rng, space):
    """Geomstats' own algebra, joint by joint."""
    base = space.random_point(4)
    a, b, c, d = (space.metric.from_coordinates(rng.normal(size=(4, space.dim)), base) for _ in range(4))
    found = space.metric.curvature(a, b, c, base)
    derivative = space.metric.curvature_derivative(a, b, c, d, base)
    sides = space.metric.parameters.is_right
    for joint, right in enumerate(sides):
        matrix = FULL if len(sides) == 1 else PARAMETERS.matrices[joint]
        bone = SpecialOrthogonal(3, equip=False).equip_with_metric(
            SO3InvariantMetric, metric_mat_at_identity=matrix, left=not right
        )

        def at(x, joint=joint, bone=bone):
            vector = x if x.ndim == 3 else x[:, joint]
            place = base if x.ndim == 3 else base[:, joint]
            return bone.tangent_translation_map(place, inverse=True, left=bone.metric.left)(vector)

        nabla, sign = bone.metric.connection_at_identity, -1.0 if right else 1.0

        def curved(x, y, z, nabla=nabla, sign=sign):
            # the bracket of right-invariant fields is minus that of the matrices
            return nabla(sign * (x @ y - y @ x), z) - nabla(x, nabla(y, z)) + nabla(y, nabla(x, z))

        x, y, z, w = (at(vector) for vector in (a, b, c, d))
        np.testing.assert_allclose(at(found), curved(x, y, z), atol=1e-11)
        moved = nabla(x, curved(y, z, w)) - curved(nabla(x, y), z, w) - curved(y, nabla(x, z), w)
        np.testing.assert_allclose(at(derivative), moved - curved(y, z, nabla(x, w)), atol=1e-10)


def test_bianchi_identities(rng, space):
    base = space.random_point()
    a, b, c, d = vectors(rng, space, base, 4)
    curvature, derivative = space.metric.curvature, space.metric.curvature_derivative
    np.testing.assert_allclose(
        curvature(a, b, c, base) + curvature(b, c, a, base), -curvature(c, a, b, base), atol=1e-11
    )
    total = derivative(a, b, c, d, base) + derivative(b, c, a, d, base) + derivative(c, a, b, d, base)
    np.testing.assert_allclose(total, 0.0, atol=1e-10)


def test_distances_of_neighbours_measure_the_curvature(rng, space):
    """d(exp(sx), exp(sy))^2 = s^2 |x - y|^2 - s^4 / 3 <R(x, y)x, y> + ..."""
    metric, s = space.metric, 0.03
    base = space.random_point()
    x, y = vectors(rng, space, base, 2)
    squares = [metric.squared_dist(metric.exp(t * x, base), metric.exp(t * y, base)) for t in (s, -s)]
    measured = 3.0 * (metric.squared_norm(x - y, base) - np.mean(squares) / s**2) / s**2
    area = metric.squared_norm(x, base) * metric.squared_norm(y, base) - metric.inner_product(x, y, base) ** 2
    assert metric.sectional_curvature(x, y, base) * area == pytest.approx(measured, rel=2e-2, abs=1e-2)
    assert metric.sectional_curvature(x, -2.0 * x, base) == 0.0


def test_ricci_and_scalar_curvature_are_sums_of_sectional_ones(rng, space):
    chart = rng.normal(size=space.dim)
    base, metric = point_at(chart, space), space.metric
    frame = metric.from_coordinates(np.eye(space.dim), base)
    planes = metric.sectional_curvature(frame[:, None], frame[None], base)
    assert metric.scalar_curvature(base) == pytest.approx(planes.sum(), rel=1e-12)
    raised = np.einsum("ij,ij->", metric.cometric_matrix(base), metric.ricci_tensor(base))
    assert raised == pytest.approx(planes.sum(), rel=1e-9)
    # along one vector: the curvatures of the planes through it
    step = 1e-6
    v = rng.normal(size=space.dim)
    vector = (point_at(chart + step * v, space) - point_at(chart - step * v, space)) / (2.0 * step)
    through = metric.inner_product(metric.curvature(vector, frame, vector, base), frame, base).sum()
    assert v @ metric.ricci_tensor(base) @ v == pytest.approx(through, rel=1e-7)
    assert metric.scalar_curvature(space.random_point(2)).shape == (2,)


def test_geodesics_within_the_injectivity_radius_are_the_shortest(rng, space):
    radius = space.metric.injectivity_radius()
    base = space.random_point(200)
    assert space.metric.injectivity_radius(base).shape == (200,)
    coordinates = rng.normal(size=(200, space.dim))
    coordinates *= 0.999 * radius / np.linalg.norm(coordinates, axis=-1, keepdims=True)
    vector = space.metric.from_coordinates(coordinates, base)
    np.testing.assert_allclose(space.metric.log(space.metric.exp(vector, base), base), vector, atol=1e-8)
    bi_invariant = PoseSpace(4).metric
    assert bi_invariant.injectivity_radius() == pytest.approx(np.sqrt(2.0) * np.pi, rel=1e-12)


# parallel transport and Jacobi fields


def test_parallel_transport_agrees_with_the_ladder(rng, space):
    base = space.random_point()
    v, w = 0.25 * vectors(rng, space, base, 2)
    moved = space.metric.parallel_transport(w, base, direction=v)
    rungs = [
        space.metric.ladder_parallel_transport(w, base, v, n_rungs=n)["transported_tangent_vec"] for n in (16, 32, 64)
    ]
    # the ladder's error falls with the square of the rungs
    better = [(4.0 * fine - coarse) / 3.0 for coarse, fine in zip(rungs[:-1], rungs[1:], strict=True)]
    np.testing.assert_allclose(moved, (16.0 * better[1] - better[0]) / 15.0, atol=1e-6)


def test_jacobi_fields_are_differences_of_geodesics(rng, space):
    metric, base, step = space.metric, space.random_point(), 1e-4
    v, value, derivative = 0.5 * vectors(rng, space, base, 3)
    times = np.array([0.0, 0.4, -0.7, 1.3])
    field = metric.jacobi_field(base, v, value, derivative)(times)
    np.testing.assert_allclose(field[0], value, atol=1e-12)
    ends = []
    for sign in (1.0, -1.0):
        moved, start = metric.parallel_transport(
            v + sign * step * derivative, base, direction=sign * step * value, return_endpoint=True
        )
        ends.append(metric.geodesic(start, initial_tangent_vec=moved)(times))
    np.testing.assert_allclose(field, (ends[0] - ends[1]) / (2.0 * step), atol=1e-6)


def test_a_geodesic_is_a_jacobi_field_of_its_own(rng, space):
    base = space.random_point(3)
    v = space.metric.from_coordinates(rng.normal(size=(3, space.dim)), base)
    field = space.metric.jacobi_field(base, v, 0.5 * v, v)(2.0)
    along, end = space.metric.parallel_transport(v, base, direction=2.0 * v, return_endpoint=True)
    assert field.shape == (3, 1, *space.shape)
    np.testing.assert_allclose(field[:, 0], 2.5 * along, atol=1e-7)
    assert space.is_tangent(field[:, 0], end, atol=1e-9).all()


def test_jacobi_fields_obey_their_equation(rng, space):
    """The second derivative of the squared length: <J, J>'' = 2 <J', J'> - 2 <R(J, c')J, c'>, at the start."""
    metric, base, step = space.metric, space.random_point(), 1e-3
    v, value, derivative = vectors(rng, space, base, 3)
    times = step * np.arange(-2, 3)
    points = metric.geodesic(base, initial_tangent_vec=v)(times)
    squares = metric.squared_norm(metric.jacobi_field(base, v, value, derivative)(times), points)
    second = (16.0 * (squares[3] + squares[1]) - (squares[4] + squares[0]) - 30.0 * squares[2]) / (12.0 * step**2)
    bending = metric.inner_product(metric.curvature(value, v, value, base), v, base)
    assert second == pytest.approx(2.0 * metric.squared_norm(derivative, base) - 2.0 * bending, rel=1e-5)
