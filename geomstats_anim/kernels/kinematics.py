"""Compiled forward kinematics of all joints and frames in one pass, and its derivative."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.vectors import cross, multiply, rotate, rotate_back


@compiled
def place(order, parents, bone_ends, rotations, translations, world, origins, ends):
    """Place joints and bone ends in the world.

    Parameters
    ----------
    order, parents : array-like of int, shape=[B]
        Parents come before their children in `order`.
    bone_ends : array-like, shape=[B, 3]
    rotations : array-like, shape=[F, B, 4]
    translations : array-like, shape=[F, B, 3]
    world : array-like, shape=[F, B, 4]
        Written, as are the next: rotations from joint to world.
    origins, ends : array-like, shape=[F, B, 3]
    """
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
def pull_back_ends(order, parents, world, origins, ends, forces, torques, pulls):
    """Pull a derivative by bone ends back to one by local rotations and translations.

    Parameters
    ----------
    order, parents, world, origins, ends
        As in `place`.
    forces : array-like, shape=[F, B, 3]
        Derivative of a scalar by the position of every bone end.
    torques, pulls : array-like, shape=[F, B, 3]
        Written: derivatives by the body variation of the local rotations, and by the local translations.
    """
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
