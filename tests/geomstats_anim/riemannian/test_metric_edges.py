"""Edges of the metrics: no gap, half turns, equal moments, input of any type, what is refused, what fails."""

import numpy as np
import pytest
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from invariant_metrics import (
    DIAGONAL,
    FULL,
    MATRICES,
    SIDES,
    hat,
    pose_space,
    rotations,
    so3,
)
from oracles import angle_between, velocity_form
from scipy.spatial.transform import Rotation

from geomstats_anim import LogStatus, MetricParameters, PoseMetric, PoseSpace, SO3InvariantMetric

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture
def rng():
    return np.random.default_rng(0)


@pytest.fixture(params=[(i, left) for i in range(3) for left in SIDES], ids=lambda p: f"{p[0]}-{'lr'[not p[1]]}")
def space(request):
    index, left = request.param
    return so3(MATRICES[index], left)


def test_zero_gap(space):
    points = space.random_point(20)
    np.testing.assert_allclose(space.metric.log(points, points), 0.0, atol=1e-14)
    np.testing.assert_allclose(space.metric.dist(points, points), 0.0, atol=1e-14)
    np.testing.assert_allclose(space.metric.exp(np.zeros_like(points), points), points, atol=1e-14)
    near = points @ Rotation.from_rotvec([1e-9, 0.0, 0.0]).as_matrix()
    np.testing.assert_allclose(space.metric.exp(space.metric.log(near, points), points), near, atol=1e-15)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, -2, 3]])
def test_half_turn(rng, space, axis):
    axis = np.array(axis) / np.linalg.norm(axis)
    half_turn = 2.0 * np.outer(axis, axis) - np.eye(3)
    base = rotations(rng)
    vec = space.metric.log(base @ half_turn, base)
    np.testing.assert_allclose(space.metric.exp(vec, base), base @ half_turn, atol=1e-10)
    about_the_axis = space.metric.norm(base @ hat(np.pi * axis), base)
    assert space.metric.norm(vec, base) <= about_the_axis * (1.0 + 1e-12)


@pytest.mark.parametrize("moments", [(1.0, 1.0, 3.0), (1.0, 3.0, 3.0), (2.0, 1.0, 2.0), (1.0, 1.0 + 1e-9, 3.0)])
def test_equal_moments(rng, moments):
    space = so3(np.diag(moments))
    velocity = rng.normal(size=(10, 3))
    poses, _ = velocity_form(np.diag(moments), velocity)
    assert angle_between(space.metric.exp(hat(velocity)), poses[-1]).max() < 1e-10
    a, b = rotations(rng, 2, 10)
    np.testing.assert_allclose(space.metric.exp(space.metric.log(b, a), a), b, atol=1e-10)


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-6, 1e-3])
def test_near_the_separatrix(off):
    matrix = np.diag([1.0, 2.0, 3.0])
    velocity = np.array([off, 3.0, -off])
    poses, _ = velocity_form(matrix, velocity)
    assert angle_between(so3(matrix).metric.exp(hat(velocity)), poses[-1]).max() < 1e-10


def test_all_gaps_are_found_and_nothing_is_nan(rng, space):
    base, axis = rotations(rng, 300), rng.normal(size=(300, 3))
    angle = np.linspace(0.0, np.pi, 300)
    axis *= angle[:, None] / np.linalg.norm(axis, axis=1, keepdims=True)
    point = base @ Rotation.from_rotvec(axis).as_matrix()
    result = space.metric.log_solver.solve(point, base)
    assert (result.status == LogStatus.CONVERGED).all()
    assert all(np.isfinite(values).all() for values in result)
    assert angle_between(space.metric.exp(result.tangent_vec, base), point).max() < 1e-10


# inputs


@pytest.mark.parametrize("make", [so3, pose_space])
def test_input_of_any_number_type_and_layout(make):
    space = make()
    base, point = space.random_point(4), space.random_point(4)
    expected = space.metric.log(point, base)
    np.testing.assert_allclose(space.metric.log(point.astype(np.float32), base.astype(np.float32)), expected, atol=1e-5)
    assert space.metric.exp(expected.astype(np.float32), base).dtype == np.float64
    np.testing.assert_array_equal(space.metric.log(point.tolist(), base.tolist()), expected)
    strided = np.repeat(point, 2, axis=0)[::2], np.asfortranarray(base)
    np.testing.assert_array_equal(space.metric.log(*strided), expected)
    reversed_ = space.metric.log(point[::-1], base[::-1])
    np.testing.assert_allclose(reversed_[::-1], expected, atol=1e-10)
    np.testing.assert_allclose(space.metric.exp(expected[::-1], base[::-1])[::-1], point, atol=1e-10)


def test_rounding_is_projected_and_more_is_refused(rng):
    space = so3()
    base, point = rotations(rng, 2, 5)
    noise = rng.uniform(-1.0, 1.0, size=point.shape)
    near = point + 1e-7 * noise
    end = space.metric.exp(space.metric.log(near, base), base)
    np.testing.assert_allclose(end, near, atol=3e-7)
    np.testing.assert_allclose(end.swapaxes(-1, -2) @ end, np.broadcast_to(np.eye(3), end.shape), atol=1e-14)
    np.testing.assert_allclose(end, SpecialOrthogonal(3).projection(near), atol=1e-11)
    np.testing.assert_allclose(
        space.metric.dist(base, near), space.metric.log_solver.solve(near, base).length, rtol=1e-12
    )
    far = point.copy()
    far[3] *= 1.001
    for call in (
        lambda: space.metric.log(far, base),
        lambda: space.metric.dist(base, far),
        lambda: space.metric.log_solver.solve(far, base),
    ):
        with pytest.raises(ValueError, match=r"^point\[3\] is not a rotation: .* by 0\.002, .*project"):
            call()
    for call in (
        lambda: space.metric.exp(point, far),
        lambda: space.metric.inner_product(point, point, far),
        lambda: space.metric.log(point, far),
    ):
        with pytest.raises(ValueError, match=r"^base_point\[3\] is not a rotation"):
            call()
    with pytest.raises(ValueError, match=r"^end_point\[3\] is not a rotation"):
        space.metric.geodesic(base, end_point=far)
    with pytest.raises(ValueError, match=r"^point is not a rotation"):
        space.metric.log(1e200 * point[0], base[0])
    with pytest.raises(ValueError, match=r"^initial_point is not a rotation but a reflection"):
        space.metric.geodesic(-base[0], end_point=base[0])


def test_nonsense_is_refused(rng):
    space = pose_space()
    base, point = space.random_point(2)
    vec = space.metric.log(point, base)
    for bad, message in (
        (np.where(np.arange(3)[:, None, None] == 1, np.nan, vec), r"^tangent_vec\[1, 0, 0\] is not a finite number"),
        (vec[:2], r"^tangent_vec has shape \(2, 3, 3\), but \(\.\.\., 3, 3, 3\) is needed"),
        (vec[0, 0], r"^tangent_vec has shape \(3,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            space.metric.exp(bad, base)
    with pytest.raises(ValueError, match=r"^initial_tangent_vec has shape"):
        space.metric.geodesic(base, initial_tangent_vec=vec[0])
    for too_far in (
        lambda: space.metric.exp(1e160 * vec, base),
        lambda: space.metric.geodesic(base, initial_tangent_vec=vec)(1e300),
        lambda: space.metric.parallel_transport(vec, base, direction=1e160 * vec),
    ):
        with pytest.raises(ValueError, match=r"radians, but at most 100000 can be followed"):
            too_far()


def test_what_is_not_tangent_is_projected(rng, space):
    base, vector = rotations(rng, 4), rng.normal(size=(4, 3, 3))
    vec = space.to_tangent(vector, base)
    np.testing.assert_allclose(space.metric.exp(vector, base), space.metric.exp(vec, base), atol=1e-12)
    np.testing.assert_allclose(space.metric.norm(vector, base), space.metric.norm(vec, base), rtol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.diag([1.0, -1.0, 1.0]), "eigenvalue -1"),
        (np.diag([1.0, 0.0, 1.0]), "eigenvalue 0"),
        (np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "eigenvalue -1"),
        (np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "not symmetric"),
        (np.full((3, 3), np.nan), "not finite"),
        (np.ones(3), r"shape \(3,\)"),
        (np.eye(6), r"shape \(6, 6\)"),
    ],
)
def test_matrices_that_make_no_metric_are_refused(matrix, message):
    with pytest.raises(ValueError, match=rf"^metric_mat_at_identity .*{message}"):
        so3(matrix)


def test_spaces_that_have_no_such_metric_are_refused():
    for wrong in (
        SpecialOrthogonal(2, equip=False),
        SpecialOrthogonal(3, point_type="vector", equip=False),
        PoseSpace(1),
    ):
        with pytest.raises(ValueError, match="SpecialOrthogonal"):
            wrong.equip_with_metric(SO3InvariantMetric)
    with pytest.raises(ValueError, match="PoseSpace"):
        SpecialOrthogonal(3, equip=False).equip_with_metric(PoseMetric)
    with pytest.raises(ValueError, match="3 bones.*parameters for 2"):
        PoseSpace(3).equip_with_metric(PoseMetric, parameters=MetricParameters.identity(2))
    with pytest.raises(ValueError, match="True or False"):
        so3(left="right")
    with pytest.raises(ValueError, match="n_bones"):
        PoseSpace(0)


def test_a_space_keeps_the_metrics_it_had_apart(rng):
    space = so3(DIAGONAL)
    first = space.metric
    a, b = rotations(rng, 2)
    before = first.dist(a, b)
    space.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=FULL, left=False)
    assert first.dist(a, b) == before != space.metric.dist(a, b)


# failures


@pytest.fixture
def failing(monkeypatch):
    """Let the solver fail for the problems at the given places."""
    from geomstats_anim.geodesics import pose_geodesics as geodesics

    search = geodesics.shortest_momenta

    def fail_at(*places):
        def search_and_fail(moments, vector, *rest):
            found = search(moments, vector, *rest)
            for place, status in places:
                found.status[place], found.energy[place] = status, np.inf
            return found

        monkeypatch.setattr(geodesics, "shortest_momenta", search_and_fail)

    return fail_at


def test_failed_logarithms_are_named(rng, failing):
    space = pose_space()
    base, point = rotations(rng, 2, 4, 3)
    failing((5, LogStatus.STALLED), (10, LogStatus.MAX_ITERATIONS))
    result = space.metric.log_solver.solve(point, base)
    assert result.status[1, 2] == LogStatus.STALLED and result.status[3, 1] == LogStatus.MAX_ITERATIONS
    assert (result.status != LogStatus.CONVERGED).sum() == 2
    assert np.isinf(result.length[1, 2]) and not result.tangent_vec[1, 2].any()
    assert np.isfinite(result.tangent_vec).all()
    sentences = [str(LogStatus.STALLED), str(LogStatus.MAX_ITERATIONS)]
    for call in (
        lambda: space.metric.log(point, base),
        lambda: space.metric.dist(base, point),
        lambda: space.metric.geodesic(base, end_point=point),
    ):
        with pytest.raises(RuntimeError) as error:
            call()
        message = str(error.value)
        assert "[1, 2], [3, 1]." in message and all(sentence in message for sentence in sentences)


def test_many_failed_logarithms_are_counted(rng, failing):
    base, point = rotations(rng, 2, 9)
    failing(*((place, LogStatus.STALLED) for place in range(7)))
    with pytest.raises(RuntimeError, match=r"for \[0\], \[1\], \[2\], \[3\], \[4\] and 2 more\."):
        so3().metric.log(point, base)
    with pytest.raises(RuntimeError, match="for the pair"):
        failing((0, LogStatus.STALLED))
        so3().metric.log(point[0], base[0])


# the space


def test_pose_space_is_a_group_of_its_shape():
    space = PoseSpace(2)
    assert (space.n_bones, space.dim, space.shape, space.point_ndim) == (2, 6, (2, 3, 3), 3)
    assert isinstance(space.metric, PoseMetric) and not hasattr(PoseSpace(2, equip=False), "metric")
    assert space.belongs(space.identity)
    points = space.random_point(5)
    assert not space.belongs(points[:, :1]).any() and not space.belongs(2.0 * points).any()
    assert space.belongs(points.reshape(5, 1, 2, 3, 3)).shape == (5, 1)
    vec = space.random_tangent_vec()
    assert space.is_tangent(vec) and space.is_tangent(points @ vec, points).all()
    right = space.tangent_translation_map(points, left=False, inverse=True)
    np.testing.assert_allclose(right(vec @ points), np.broadcast_to(vec, points.shape), atol=1e-14)
