import numpy as np
import pytest
from gaits import biped

from geomstats_anim import rotations as quat
from geomstats_anim.learning.library.context import contexts_of
from geomstats_anim.learning.library.parts import body_parts

SKELETON = biped()
PARTS = body_parts(SKELETON)
VERTICAL = np.array([0.0, 1.0, 0.0])


def clip(*shape):
    """Make keys at uneven times."""
    rng = np.random.default_rng(0)
    return np.cumsum(rng.uniform(0.1, 0.4, shape[-1])), quat.exp(rng.normal(size=(*shape, SKELETON.n_joints, 3)))


def assert_same(found, expected):
    for name in ("increments", "is_there", "poses"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-13)


@pytest.mark.parametrize("n_keys", [8, 9])
def test_segments_of_a_stride_have_the_surroundings_of_their_chain(n_keys):
    times, rotations = clip(n_keys)
    both = contexts_of(times, rotations, PARTS.trunk, VERTICAL, 2)
    assert len(both.poses) == n_keys - 2
    for first in (0, 1):
        chain = contexts_of(times[first::2], rotations[first::2], PARTS.trunk, VERTICAL)
        assert_same(both.at(slice(first, None, 2)), chain)


def test_leading_axes_are_taken_one_after_the_other():
    times, rotations = clip(3, 6)
    expected = [contexts_of(times, each, PARTS.trunk, VERTICAL) for each in rotations]
    assert_same(contexts_of(times, rotations, PARTS.trunk, VERTICAL), type(expected[0]).joined(expected))


def test_of_the_trunk_only_the_vertical_is_seen():
    times, rotations = clip(6)
    in_world, poses = np.eye(3), contexts_of(times, rotations, PARTS.trunk, VERTICAL).poses
    for joint in PARTS.trunk:
        in_world = in_world @ quat.to_matrix(rotations[:, joint])
        seen = VERTICAL @ in_world
        np.testing.assert_allclose(poses[:, joint, :3], 0.5 * (seen[:-1] + seen[1:]), atol=1e-13)
        assert not poses[:, joint, 3:].any()


def test_scales_are_root_mean_squares_of_increments_of_each_part():
    contexts = contexts_of(*clip(9), PARTS.trunk, VERTICAL)
    squares = (contexts.increments**2).sum(axis=-1)
    expected = [
        [np.sqrt(squares[i][there][:, joints].mean()) for joints in PARTS.joints]
        for i, there in enumerate(contexts.is_there)
    ]
    np.testing.assert_allclose(contexts.scales(PARTS), np.radians(1.0) + expected, atol=1e-13)


def test_a_joint_holds_where_it_is_the_same_at_both_keys():
    times, rotations = clip(6)
    rotations[2:4, 5] = rotations[2, 5]
    rotations[4, 5] = quat.multiply(rotations[3, 5], quat.exp(np.array([1e-5, 0.0, 0.0])))
    expected = np.zeros((5, SKELETON.n_joints), dtype=bool)
    expected[2, 5] = True
    np.testing.assert_array_equal(contexts_of(times, rotations, PARTS.trunk, VERTICAL).holds, expected)
