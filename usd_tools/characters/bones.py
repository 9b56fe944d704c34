"""Lines of a skeleton, to be drawn as lines or as capsules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim import Skeleton


@dataclass(frozen=True)
class Bones:
    """Lines of a skeleton between points: the origins of its joints, then the ends of those without children.

    A root that holds nothing but a joint with several children is a handle on the floor, and has no bone.

    Parameters
    ----------
    lines : array-like of int, shape=[L, 2]
        Points at both ends.
    owners : array-like of int, shape=[L]
        Joint that each line turns with.
    leaves : array-like of int, shape=[E]
        Joints without children.
    """

    lines: np.ndarray
    owners: np.ndarray
    leaves: np.ndarray

    @property
    def drawn(self) -> np.ndarray:
        """Points that lines lead to."""
        return np.unique(self.lines)

    @classmethod
    def of(cls, skeleton: Skeleton) -> Bones:
        """Find the bones of a skeleton."""
        parents, n_joints = skeleton.parents, skeleton.n_joints
        children = np.flatnonzero(parents >= 0)
        leaves = np.setdiff1d(np.arange(n_joints), parents)
        leaves = leaves[np.linalg.norm(skeleton.bone_ends[leaves], axis=-1) > 0.0]
        n_children = np.bincount(parents[children], minlength=n_joints)
        above = parents[children]
        is_handle = (parents[above] < 0) & (n_children[above] == 1) & (n_children[children] > 1)
        children = children[~is_handle]
        inner = np.stack([parents[children], children], axis=-1)
        outer = np.stack([leaves, n_joints + np.arange(len(leaves))], axis=-1)
        return cls(np.concatenate([inner, outer]), np.concatenate([parents[children], leaves]), leaves)
