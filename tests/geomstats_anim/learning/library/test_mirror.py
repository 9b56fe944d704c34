"""Laws of mirror images."""

import numpy as np
import pytest
from gaits import biped, gait

from geomstats_anim import Animation, Skeleton, interpolate, learn_library
from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import place
from geomstats_anim.learning.library.mirror import mirror_of, usual_pose
from geomstats_anim.learning.library.parts import body_parts

UP = np.array([0.0, 1.0, 0.0])


def renamed(skeleton, change):
    joints = ["/".join(map(change, joint.split("/"))) for joint in skeleton.joints]
    return Skeleton(joints, skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)


def with_turned_frames(skeleton):
    """Turn the frames of all joints at random; the bones stay where they are."""
    frames = quat.exp(np.random.default_rng(0).normal(size=(skeleton.n_joints, 3)))
    rotations, translations = frames.copy(), skeleton.rest_translations.copy()
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            back = quat.conjugate(frames[parent])
            rotations[joint] = quat.multiply(back, frames[joint])
            translations[joint] = quat.rotate(back, translations[joint])
    return Skeleton(skeleton.joints, skeleton.parents, translations, rotations)


@pytest.mark.parametrize("rig", [biped(), with_turned_frames(biped())])
def test_joints_are_where_those_of_the_other_side_are_in_a_mirror(rig):
    rng, mirror = np.random.default_rng(1), mirror_of(rig, UP)
    rotations = quat.exp(rng.normal(size=(5, rig.n_joints, 3)))
    translations = np.broadcast_to(rig.rest_translations, (5, rig.n_joints, 3)) + 0.1 * rng.normal(size=(5, 1, 3))
    other = np.einsum("bij,fbj->fbi", mirror.parent_frames, translations)[:, mirror.counterpart]
    origins = place(rig, rotations, translations).origins
    mirrored = place(rig, mirror.rotations(rotations), other).origins
    np.testing.assert_allclose(mirrored, (origins * [-1.0, 1.0, 1.0])[:, mirror.counterpart], atol=1e-12)


def test_the_image_of_an_image_is_the_motion():
    clip, mirror = gait(1), mirror_of(biped(), UP)
    twice = mirror.animation(mirror.animation(clip))
    np.testing.assert_allclose(quat.distance(twice.rotations, clip.rotations), 0.0, atol=1e-7)
    np.testing.assert_allclose(twice.translations, clip.translations, atol=1e-12)


def test_vectors_of_rotation_are_mirrored_as_rotations_are():
    rig = with_turned_frames(biped())
    mirror, rng = mirror_of(rig, UP), np.random.default_rng(2)
    rotations, vectors = (quat.exp(rng.normal(size=(4, 16, 3))), 0.5 * rng.normal(size=(4, 16, 3)))
    turned = quat.multiply(rotations, quat.exp(vectors))
    expected = quat.multiply(mirror.rotations(rotations), quat.exp(mirror.rotation_vectors(vectors)))
    np.testing.assert_allclose(quat.distance(mirror.rotations(turned), expected), 0.0, atol=1e-7)


def with_axes_of_sides(clip):
    """Give the joints of a clip axes as rigs have them, and a rest pose without any rotation, which has no sides."""
    axes = np.tile(quat.IDENTITY, (clip.n_joints, 1))
    names = [joint.split("/")[-1] for joint in clip.skeleton.joints]
    for joint, name in enumerate(names):
        around = [0.0, np.pi, 0.0] if name.endswith("_R") else [0.0, np.pi / 2, 0.0] if name == "chest" else [0.0] * 3
        axes[joint] = quat.exp(np.array(around))
    parents = clip.skeleton.parents
    above = np.where((parents >= 0)[:, None], axes[parents], quat.IDENTITY)
    offsets = quat.rotate(quat.conjugate(above), clip.skeleton.rest_translations)
    rig = Skeleton(clip.skeleton.joints, parents, offsets, np.tile(quat.IDENTITY, (clip.n_joints, 1)))
    rotations = quat.multiply(quat.multiply(quat.conjugate(above), clip.rotations), axes)
    moved = quat.rotate(quat.conjugate(above), clip.translations)
    return Animation(rig, clip.times, quat.make_continuous(rotations), moved)


def test_a_rest_pose_without_sides_is_mirrored_by_the_usual_pose():
    clip = gait(1)
    other, plain = with_axes_of_sides(clip), mirror_of(biped(), UP)
    assert mirror_of(other.skeleton, UP) is None
    mirror = mirror_of(other.skeleton, UP, usual_pose(other.rotations))
    expected = with_axes_of_sides(plain.animation(clip)).rotations
    heading = body_parts(biped()).trunk  # the plane between the sides may be any that is upright
    found = np.delete(mirror.rotations(other.rotations), heading, axis=1)
    np.testing.assert_allclose(quat.distance(found, np.delete(expected, heading, axis=1)), 0.0, atol=1e-7)
    up = quat.rotate(quat.conjugate(mirror.rotations(other.rotations)[:, 0]), UP)
    np.testing.assert_allclose(up, quat.rotate(quat.conjugate(expected[:, 0]), UP), atol=1e-12)


def test_a_usual_pose_that_leans_to_a_side_has_no_mirror():
    other = with_axes_of_sides(gait(1))
    leaning = usual_pose(other.rotations)
    leaning[4] = quat.multiply(leaning[4], quat.exp(np.array([0.0, 0.9, 0.0])))
    assert mirror_of(other.skeleton, UP, leaning) is None


def test_a_library_without_sides_at_rest_treats_both_alike():
    clips = [with_axes_of_sides(gait(seed)) for seed in range(1, 7)]
    library = learn_library(clips, gaps=(4, 8))
    keys = with_axes_of_sides(gait(40))
    keys = keys.at_frames(np.arange(0, 80, 4))
    mirror = mirror_of(keys.skeleton, UP, library.usual)
    curves = [
        interpolate(each, each.times[:-1] + 0.03, "learned", library=library) for each in (keys, mirror.animation(keys))
    ]
    assert interpolate(keys, curves[0].times, "geodesic-spline").rotations.tolist() != curves[0].rotations.tolist()
    np.testing.assert_allclose(
        quat.distance(mirror.rotations(curves[0].rotations), curves[1].rotations), 0.0, atol=1e-6
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda name: name.replace("_L", "_l").replace("_R", "_r"),
        lambda name: {"L": "l", "R": "r"}.get(name[-1], "") + name.removesuffix("_L").removesuffix("_R"),
        lambda name: (
            {"L": "rig:Left", "R": "rig:Right"}.get(name[-1], "rig:") + name.removesuffix("_L").removesuffix("_R")
        ),
        lambda name: name.replace("_L", ".L.001").replace("_R", ".R.001"),
    ],
)
def test_sides_are_told_by_names(change):
    mirror = mirror_of(renamed(biped(), change), UP)
    np.testing.assert_array_equal(mirror.counterpart, mirror_of(biped(), UP).counterpart)


def test_what_has_no_sides_has_no_mirror():
    skeleton = biped()
    assert mirror_of(renamed(skeleton, lambda name: name.replace("_L", "1").replace("_R", "2")), UP) is None
    lame = skeleton.rest_translations.copy()
    lame[11] = [0.3, -0.4, 0.0]
    assert mirror_of(Skeleton(skeleton.joints, skeleton.parents, lame, skeleton.rest_rotations), UP) is None
