import numpy as np
import pytest
from gaits import biped

from geomstats_anim import Skeleton
from geomstats_anim.learning.library.parts import body_parts


def named(skeleton, parts):
    return {
        tuple(skeleton.joints[joint].split("/")[-1] for joint in joints): kind
        for joints, kind in zip(parts.joints, parts.kinds, strict=True)
    }


def test_a_body_has_a_torso_two_arms_and_two_legs():
    skeleton = biped()
    parts = body_parts(skeleton)
    assert named(skeleton, parts) == {
        ("hips", "spine", "chest", "head"): "torso",
        ("arm_L", "fore_L", "hand_L"): "arm",
        ("arm_R", "fore_R", "hand_R"): "arm",
        ("thigh_L", "shin_L", "foot_L"): "leg",
        ("thigh_R", "shin_R", "foot_R"): "leg",
    }
    assert parts.trunk.tolist() == [0]
    assert sorted(np.concatenate(parts.joints).tolist()) == list(range(skeleton.n_joints))
    assert all(joint in parts.joints[part] for joint, part in enumerate(parts.of_joint))


def test_fingers_belong_to_arms_and_names_do_not_matter():
    skeleton = biped()
    joints = [f"x{i}" for i in range(skeleton.n_joints)]
    parents, rests = skeleton.parents.tolist(), skeleton.rest_translations.tolist()
    for finger in range(5):
        joints += [f"f{finger}", f"g{finger}"]
        parents += [6, len(joints) - 2]
        rests += [[0.08, 0.0, 0.02 * finger], [0.04, 0.0, 0.0]]
    hand = Skeleton(joints, parents, rests, [[0.0, 0.0, 0.0, 1.0]] * len(joints))
    parts = body_parts(hand)
    assert parts.kinds == body_parts(skeleton).kinds
    assert parts.joints[1].tolist() == [4, 5, 6, *range(16, 26)]


@pytest.mark.parametrize("parents", [[-1], [-1, 0, 1, 2], [-1, -1, -1]])
def test_what_has_no_limbs_is_one_part(parents):
    n = len(parents)
    parts = body_parts(Skeleton([f"j{i}" for i in range(n)], parents, np.ones((n, 3)), [[0.0, 0.0, 0.0, 1.0]] * n))
    assert parts.kinds == ("torso",)
    assert parts.joints[0].tolist() == list(range(n))


def test_limbs_from_one_place_are_limbs():
    parents = [-1, 0, 1, 0, 3, 0, 5]
    parts = body_parts(Skeleton([f"j{i}" for i in range(7)], parents, np.ones((7, 3)), [[0.0, 0.0, 0.0, 1.0]] * 7))
    assert parts.kinds == ("torso", "limb", "limb", "limb")
