"""The criteria of the papers, against their formulas spelt out joint by joint and frame by frame."""

import dataclasses
import re

import numpy as np
import pytest
import samples
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, Skeleton, quality
from geomstats_anim import rotations as quat

KINDS = ("loc", "rot", "hyb")
PARENTS = (-1, 0, 1, 0, -1, 4)


def branched(rng):
    """Two roots, and joints that do not come level by level."""
    n = len(PARENTS)
    return Skeleton(
        [f"joint{i}" for i in range(n)],
        PARENTS,
        rng.normal(size=(n, 3)),
        samples.quaternions(rng, n),
        rng.normal(size=(n, 3)),
    )


def pair(seed=0, n_frames=5):
    """Two animations of one skeleton, at the same times."""
    rng = np.random.default_rng(seed)
    skeleton = branched(rng)
    shape = (n_frames, skeleton.n_joints)
    return [
        Animation(skeleton, np.arange(n_frames), samples.quaternions(rng, *shape), rng.normal(size=(*shape, 3)))
        for _ in range(2)
    ]


def matrix(animation, frame, joint):
    return Rotation.from_quat(animation.rotations[frame, joint]).as_matrix()


def end_point(animation, frame, joint):
    """Transform the end of a bone by one joint after the other, up to the root."""
    point = animation.skeleton.bone_ends[joint]
    while joint >= 0:
        point = matrix(animation, frame, joint) @ point + animation.translations[frame, joint]
        joint = animation.skeleton.parents[joint]
    return point


def naive(animation, reference, kind, weights, location_weight=0.5):
    """Equations 7 to 9."""
    location = rotation = 0.0
    for frame in range(reference.n_frames):
        for joint in range(reference.n_joints):
            miss = end_point(animation, frame, joint) - end_point(reference, frame, joint)
            location += weights[joint] * (miss @ miss)
            turn = matrix(animation, frame, joint).T @ matrix(reference, frame, joint)
            rotation += weights[joint] * np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))
    both = location_weight * location + (1.0 - location_weight) * rotation
    return {"loc": location, "rot": rotation, "hyb": both}[kind] / reference.n_frames


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("weights", [None, "depth", (1.0, 0.5, 0.0, 2.0, 3.0, 0.1)], ids=["none", "depth", "array"])
def test_the_papers_equations(kind, weights):
    animation, reference = pair()
    by_joint = {None: np.ones(6), "depth": np.array([1, 2, 3, 2, 1, 2])}.get(weights, weights)
    expected = naive(animation, reference, kind, by_joint)
    assert quality(animation, reference, kind, weights) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("location_weight", [0.0, 0.2, 1.0])
def test_location_weight(location_weight):
    animation, reference = pair(1)
    expected = naive(animation, reference, "hyb", np.ones(6), location_weight)
    assert quality(animation, reference, location_weight=location_weight) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_symmetric_and_zero_only_where_they_agree(kind):
    animation, reference = pair(2)
    assert quality(animation, reference, kind) == pytest.approx(quality(reference, animation, kind), rel=1e-12)
    assert quality(reference, reference, kind) < 1e-14
    rotations = reference.rotations.copy()
    rotations[3, 2] = quat.multiply(rotations[3, 2], quat.exp(np.array([1e-3, 0.0, 0.0])))
    assert quality(dataclasses.replace(reference, rotations=rotations), reference, kind) > 1e-14


@pytest.mark.parametrize("kind", KINDS)
def test_the_sign_of_a_quaternion_means_nothing(kind):
    animation, reference = pair(3)
    flipped = dataclasses.replace(animation, rotations=-animation.rotations)
    assert quality(flipped, reference, kind) == pytest.approx(quality(animation, reference, kind), rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_a_rigid_motion_of_all_roots_changes_nothing(kind):
    rng = np.random.default_rng(4)
    turn, shift = samples.quaternions(rng, 1)[0], rng.normal(size=3)

    def moved(animation):
        rotations, translations = animation.rotations.copy(), animation.translations.copy()
        for root in np.flatnonzero(animation.skeleton.parents < 0):
            rotations[:, root] = quat.multiply(turn, rotations[:, root])
            translations[:, root] = quat.rotate(turn, translations[:, root]) + shift
        return dataclasses.replace(animation, rotations=rotations, translations=translations)

    animation, reference = pair(5)
    expected = quality(animation, reference, kind)
    assert quality(moved(animation), moved(reference), kind) == pytest.approx(expected, rel=1e-12)


def test_scales_are_no_part_of_it():
    animation, reference = pair(6)
    scaled = dataclasses.replace(animation, scales=np.full((5, 6, 3), 3.0))
    assert quality(scaled, reference) == quality(animation, reference)


def test_one_joint_that_makes_a_quarter_turn():
    skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [quat.IDENTITY], [[0.0, 2.0, 0.0]])
    still = Animation(skeleton, [0.0], [[quat.IDENTITY]], np.zeros((1, 1, 3)))
    turned = Animation(skeleton, [0.0], [[[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]]], np.zeros((1, 1, 3)))
    assert quality(turned, still, "loc") == pytest.approx(8.0, rel=1e-14)
    assert quality(turned, still, "rot") == pytest.approx(np.pi / 2, rel=1e-14)
    assert quality(turned, still) == pytest.approx(4.0 + np.pi / 4, rel=1e-14)


def test_small_angles_are_exact_and_half_turns_finite():
    animation, _ = pair(7)
    for angle in (1e-12, np.pi):
        turned = quat.multiply(animation.rotations, quat.exp(np.array([0.0, angle, 0.0])))
        other = dataclasses.replace(animation, rotations=turned)
        assert quality(other, animation, "rot") == pytest.approx(6.0 * angle, rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"kind": "all"}, "There is no quality 'all'; the kinds are loc, rot, hyb."),
        ({"weights": "size"}, "weights must be None, \"depth\" or one number per joint, but it is 'size'."),
        ({"weights": [1.0]}, "weights has shape (1,), but 6 numbers that are at least 0 are needed."),
        ({"weights": [1.0] * 7}, "weights has shape (7,), but 6 numbers that are at least 0 are needed."),
        ({"weights": [1, 1, 1, 1, 1, -1]}, "weights has shape (6,), but 6 numbers that are at least 0 are needed."),
        ({"weights": [1, 1, 1, 1, 1, np.nan]}, "weights has shape (6,), but 6 numbers that are at least 0 are needed."),
        ({"location_weight": 1.5}, "location_weight must be between 0 and 1, but it is 1.5."),
        ({"location_weight": np.nan}, "location_weight must be between 0 and 1, but it is nan."),
    ],
)
def test_nonsense_arguments(arguments, sentence):
    animation, reference = pair()
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        quality(animation, reference, **arguments)


def test_animations_that_cannot_be_compared():
    animation, reference = pair()
    other = dataclasses.replace(reference, skeleton=dataclasses.replace(reference.skeleton, joints=tuple("abcdef")))
    with pytest.raises(ValueError, match="^The two animations have different joints[.]$"):
        quality(animation, other)
    sentence = "^The two animations have different times: 5 and {} frames[.]$"
    with pytest.raises(ValueError, match=sentence.format(4)):
        quality(animation, reference.at_frames(slice(0, 4)))
    with pytest.raises(ValueError, match="^The two animations have different times: .* s and .* s in frame 0[.]$"):
        quality(animation, dataclasses.replace(reference, times=reference.times + 0.5))


@pytest.mark.parametrize("start", [0.0, 3600.0])
def test_times_are_compared_by_the_spacing_of_frames(start):
    one = samples.animation(np.random.default_rng(0), 6, 2, 20.0)
    one = dataclasses.replace(one, times=start + np.arange(6) / 120.0)
    assert quality(dataclasses.replace(one, times=one.times + 0.009 / 120.0), one) < 1e-15
    for shift in (0.011 / 120.0, -1.0 / 120.0):
        with pytest.raises(ValueError, match="^The two animations have different times: .* s and .* s in frame "):
            quality(dataclasses.replace(one, times=one.times + shift), one)
    single = one.at_frames([0])
    with pytest.raises(ValueError, match="different times"):
        quality(dataclasses.replace(single, times=single.times + 0.1), single)
