"""Forward kinematics against matrices multiplied joint by joint, and its derivative against finite differences."""

import dataclasses

import numpy as np
import pytest
import samples
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, Skeleton
from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import breadth_first, place, pull_back_ends, world_pose

TREES = {
    "one joint": (-1,),
    "chain": (-1, 0, 1, 2, 3),
    "depth first": (-1, 0, 1, 2, 1, 0, 5, 0),
    "several roots": (-1, -1, 1, 0, 2, -1, 3),
}


@pytest.fixture(params=list(TREES))
def animation(request):
    rng = np.random.default_rng(0)
    parents = TREES[request.param]
    n = len(parents)
    skeleton = Skeleton(
        [f"joint{i}" for i in range(n)],
        parents,
        rng.normal(size=(n, 3)),
        samples.quaternions(rng, n),
        rng.normal(size=(n, 3)),
    )
    return Animation(skeleton, np.arange(4), samples.quaternions(rng, 4, n), rng.normal(size=(4, n, 3)))


def naive(animation, frame, joint):
    """World rotation matrix and origin of a joint, by recursion."""
    turn = Rotation.from_quat(animation.rotations[frame, joint]).as_matrix()
    shift = animation.translations[frame, joint]
    parent = animation.skeleton.parents[joint]
    if parent < 0:
        return turn, shift
    parent_turn, parent_origin = naive(animation, frame, parent)
    return parent_turn @ turn, parent_origin + parent_turn @ shift


def test_every_joint_is_where_recursion_puts_it(animation):
    pose = world_pose(animation)
    for frame, joint in np.ndindex(animation.n_frames, animation.n_joints):
        turn, origin = naive(animation, frame, joint)
        np.testing.assert_allclose(quat.to_matrix(pose.rotations[frame, joint]), turn, atol=1e-14)
        np.testing.assert_allclose(pose.origins[frame, joint], origin, atol=1e-13)
        end = origin + turn @ animation.skeleton.bone_ends[joint]
        np.testing.assert_allclose(pose.ends[frame, joint], end, atol=1e-13)


def test_levels_come_one_after_the_other(animation):
    order = breadth_first(animation.skeleton)
    assert sorted(order) == list(range(animation.n_joints))
    assert (np.diff(animation.skeleton.depths[order]) >= 0).all()


def test_the_order_of_joints_means_nothing(animation):
    """Sort the joints by depth: another order in which parents come first."""
    skeleton = animation.skeleton
    order = breadth_first(skeleton)
    place_of = np.argsort(order)
    sorted_skeleton = Skeleton(
        [skeleton.joints[i] for i in order],
        [-1 if skeleton.parents[i] < 0 else place_of[skeleton.parents[i]] for i in order],
        skeleton.rest_translations[order],
        skeleton.rest_rotations[order],
        skeleton.bone_ends[order],
    )
    by_level = Animation(
        sorted_skeleton, animation.times, animation.rotations[:, order], animation.translations[:, order]
    )
    for mine, theirs in zip(world_pose(animation), world_pose(by_level), strict=True):
        # an animation makes its quaternions unit once more, to rounding
        np.testing.assert_allclose(mine[:, order], theirs, atol=1e-14)


def test_torques_and_pulls_are_the_derivative_of_any_function_of_bone_ends(animation):
    rng = np.random.default_rng(1)
    phase = rng.normal(size=(4, animation.n_joints, 3))
    couple = rng.normal(size=(animation.n_joints, animation.n_joints))

    def function(ends):
        """One that couples joints: sum of u C sin(u), u = ends + phase."""
        u = ends + phase
        return np.einsum("fbi,bc,fci->", u, couple, np.sin(u))

    def at(rotations, translations):
        return function(place(animation.skeleton, rotations, translations).ends)

    pose = world_pose(animation)
    u = pose.ends + phase
    forces = np.einsum("bc,fci->fbi", couple, np.sin(u)) + np.cos(u) * np.einsum("fbi,bc->fci", u, couple)
    torques, pulls = pull_back_ends(animation.skeleton, pose, forces)
    step = 1e-5
    by_turn, by_shift = np.empty_like(torques), np.empty_like(pulls)
    for index in np.ndindex(torques.shape):
        turned, shifted = [], []
        for sign in (1.0, -1.0):
            turn = np.zeros(3)
            turn[index[2]] = sign * step
            rotations = animation.rotations.copy()
            rotations[index[:2]] = quat.multiply(rotations[index[:2]], quat.exp(turn))
            turned.append(at(rotations, animation.translations))
            translations = animation.translations.copy()
            translations[index] += sign * step
            shifted.append(at(animation.rotations, translations))
        by_turn[index] = (turned[0] - turned[1]) / (2.0 * step)
        by_shift[index] = (shifted[0] - shifted[1]) / (2.0 * step)
    for found, expected in ((torques, by_turn), (pulls, by_shift)):
        np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())


def test_forces_are_not_changed_and_none_make_no_torque(animation):
    pose = world_pose(animation)
    forces = np.zeros_like(pose.ends)
    assert not np.any(pull_back_ends(animation.skeleton, pose, forces))
    forces[:] = 1.0
    pull_back_ends(animation.skeleton, pose, forces)
    assert (forces == 1.0).all()


def test_no_frames_and_scales(animation):
    none = place(animation.skeleton, animation.rotations[:0], animation.translations[:0])
    assert none.ends.shape == (0, animation.n_joints, 3)
    scaled = dataclasses.replace(animation, scales=np.full((4, animation.n_joints, 3), 2.0))
    np.testing.assert_allclose(world_pose(scaled).ends, world_pose(animation).ends, atol=1e-14)
