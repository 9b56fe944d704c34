"""Laws of metrics that couple bones."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geomstats_anim import LogStatus, MetricParameters, PoseMetric, PoseSpace
from geomstats_anim.riemannian.coupled import CoupledPoseMetric, matrix_of_motion

N = 3


def matrix(rng, rank=2, n_bones=N):
    """Return a matrix of low rank plus a diagonal one."""
    factor = rng.normal(size=(3 * n_bones, rank))
    return np.diag(rng.uniform(0.5, 2.0, 3 * n_bones)) + 0.5 * factor @ factor.T


def equipped(matrix, left=True):
    space = PoseSpace(len(matrix) // 3, equip=False)
    return space.equip_with_metric(CoupledPoseMetric, metric_mat_at_identity=matrix, left=left)


@pytest.fixture
def rng():
    np.random.seed(0)
    return np.random.default_rng(0)


@pytest.fixture(params=[True, False], ids=["left", "right"])
def space(request, rng):
    return equipped(matrix(rng), request.param)


@pytest.mark.parametrize("side", ["left", "right"])
def test_block_diagonal_matrices_are_pose_metrics(rng, side):
    parameters = MetricParameters([2.0, 0.5, 1.0], [0.7, 3.0, 1.0], rng.normal(size=(N, 3)), side)
    product = PoseSpace(N, equip=False).equip_with_metric(PoseMetric, parameters=parameters)
    blocks = np.zeros((N, 3, N, 3))
    blocks[np.arange(N), :, np.arange(N)] = parameters.matrices
    coupled = equipped(blocks.reshape(3 * N, 3 * N), side == "left")
    base = product.random_point(2)
    vector = product.metric.from_coordinates(0.8 * rng.normal(size=(2, 3 * N)), base)
    point = product.metric.exp(vector, base)
    np.testing.assert_allclose(coupled.metric.exp(vector, base), point, atol=1e-10)
    np.testing.assert_allclose(coupled.metric.log(point, base), product.metric.log(point, base), atol=1e-8)
    np.testing.assert_allclose(coupled.metric.norm(vector, base), product.metric.norm(vector, base), rtol=1e-12)
    np.testing.assert_allclose(coupled.metric.dist(base, point), product.metric.dist(base, point), rtol=1e-9)
    times = np.array([0.7, -0.5, 0.0])
    paths = (s.metric.geodesic(base, initial_tangent_vec=vector)(times) for s in (coupled, product))
    np.testing.assert_allclose(next(paths), next(paths), atol=1e-10)


def test_log_is_undone_by_exp_and_joins_the_points(rng, space):
    base, point = space.random_point(2)
    result = space.metric.log_solver.solve(point, base)
    assert LogStatus(int(result.status)) == LogStatus.CONVERGED
    np.testing.assert_allclose(space.metric.exp(result.tangent_vec, base), point, atol=1e-9)
    assert float(result.length) == pytest.approx(float(space.metric.dist(base, point)), rel=1e-9)
    path = space.metric.geodesic(base, end_point=point)(np.linspace(0.0, 1.0, 5))
    np.testing.assert_allclose(path[[0, -1]], np.stack([base, point]), atol=1e-9)


def test_distances_are_invariant_and_symmetric(rng, space):
    a, b, c = space.random_point(3)
    b = space.metric.exp(0.5 * space.random_tangent_vec(a), a)
    moved = (
        (space.compose(c, a), space.compose(c, b)) if space.metric.left else (space.compose(a, c), space.compose(b, c))
    )
    dist = space.metric.dist(a, b)
    assert space.metric.dist(*moved) == pytest.approx(dist, rel=1e-8)
    assert space.metric.dist(b, a) == pytest.approx(dist, rel=1e-8)


def test_left_is_right_by_inversion(rng):
    z = matrix(rng)
    left, right = equipped(z, True), equipped(z, False)
    a = left.random_point()
    b = left.metric.exp(0.5 * left.random_tangent_vec(a), a)
    assert right.metric.dist(left.inverse(a), left.inverse(b)) == pytest.approx(left.metric.dist(a, b), rel=1e-9)


def test_geodesics_have_constant_speed_and_are_the_shortest_near_by(rng, space):
    base = space.random_point()
    vector = 0.4 * space.random_tangent_vec(base)
    times = np.linspace(0.0, 1.0, 201)
    path = space.metric.geodesic(base, initial_tangent_vec=vector)(times)
    bend = space.random_tangent_vec(path[100])
    bend /= space.metric.norm(bend, path[100])

    def energy(size):
        share = np.sin(np.pi * times)[:, None, None, None]
        moved = space.projection(path + size * share * bend)
        steps = np.diff(moved, axis=0) / np.diff(times)[0]
        middles = space.projection(0.5 * (moved[1:] + moved[:-1]))
        return space.metric.squared_norm(space.to_tangent(steps, middles), middles)

    speeds = energy(0.0)
    np.testing.assert_allclose(speeds, space.metric.squared_norm(vector, base), rtol=1e-4)
    ahead, behind = energy(0.05).mean(), energy(-0.05).mean()
    assert min(ahead, behind) > speeds.mean()
    assert abs(ahead - behind) < 0.1 * (ahead + behind - 2.0 * speeds.mean())


def test_coupled_bones_move_together(rng):
    """A metric to which opposite turns of two bones are cheap makes one turn the other on its way."""
    z = np.eye(6)
    z[0, 3] = z[3, 0] = 0.9
    space = equipped(z)
    point = space.identity
    point[0] = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    middle = space.metric.geodesic(space.identity, end_point=point)(0.5)[0]
    # about one axis the group is flat, and the way is straight, whatever is coupled
    np.testing.assert_allclose(middle[1], np.eye(3), atol=1e-9)
    z[0, 3] = z[3, 0] = 0.0
    z[0, 4] = z[4, 0] = 0.9
    point[1] = point[0][[1, 2, 0]][:, [1, 2, 0]]
    space = equipped(z)
    middle = space.metric.geodesic(space.identity, end_point=point)(0.5)[0]
    slerp = PoseSpace(2).metric.geodesic(space.identity, end_point=point)(0.5)[0]
    assert np.abs(middle - slerp).max() > 1e-2


@pytest.mark.parametrize("left", [True, False])
def test_frequent_turns_are_cheap(rng, left):
    """Velocities along one direction make it 1 / (dim + shrinkage), and every other 1 / shrinkage."""
    direction = rng.normal(size=3 * N)
    direction /= np.linalg.norm(direction)
    space = equipped(np.eye(3 * N), left)
    steps = 0.01 * rng.normal(size=(30, 1)) * direction
    points = [space.random_point()]
    for step in steps.reshape(-1, N, 3):
        turn = Rotation.from_rotvec(step).as_matrix()
        points.append(points[-1] @ turn if left else turn @ points[-1])
    found = matrix_of_motion(np.array(points), 0.5, left)
    expected = 2.0 * np.eye(3 * N) + (1.0 / (3 * N + 0.5) - 2.0) * np.outer(direction, direction)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    with pytest.raises(ValueError, match="positive"):
        matrix_of_motion(np.array(points), 0.0)
    with pytest.raises(ValueError, match="Nothing moves"):
        matrix_of_motion(np.array(points[:1] * 3))


def test_bad_matrices_are_refused():
    with pytest.raises(ValueError, match=r"\(6, 6\) is needed"):
        equipped_with(np.eye(3))
    with pytest.raises(ValueError, match="eigenvalue -1"):
        equipped_with(np.diag([1.0, 1.0, 1.0, 1.0, 1.0, -1.0]))
    with pytest.raises(ValueError, match="symmetric"):
        equipped_with(np.triu(np.ones((6, 6))))
    assert repr(equipped(np.eye(6), False).metric) == "CoupledPoseMetric(2 joints, right, condition 1)"


def equipped_with(values):
    PoseSpace(2, equip=False).equip_with_metric(CoupledPoseMetric, metric_mat_at_identity=values)
