"""The quaternion helpers against scipy, and by their laws."""

import numpy as np
import pytest
import samples
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geomstats_anim import rotations as quat

pytestmark = pytest.mark.filterwarnings("error")

TINY = [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4]


@pytest.fixture
def three():
    return samples.quaternions(np.random.default_rng(0), 3, 500)


def same(one, other, tolerance=1e-15):
    """Same rotations, up to rounding."""
    return quat.distance(one, other).max() < 4.0 * tolerance


def test_group_laws(three):
    a, b, c = three
    assert same(quat.multiply(quat.multiply(a, b), c), quat.multiply(a, quat.multiply(b, c)))
    assert same(quat.multiply(a, quat.conjugate(a)), quat.IDENTITY)
    np.testing.assert_array_equal(quat.multiply(a, quat.IDENTITY), a)
    np.testing.assert_array_equal(quat.difference(a, b), quat.log(quat.multiply(quat.conjugate(a), b)))
    assert same(quat.conjugate(quat.multiply(a, b)), quat.multiply(quat.conjugate(b), quat.conjugate(a)))


def test_agreement_with_scipy(three):
    a, b, _ = three
    vectors = np.random.default_rng(1).normal(size=(500, 3))
    np.testing.assert_allclose(quat.rotate(a, vectors), Rotation.from_quat(a).apply(vectors), atol=1e-14)
    np.testing.assert_allclose(quat.to_matrix(a), Rotation.from_quat(a).as_matrix(), atol=1e-15)
    np.testing.assert_allclose(quat.log(a), Rotation.from_quat(a).as_rotvec(), atol=1e-14)
    np.testing.assert_allclose(quat.exp(vectors), Rotation.from_rotvec(vectors).as_quat(canonical=False), atol=1e-15)
    product = Rotation.from_quat(a) * Rotation.from_quat(b)
    assert same(quat.multiply(a, b), product.as_quat())
    np.testing.assert_allclose(quat.distance(a, b), (Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude())


@pytest.mark.parametrize("shape", [(), (0,), (7,), (2, 0, 3), (2, 3, 4)])
def test_any_batch_shape(shape):
    rng = np.random.default_rng(2)
    a, b, v = samples.quaternions(rng, *shape), samples.quaternions(rng, *shape), rng.normal(size=(*shape, 3))
    for value, tail in [
        (quat.multiply(a, b), (4,)),
        (quat.rotate(a, v), (3,)),
        (quat.exp(v), (4,)),
        (quat.log(a), (3,)),
        (quat.distance(a, b), ()),
        (quat.slerp(a, b, np.full(shape, 0.3)), (4,)),
        (quat.to_matrix(a), (3, 3)),
    ]:
        assert value.shape == shape + tail
    if shape:
        assert quat.from_matrix(quat.to_matrix(a)).shape == a.shape


@pytest.mark.parametrize("angle", [*TINY, 1.0, 3.0, np.pi - 1e-8, np.pi - 1e-15])
def test_log_after_exp(angle):
    vector = angle * samples.unit_vectors(np.random.default_rng(3), 100)
    np.testing.assert_allclose(quat.log(quat.exp(vector)), vector, rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(
        quat.angle(quat.exp(vector)), np.full(100, angle), rtol=1e-14, atol=1e-150
    )  # squares underflow


@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 1e-6))
def test_exp_after_log(components):
    q = quat.normalize(np.array(components))
    vector = quat.log(q)
    assert np.linalg.norm(vector) <= np.pi * (1.0 + 1e-15)
    assert same(quat.exp(vector), q)
    assert same(quat.exp(quat.log(-q)), q)


def test_log_of_half_a_turn_keeps_the_axis_given():
    for axis in (np.eye(3)[0], -np.eye(3)[1], np.array([0.6, 0.0, -0.8])):
        np.testing.assert_allclose(quat.log(np.append(axis, 0.0)), np.pi * axis, rtol=1e-15)


@pytest.mark.parametrize("angle", [*TINY, 1.0, np.pi - 1e-9, np.pi])
def test_matrix_round_trip(angle):
    q = quat.exp(angle * np.concatenate([samples.unit_vectors(np.random.default_rng(4), 100), np.eye(3), -np.eye(3)]))
    matrix = quat.to_matrix(q)
    assert np.abs(matrix @ np.swapaxes(matrix, -1, -2) - np.eye(3)).max() < 1e-14
    assert same(quat.from_matrix(matrix), q)


def test_make_continuous():
    rng = np.random.default_rng(5)
    smooth = quat.exp(np.linspace(0.0, 20.0, 200)[:, None, None] * samples.unit_vectors(rng, 3))
    flipped = smooth * rng.choice([-1.0, 1.0], (200, 3, 1))
    flipped[0] = smooth[0]
    np.testing.assert_array_equal(quat.make_continuous(flipped), smooth)
    np.testing.assert_array_equal(quat.make_continuous(np.swapaxes(flipped, 0, 1), axis=1), np.swapaxes(smooth, 0, 1))
    assert quat.make_continuous(flipped[:0]).shape == (0, 3, 4)


def test_slerp_turns_steadily_the_shorter_way(three):
    a, b, _ = three
    for t in (0.0, 0.2, 0.5, 1.0):
        pose = quat.slerp(a, b, np.full(500, t))
        np.testing.assert_allclose(quat.distance(a, pose), t * quat.distance(a, b), atol=1e-14)
        np.testing.assert_allclose(quat.distance(pose, b), (1.0 - t) * quat.distance(a, b), atol=1e-14)
        assert same(quat.slerp(a, -b, np.full(500, t)), pose)
    np.testing.assert_array_equal(quat.slerp(a, b, np.zeros(500)), a)
