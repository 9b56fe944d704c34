"""Laws of the kinetic energy on SE(3)."""

import numpy as np
import pytest
from geomstats.geometry.special_euclidean import SpecialEuclidean, SpecialEuclideanMatricesCanonicalLeftMetric
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from scipy.spatial.transform import Rotation

from geomstats_anim.riemannian.rigid_motion import RigidMotionMetric

INERTIA = np.array([[2.0, 0.3, 0.1], [0.3, 1.0, 0.0], [0.1, 0.0, 2.5]])
CENTER = np.array([0.2, -0.1, 0.4])


def se3(**numbers):
    return SpecialEuclidean(3, equip=False).equip_with_metric(RigidMotionMetric, **numbers)


@pytest.fixture
def space():
    np.random.seed(0)
    return se3(inertia=INERTIA, mass=3.0, center=CENTER)


def test_log_is_undone_by_exp_in_batches(space):
    base, points = space.random_point(), space.random_point(5)
    vector = space.metric.log(points, base)
    np.testing.assert_allclose(space.metric.exp(vector, base), points, atol=1e-10)
    assert space.is_tangent(vector, np.broadcast_to(base, vector.shape), atol=1e-9).all()
    path = space.metric.geodesic(base, end_point=points)([0.0, 0.4, 1.0])
    assert path.shape == (5, 3, 4, 4)
    np.testing.assert_allclose(path[:, 2], points, atol=1e-10)
    np.testing.assert_allclose(path[:, 1], space.metric.exp(0.4 * vector, base), atol=1e-10)


def test_distances_are_left_invariant_and_symmetric(space):
    a, b, c = space.random_point(3)
    dist = space.metric.dist(a, b)
    assert space.metric.dist(c @ a, c @ b) == pytest.approx(dist, rel=1e-9)
    assert space.metric.dist(b, a) == pytest.approx(dist, rel=1e-9)
    assert space.metric.dist(a, c) <= dist + space.metric.dist(b, c) + 1e-9


def test_the_identity_is_geomstats_canonical_metric():
    np.random.seed(1)
    ours = se3(inertia=2.0 * np.eye(3))
    stock = SpecialEuclidean(3, equip=False).equip_with_metric(SpecialEuclideanMatricesCanonicalLeftMetric)
    base, point = ours.random_point(2)
    np.testing.assert_allclose(ours.metric.log(point, base), stock.metric.log(point, base), atol=1e-7)
    assert ours.metric.dist(base, point) == pytest.approx(float(stock.metric.dist(base, point)), rel=1e-7)


def test_the_length_is_the_kinetic_energy_of_point_masses():
    rng = np.random.default_rng(2)
    masses, places = rng.uniform(0.5, 2.0, 6), rng.normal(size=(6, 3))
    mass, center = masses.sum(), masses @ places / masses.sum()
    arms = places - center
    inertia = (masses * (arms**2).sum(axis=1)).sum() * np.eye(3) - np.einsum("n,ni,nj->ij", masses, arms, arms)
    space = se3(inertia=inertia, mass=mass, center=center)
    base = space.random_point()
    w, v = rng.normal(size=(2, 3))
    hat = -np.cross(w, np.eye(3))
    vector = np.zeros((4, 4))
    vector[:3, :3], vector[:3, 3] = base[:3, :3] @ hat, v
    speeds = v + places @ vector[:3, :3].T
    assert space.metric.squared_norm(vector, base) == pytest.approx((masses * (speeds**2).sum(axis=1)).sum(), rel=1e-12)


def test_a_free_body_keeps_its_momenta(space):
    base = space.random_point()
    vector = space.metric.log(space.random_point(), base)
    step = 1e-4
    times = np.array([0.2, 0.8])
    momenta = []
    for time in times:
        before, now, after = space.metric.geodesic(base, initial_tangent_vec=vector)([time - step, time, time + step])
        rate = (after - before) / (2.0 * step)
        seen = now[:3, :3].T @ rate[:3, :3]
        w = np.array([seen[2, 1], seen[0, 2], seen[1, 0]])
        linear = 3.0 * (rate[:3, 3] + rate[:3, :3] @ CENTER)
        momenta.append(np.concatenate([linear, now[:3, :3] @ INERTIA @ w]))
    np.testing.assert_allclose(momenta[0], momenta[1], atol=1e-6)


def test_the_origin_bends_with_the_rotation(space):
    """A half turn about the center of mass, which stays: the origin goes round it in a half circle."""
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_rotvec([0.0, 0.0, np.pi - 1e-6]).as_matrix()
    lever = se3(center=[1.0, 0.0, 0.0])
    start, end = np.eye(4), turn.copy()
    end[:3, 3] = np.array([1.0, 0.0, 0.0]) - turn[:3, :3] @ [1.0, 0.0, 0.0]
    middle = lever.metric.geodesic(start, end_point=end)(0.5)[0]
    np.testing.assert_allclose(middle[:3, 3], [1.0, -1.0, 0.0], atol=1e-5)


def test_bad_numbers_are_refused():
    with pytest.raises(ValueError, match="mass is -1"):
        se3(mass=-1.0)
    with pytest.raises(ValueError, match="center has shape"):
        se3(center=[1.0, 2.0])
    with pytest.raises(ValueError, match="positive definite"):
        se3(inertia=np.diag([1.0, -1.0, 1.0]))
    with pytest.raises(ValueError, match=r"needs SpecialEuclidean\(3\)"):
        RigidMotionMetric(SpecialOrthogonal(3, equip=False))
    assert repr(se3().metric).startswith("RigidMotionMetric(mass 1, center [0.0, 0.0, 0.0], inertia [[1., 0., 0.]")
