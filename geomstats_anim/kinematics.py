"""Forward kinematics, and its derivative, over all joints and frames in one compiled pass.

Joints are visited level by level (breadth first), as the papers do, so every parent is placed before its children.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.kernels.vectors import compiled, cross, multiply, rotate, rotate_back
from geomstats_anim.rotations import Array


class WorldPose(NamedTuple):
    """Where the joints of an animation are.

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
    """Place every joint and bone end in the world. Scales are not part of it, as they are not in the papers.

    Parameters
    ----------
    animation : Animation

    Returns
    -------
    pose : WorldPose
    """
    return place(animation.skeleton, animation.rotations, animation.translations)


def place(skeleton: Skeleton, rotations: Array, translations: Array) -> WorldPose:
    """Place joints, given as plain arrays; see `world_pose`.

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
    _place(
        breadth_first(skeleton),
        np.array(skeleton.parents),
        np.array(skeleton.bone_ends),
        np.array(rotations),
        np.array(translations),
        *pose,
    )
    return pose


def breadth_first(skeleton: Skeleton) -> np.ndarray:
    """Order the joints level by level, shape=[B]."""
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
    _pull_back_ends(breadth_first(skeleton), np.array(skeleton.parents), *pose, forces, torques, pulls)
    return torques, pulls


@compiled
def _place(order, parents, bone_ends, rotations, translations, world, origins, ends):
    for f in range(rotations.shape[0]):
        for b in order:
            p = parents[b]
            if p < 0:
                world[f, b] = rotations[f, b]
                origins[f, b] = translations[f, b]
            else:
                q = multiply(world[f, p], rotations[f, b])
                o = rotate(world[f, p], translations[f, b])
                for i in range(4):
                    world[f, b, i] = q[i]
                for i in range(3):
                    origins[f, b, i] = origins[f, p, i] + o[i]
            e = rotate(world[f, b], bone_ends[b])
            for i in range(3):
                ends[f, b, i] = origins[f, b, i] + e[i]


@compiled
def _pull_back_ends(order, parents, world, origins, ends, forces, torques, pulls):
    n_joints = len(order)
    force, moment = np.empty((n_joints, 3)), np.empty((n_joints, 3))
    for f in range(world.shape[0]):
        for b in range(n_joints):
            about_world_origin = cross(ends[f, b], forces[f, b])
            for i in range(3):
                force[b, i] = forces[f, b, i]
                moment[b, i] = about_world_origin[i]
        for b in order[::-1]:
            p = parents[b]
            if p >= 0:
                for i in range(3):
                    force[p, i] += force[b, i]
                    moment[p, i] += moment[b, i]
            lever = cross(origins[f, b], force[b])
            q = (world[f, b, 0], world[f, b, 1], world[f, b, 2], world[f, b, 3])
            t = rotate_back(q, (moment[b, 0] - lever[0], moment[b, 1] - lever[1], moment[b, 2] - lever[2]))
            pull = (force[b, 0], force[b, 1], force[b, 2])
            if p >= 0:
                pull = rotate_back((world[f, p, 0], world[f, p, 1], world[f, p, 2], world[f, p, 3]), pull)
            for i in range(3):
                torques[f, b, i] = t[i]
                pulls[f, b, i] = pull[i]
