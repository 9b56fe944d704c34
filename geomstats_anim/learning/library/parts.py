"""Parts of the body, found from the tree of joints: limbs, and the torso that they hang from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim.animation import Skeleton, descendants
from geomstats_anim.rotations import Array

_LONG = 0.35
"""A chain this long, as a share of the longest, is a limb: arms and legs are, heads, fingers and toes are not."""

_MOST_PARTS = 12
"""A rig with more is taken as one part."""


@dataclass(frozen=True, eq=False)
class BodyParts:
    """Parts of the body of a rig.

    Parameters
    ----------
    joints : tuple of array-like of int
        Indices of the joints of each part, increasing; each joint is in one.
    kinds : tuple of str
        "torso", "leg" (a limb at the joint where the first limbs branch off), "arm" (a limb further up) or "limb"
        (where there is only one such joint).
    trunk : array-like of int
        From the root to the joint where the first limbs branch off: those that carry the heading of the whole body.
    """

    joints: tuple[np.ndarray, ...]
    kinds: tuple[str, ...]
    trunk: np.ndarray

    @cached_property
    def of_joint(self) -> np.ndarray:
        """Return the index of the part of each joint, shape=[B]."""
        part = np.empty(sum(map(len, self.joints)), dtype=np.intp)
        for i, joints in enumerate(self.joints):
            part[joints] = i
        return part

    @cached_property
    def sizes(self) -> np.ndarray:
        """Return the numbers of joints, shape=[parts]."""
        return np.array([len(joints) for joints in self.joints])

    @cached_property
    def table(self) -> np.ndarray:
        """Return the joints of each part, shape=[parts, largest size], filled up with zeros."""
        table = np.zeros((len(self.joints), self.sizes.max()), dtype=np.intp)
        for row, joints in zip(table, self.joints, strict=True):
            row[: len(joints)] = joints
        return table

    @cached_property
    def averages(self) -> Array:
        """Return the weights of joints in the means over the parts, shape=[B, parts]."""
        is_in = self.of_joint[:, None] == np.arange(len(self.joints))
        return is_in / np.maximum(self.sizes, 1)


def body_parts(skeleton: Skeleton) -> BodyParts:
    """Find the parts of the body from the tree of joints and the lengths of its bones.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    parts : BodyParts
        The torso, if any joint is in none of the limbs, then the limbs.
    """
    children = _children(skeleton)
    trunk = _trunk(skeleton, children)
    reach = _reaches(skeleton)
    longest = max((reach[child] for child in children[trunk[-1]]), default=0.0)
    is_long = (reach >= _LONG * longest) & (longest > 0.0)
    branches = [sum(is_long[child] for child in children[joint]) > 1 for joint in range(skeleton.n_joints)]
    divides = np.array(branches)
    for joint in range(skeleton.n_joints - 1, 0, -1):
        if skeleton.parents[joint] >= 0:
            divides[skeleton.parents[joint]] |= divides[joint]
    inside = set(descendants(skeleton, trunk[-1:]).tolist())
    roots = [
        joint
        for joint in range(skeleton.n_joints)
        if joint in inside and is_long[joint] and not divides[joint]
        and skeleton.parents[joint] >= 0 and branches[skeleton.parents[joint]]
    ]  # fmt: skip
    if not 2 <= len(roots) < _MOST_PARTS:
        return BodyParts((np.arange(skeleton.n_joints),), ("torso",), trunk)
    limbs = [descendants(skeleton, np.array([root])) for root in roots]
    torso = np.setdiff1d(np.arange(skeleton.n_joints), np.concatenate(limbs))
    depths = skeleton.depths[[skeleton.parents[root] for root in roots]]
    one_place = depths.min() == depths.max()
    kinds = ["limb" if one_place else "leg" if depth == depths.min() else "arm" for depth in depths]
    return BodyParts((torso, *limbs), ("torso", *kinds), trunk)


def _children(skeleton: Skeleton) -> list[list[int]]:
    children: list[list[int]] = [[] for _ in range(skeleton.n_joints)]
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            children[parent].append(joint)
    return children


def _trunk(skeleton: Skeleton, children: list[list[int]]) -> np.ndarray:
    """Return the joints from the root of the largest tree to the first with several children."""
    roots = np.flatnonzero(skeleton.parents < 0)
    largest = max(roots.tolist(), key=lambda root: len(descendants(skeleton, np.array([root]))))
    trunk = [largest]
    while len(children[trunk[-1]]) == 1:
        trunk.append(children[trunk[-1]][0])
    return np.array(trunk, dtype=np.intp)


def _reaches(skeleton: Skeleton) -> Array:
    """Return how far the longest chain from each joint's parent through it leads, metres."""
    reach = np.linalg.norm(skeleton.rest_translations, axis=-1)
    beyond = np.zeros(skeleton.n_joints)
    for joint in range(skeleton.n_joints - 1, -1, -1):
        reach[joint] += beyond[joint]
        parent = skeleton.parents[joint]
        if parent >= 0:
            beyond[parent] = max(beyond[parent], reach[joint])
    return reach
