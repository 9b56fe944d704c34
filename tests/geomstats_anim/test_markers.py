"""Markers: where scales, parents and the placement of the skeleton bring them, against plain matrices."""

from dataclasses import replace

import numpy as np
import pytest
import samples
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, compress, interpolate, optimal_keyframes
from geomstats_anim.criteria import location_errors
from geomstats_anim.kinematics import world_pose
from geomstats_anim.markers import Markers, joint_matrices, joint_places, world_errors


def affine(linear, offset):
    return np.block([[linear, np.reshape(offset, (3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])


def placed_by_hand(animation):
    """4 x 4 matrices of every joint, one after the other."""
    found = np.zeros((animation.n_frames, animation.n_joints, 4, 4))
    for f in range(animation.n_frames):
        for b, parent in enumerate(animation.skeleton.parents):
            scale = np.ones(3) if animation.scales is None else animation.scales[f, b]
            turn = Rotation.from_quat(animation.rotations[f, b]).as_matrix()
            above = np.eye(4) if animation.world is None else np.vstack([animation.world[f], [0, 0, 0, 1]])
            local = affine(turn @ np.diag(scale), animation.translations[f, b])
            found[f, b] = (above if parent < 0 else found[f, parent]) @ local
    return found


def bent(animation, rng):
    """The same motion with scales of any sign, and a placement that is not rigid and changes."""
    shape = (animation.n_frames, animation.n_joints, 3)
    scales = rng.uniform(0.5, 3.0, shape) * rng.choice([-1.0, 1.0], shape)
    scales[0, 1] = 0.0
    return replace(animation, scales=scales, world=rng.normal(size=(animation.n_frames, 3, 4)))


def test_matrices_of_joints():
    rng = np.random.default_rng(0)
    animation = bent(samples.animation(rng, 5, 4), rng)
    np.testing.assert_allclose(joint_matrices(animation), placed_by_hand(animation)[:, :, :3], atol=1e-12)


@pytest.mark.parametrize("joints", [[4], [3, 0], [1, 1, 2], []])
def test_places_of_some_joints_are_those_of_all(joints):
    rng = np.random.default_rng(0)
    plain = samples.animation(rng, 5, 4)
    for animation in (plain, bent(plain, rng)):
        joints = np.array(joints, dtype=np.intp) % animation.n_joints
        places = joint_places(animation, joints)
        np.testing.assert_array_equal(places, joint_matrices(animation)[:, joints][..., 3])


def test_without_scales_they_are_those_of_the_papers():
    rng = np.random.default_rng(1)
    animation = samples.animation(rng, 6, 5)
    pose = world_pose(animation)
    places = Markers.of_bones(animation.skeleton).places(joint_matrices(animation))
    np.testing.assert_allclose(places, np.concatenate([pose.origins, pose.ends], axis=1), atol=1e-13)


def test_skin_is_blended_linearly():
    rng = np.random.default_rng(2)
    animation = bent(samples.animation(rng, 3, 4), rng)
    joints, offsets = np.array([[2, 0, 1], [3, 1, 0]]), rng.normal(size=(2, 3, 3))
    weights = np.array([[0.2, 0.7, 0.1], [0.5, 0.5, 0.0]])
    markers = Markers(joints, offsets, weights)
    matrices = placed_by_hand(animation)
    homogeneous = np.concatenate([offsets, np.ones((2, 3, 1))], axis=-1)
    expected = np.einsum("pi,fpirc,pic->fpr", weights, matrices[:, joints], homogeneous)[..., :3]
    np.testing.assert_allclose(markers.places(joint_matrices(animation)), expected, atol=1e-12)
    assert markers.owners.tolist() == [0, 3]


def test_errors_are_the_largest_of_each_joint_in_the_placement_of_the_reference():
    rng = np.random.default_rng(3)
    reference = bent(samples.animation(rng, 4, 3), rng)
    other = replace(bent(samples.animation(rng, 4, 3), rng), world=None)
    markers = Markers.of_bones(reference.skeleton)
    truth, ours = (placed_by_hand(each)[:, :, :3] for each in (reference, replace(other, world=reference.world)))
    distances = np.linalg.norm(markers.places(np.array(ours)) - markers.places(np.array(truth)), axis=-1)
    np.testing.assert_allclose(
        world_errors(other, reference), np.maximum(distances[:, :3], distances[:, 3:]), rtol=1e-12
    )
    some = markers.chosen(markers.owners == 1)
    assert (world_errors(other, reference, some)[:, [0, 2]] == 0.0).all()


@pytest.mark.parametrize("unit", [0.01, 1.0, 100.0])
def test_a_uniform_placement_scales_all_errors(unit):
    rng = np.random.default_rng(4)
    reference, other = samples.animation(rng, 4, 3), samples.animation(rng, 4, 3)
    errors = world_errors(other, reference)
    assert (errors >= location_errors(other, reference) - 1e-12).all()
    turn = Rotation.random(random_state=0).as_matrix() @ np.diag([1.0, 1.0, -1.0])
    placed = replace(reference, world=np.tile(affine(unit * turn, [1.0, 2.0, 3.0])[:3], (4, 1, 1)))
    np.testing.assert_allclose(world_errors(other, placed), unit * errors, rtol=1e-9)


def test_a_shell_sees_twists():
    skeleton = samples.skeleton(2)
    angles = np.linspace(0.0, 1.0, 4)
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (4, 2, 1))
    turns[:, 1] = Rotation.from_rotvec(angles[:, None] * [0.0, 1.0, 0.0]).as_quat()  # about its own bone
    twisted = Animation(skeleton, np.arange(4.0), turns, np.tile(skeleton.rest_translations, (4, 1, 1)))
    still = replace(twisted, rotations=np.tile([0.0, 0.0, 0.0, 1.0], (4, 2, 1)))
    assert world_errors(still, twisted).max() < 1e-12
    shell = world_errors(still, twisted, Markers.of_shell(twisted, 0.03))
    np.testing.assert_allclose(shell[:, 1], 0.06 * np.sin(angles / 2.0), atol=1e-12)


def test_a_shell_has_its_radius_in_the_world():
    rng = np.random.default_rng(5)
    animation = bent(samples.animation(rng, 3, 4), rng)
    animation = replace(animation, scales=np.where(animation.scales == 0.0, 1.0, animation.scales))
    markers = Markers.of_shell(animation, 0.05)
    matrices = joint_matrices(animation)
    distance = np.linalg.norm(markers.places(matrices)[0] - matrices[0, markers.owners, :, 3], axis=-1)
    np.testing.assert_allclose(distance[2 * animation.n_joints :], 0.05, rtol=1e-9)


def test_sets_with_other_numbers_of_joints_are_joined():
    one = Markers.on_joints(np.array([1]), np.array([[1.0, 2.0, 3.0]]))
    skin = Markers(np.array([[0, 2]]), np.ones((1, 2, 3)), np.array([[0.25, 0.75]]))
    both = one.joined(skin)
    rng = np.random.default_rng(6)
    matrices = joint_matrices(samples.animation(rng, 2, 3))
    np.testing.assert_array_equal(both.places(matrices)[:, :1], one.places(matrices))
    np.testing.assert_array_equal(both.places(matrices)[:, 1:], skin.places(matrices))
    assert both.owners.tolist() == [1, 2]


def swinging(rng, n_frames=60):
    """A smooth chain whose middle joint is large, under a parent that is stretched and grows."""
    skeleton = samples.skeleton(3)
    t = np.linspace(0.0, 2.0, n_frames)
    turns = 0.4 * np.sin(t[:, None, None] * rng.uniform(1.0, 4.0, (1, 3, 3)))
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(n_frames, 3, 4)
    scales = np.ones((n_frames, 3, 3))
    scales[:, 1] = [1.0, 40.0, 1.0]
    world = np.zeros((n_frames, 3, 4))
    world[:, :, :3] = np.diag([1.0, 1.0, 10.0]) * (0.1 + t)[:, None, None]
    translations = np.tile(skeleton.rest_translations, (n_frames, 1, 1))
    return Animation(skeleton, t, rotations, translations, scales, world)


@pytest.mark.parametrize("scheme", ["slerp", "geodesic-spline"])
@pytest.mark.parametrize("tolerance", [0.3, 0.03])
def test_a_tolerance_holds_in_the_world(scheme, tolerance):
    animation = swinging(np.random.default_rng(7))
    for markers in (Markers.of_bones(animation.skeleton), Markers.of_shell(animation)):
        keys = optimal_keyframes(animation, tolerance=tolerance, scheme=scheme, markers=markers)
        rebuilt = interpolate(animation.at_frames(keys), animation.times, scheme)
        worst = world_errors(rebuilt, animation, markers).max()
        assert 0.1 * tolerance < worst <= tolerance
        assert len(keys) < animation.n_frames
    plain = replace(animation, scales=None, world=None)
    assert len(optimal_keyframes(plain, tolerance=tolerance, scheme=scheme)) < len(keys)


def test_compressing_takes_the_markers():
    animation = swinging(np.random.default_rng(8))
    markers = Markers.of_shell(animation, 0.1)
    few = compress([animation], tolerance=0.2)
    more = compress([animation], tolerance=0.2, markers=markers)
    rebuilt = interpolate(animation.at_frames(more.keyframes[0]), animation.times, metric=more.metric)
    assert world_errors(rebuilt, animation, markers).max() <= 0.2
    assert len(few.keyframes[0]) <= len(more.keyframes[0])
