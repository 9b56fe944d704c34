"""The data model: what it keeps, what it refuses, and what it says then."""

import numpy as np
import pytest
import samples

from geomstats_anim import Animation, Skeleton
from geomstats_anim import rotations as quat
from geomstats_anim.animation import default_bone_ends

pytestmark = pytest.mark.filterwarnings("error")


def skeleton_values(**changes):
    values = {
        "joints": ["root", "root/a", "root/b"],
        "parents": [-1, 0, 0],
        "rest_translations": [[0, 0, 0], [0, 1, 0], [0, 3, 2]],
        "rest_rotations": np.tile(quat.IDENTITY, (3, 1)),
    }
    return {**values, **changes}


def animation_values(**changes):
    values = {
        "skeleton": samples.skeleton(2),
        "times": [0.0, 1.0, 2.5],
        "rotations": np.tile(quat.IDENTITY, (3, 2, 1)),
        "translations": np.zeros((3, 2, 3)),
    }
    return {**values, **changes}


def test_skeleton():
    skeleton = Skeleton(**skeleton_values(parents=[-1, 0, 1]))
    assert skeleton.joints == ("root", "root/a", "root/b")
    assert skeleton.n_joints == 3
    np.testing.assert_array_equal(skeleton.depths, [1, 2, 3])
    with pytest.raises(ValueError, match="read-only"):
        skeleton.rest_translations[0] = 1.0


def test_bone_ends():
    ends = Skeleton(**skeleton_values()).bone_ends
    np.testing.assert_allclose(ends, [[0, 2, 1], [0, 1, 0], [0, 3, 2]])
    ends = default_bone_ends([-1, 0, 0], [[0, 0, 0], [0, 2, 0], [0, 0, 0]], [9.0, 0.5, 7.0])
    np.testing.assert_allclose(ends, [[0, 1, 0], [0, 0.5, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"joints": ["a", "b", "a"]}, "Joint names must be unique, but 'a' is there twice."),
        ({"parents": [-1, 0]}, "parents has shape (2,), but there are 3 joints."),
        ({"parents": [-1, 2, 0]}, "Joint 'root/a' is number 1, but its parent is number 2."),
        ({"parents": [-2, 0, 0]}, "Joint 'root' is number 0, but its parent is number -2."),
        ({"rest_translations": np.zeros((3, 2))}, "rest_translations has shape (3, 2), but (3, 3) is needed."),
        ({"rest_rotations": np.zeros((3, 4))}, "rest_rotations has a quaternion of norm 0 at index (0,); normalise it"),
        ({"bone_ends": np.full((3, 3), np.nan)}, "bone_ends has a value that is not finite, nan, at index (0, 0)."),
    ],
)
def test_what_a_skeleton_refuses(changes, message):
    with pytest.raises(ValueError) as error:
        Skeleton(**skeleton_values(**changes))
    assert str(error.value).startswith(message)


def test_animation():
    rng = np.random.default_rng(0)
    motion = samples.animation(rng, 5, 2, scales=True)
    assert (motion.n_frames, motion.n_joints) == (5, 2)
    for values in (motion.times, motion.rotations, motion.translations, motion.scales):
        assert values.dtype == np.float64 and not values.flags.writeable
    assert (np.einsum("tbi,tbi->tb", motion.rotations[1:], motion.rotations[:-1]) >= 0.0).all()


def test_animation_copies_what_it_is_given():
    times = np.array([0.0, 1.0, 2.0])
    motion = Animation(**animation_values(times=times))
    times[0] = -5.0
    assert motion.times[0] == 0.0
    assert times.flags.writeable


def test_rotations_are_made_unit_and_continuous():
    turns = quat.exp(np.array([[[0.0, 0, 0]] * 2, [[1.0, 0, 0]] * 2, [[2.0, 0, 0]] * 2]))
    signs = np.array([1.0, -1.0, 1.0])[:, None, None]
    motion = Animation(**animation_values(rotations=1.005 * signs * turns))
    np.testing.assert_allclose(motion.rotations, turns, atol=1e-15)


@pytest.mark.parametrize("change", ["float32", "not contiguous", "read-only", "list"])
def test_arrays_of_every_kind(change):
    motion = samples.animation(np.random.default_rng(1), 4, 3)
    rotations = np.array(motion.rotations)
    if change == "float32":
        rotations = rotations.astype(np.float32)
    if change == "not contiguous":
        rotations = np.asfortranarray(rotations)
    if change == "read-only":
        rotations.setflags(write=False)
    if change == "list":
        rotations = rotations.tolist()
    again = Animation(motion.skeleton, motion.times, rotations, motion.translations)
    np.testing.assert_allclose(again.rotations, motion.rotations, atol=1e-7 if change == "float32" else 1e-15)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"times": [0.0, 2.0, 2.0]}, "times must increase, but time 1 is 2.0 and time 2 is 2.0."),
        ({"times": [0.0, 1.0, np.nan]}, "times has a value that is not finite, nan, at index (2,)."),
        ({"times": [[0.0, 1.0, 2.0]]}, "times has shape (1, 3), but (any) is needed."),
        ({"times": [0.0, 1.0]}, "rotations has shape (3, 2, 4), but (2, 2, 4) is needed."),
        (
            {"rotations": np.zeros((3, 2, 4))},
            "rotations has a quaternion of norm 0 at index (0, 0); normalise it first.",
        ),
        (
            {"rotations": np.full((3, 2, 4), np.inf)},
            "rotations has a value that is not finite, inf, at index (0, 0, 0).",
        ),
        ({"translations": np.zeros((3, 1, 3))}, "translations has shape (3, 1, 3), but (3, 2, 3) is needed."),
        ({"scales": np.zeros((3, 2))}, "scales has shape (3, 2), but (3, 2, 3) is needed."),
    ],
)
def test_what_an_animation_refuses(changes, message):
    with pytest.raises(ValueError) as error:
        Animation(**animation_values(**changes))
    assert str(error.value) == message


@pytest.mark.parametrize("frames", [[0, 2, 4], slice(0, 5, 2), np.array([0, 2, 4])])
@pytest.mark.parametrize("scales", [False, True])
def test_at_frames(frames, scales):
    motion = samples.animation(np.random.default_rng(2), 5, 2, scales=scales)
    some = motion.at_frames(frames)
    np.testing.assert_array_equal(some.times, motion.times[::2])
    np.testing.assert_array_equal(some.translations, motion.translations[::2])
    assert (some.scales is None) == (not scales)
    assert quat.distance(some.rotations, motion.rotations[::2]).max() < 1e-15


def test_no_joints_and_no_frames():
    empty = Animation(samples.skeleton(0), [], np.empty((0, 0, 4)), np.empty((0, 0, 3)))
    assert (empty.n_frames, empty.n_joints) == (0, 0)


def test_frames_may_be_a_mask():
    animation = samples.animation(np.random.default_rng(0), 6, 2, 20.0)
    mask = np.array([True, False, False, True, True, False])
    for frames in (mask, mask.tolist()):
        np.testing.assert_array_equal(animation.at_frames(frames).times, animation.times[[0, 3, 4]])
    with pytest.raises(ValueError, match=r"^The mask of frames has shape \(5,\), but there are 6 frames[.]$"):
        animation.at_frames(mask[:5])
    with pytest.raises(ValueError, match="^Frames must be whole numbers, but one is 0.5[.]$"):
        animation.at_frames([0.0, 0.5])
    assert animation.at_frames([0.0, 2.0]).n_frames == 2
    assert animation.at_frames([]).n_frames == 0
