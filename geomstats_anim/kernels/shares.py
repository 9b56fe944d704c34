"""Compiled errors of poses that are turned by shares of residuals."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.kinematics import place
from geomstats_anim.kernels.quaternions import exp_of
from geomstats_anim.kernels.vectors import conjugate, multiply


@compiled
def miss(order, parents, bone_ends, offsets, splines, residuals, truth, shares, angles, distances):
    """Turn poses by shares of residuals, and write how far they are from the truth.

    Parameters
    ----------
    order, parents, bone_ends
        As in `place`.
    offsets : array-like, shape=[S + 1, B, 3]
        Translations of the joints.
    splines, truth : array-like, shape=[n, B, 4]
    residuals : array-like, shape=[n, B, 3]
    shares : array-like, shape=[S, B]
    angles, distances : array-like, shape=[S, n, B]
        Written: between rotations, radians, and between bone ends, metres.
    """
    n_shares, n_joints = shares.shape
    poses, world = np.empty((n_shares + 1, n_joints, 4)), np.empty((n_shares + 1, n_joints, 4))
    origins, ends = np.empty((n_shares + 1, n_joints, 3)), np.empty((n_shares + 1, n_joints, 3))
    for i in range(len(splines)):
        for b in range(n_joints):
            x, y, z = residuals[i, b]
            start = (splines[i, b, 0], splines[i, b, 1], splines[i, b, 2], splines[i, b, 3])
            back = conjugate((truth[i, b, 0], truth[i, b, 1], truth[i, b, 2], truth[i, b, 3]))
            poses[n_shares, b] = truth[i, b]
            for s in range(n_shares):
                if s > 0 and shares[s, b] == shares[s - 1, b]:
                    poses[s, b], angles[s, i, b] = poses[s - 1, b], angles[s - 1, i, b]
                    continue
                share = shares[s, b]
                pose = multiply(start, exp_of((share * x, share * y, share * z)))
                for q in range(4):
                    poses[s, b, q] = pose[q]
                left = multiply(back, pose)
                sine = np.sqrt(left[0] ** 2 + left[1] ** 2 + left[2] ** 2)
                angles[s, i, b] = 2.0 * np.arctan2(sine, np.abs(left[3]))
        place(order, parents, bone_ends, poses, offsets, world, origins, ends)
        for s in range(n_shares):
            for b in range(n_joints):
                square = 0.0
                for q in range(3):
                    square += (ends[s, b, q] - ends[n_shares, b, q]) ** 2
                distances[s, i, b] = np.sqrt(square)
