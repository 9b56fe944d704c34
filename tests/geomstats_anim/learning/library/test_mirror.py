"""Laws of mirror images."""

import numpy as np
import pytest
from gaits import biped, gait

from geomstats_anim import Skeleton
from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import place
from geomstats_anim.learning.library.mirror import mirror_of

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
