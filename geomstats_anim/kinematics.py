"""Forward kinematics, and its derivative, over all joints and frames in one compiled pass.

Joints are visited level by level (breadth first), as the papers do, so every parent is placed before its children.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.kernels import kinematics as kernel
from geomstats_anim.rotations import Array


class WorldPose(NamedTuple):
    """Positions of the joints of an animation.

    Attributes
    ----------
    rotations : array-like, shape=[F, B, 4]
        From joint to world, unit quaternions.
    origins : array-like, shape=[F, B, 3]
        Of the joints, metres.
    ends : array-like, shape=[F, B, 3]
        Of the bones, metres.
    """

    rotations: Array
    origins: Array
    ends: Array


def world_pose(animation: Animation) -> WorldPose:
    """Place every joint and bone end in the world. Scales are left out, as in the papers.

    Parameters
    ----------
    animation : Animation

    Returns
    -------
    pose : WorldPose
    """
    return place(animation.skeleton, animation.rotations, animation.translations)


def place(skeleton: Skeleton, rotations: Array, translations: Array) -> WorldPose:
    """Place joints given as plain arrays; see `world_pose`.

    Parameters
    ----------
    skeleton : Skeleton
    rotations : array-like, shape=[F, B, 4]
    translations : array-like, shape=[F, B, 3]

    Returns
    -------
    pose : WorldPose
    """
    shape = rotations.shape[:2]
    pose = WorldPose(np.empty((*shape, 4)), np.empty((*shape, 3)), np.empty((*shape, 3)))
    kernel.place(
        breadth_first(skeleton),
        np.array(skeleton.parents),
        np.array(skeleton.bone_ends),
        np.array(rotations),
        np.array(translations),
        *pose,
    )
    return pose


def breadth_first(skeleton: Skeleton) -> np.ndarray:
    """Return the joints level by level, shape=[B]."""
    return np.argsort(skeleton.depths, kind="stable")


def pull_back_ends(skeleton: Skeleton, pose: WorldPose, forces: Array) -> tuple[Array, Array]:
    """Pull a derivative by bone ends back to one by rotations and translations.

    Parameters
    ----------
    skeleton : Skeleton
    pose : WorldPose
    forces : array-like, shape=[F, B, 3]
        Derivative of a scalar by the position of every bone end.

    Returns
    -------
    torques : array-like, shape=[F, B, 3]
        Derivative by the body variation of every joint's local rotation, which moves all bones below it.
    pulls : array-like, shape=[F, B, 3]
        Derivative by its local translation.
    """
    torques, pulls = np.empty_like(pose.ends), np.empty_like(pose.ends)
    kernel.pull_back_ends(breadth_first(skeleton), np.array(skeleton.parents), *pose, forces, torques, pulls)
    return torques, pulls
