"""Compiled description of what surrounds segments between keys, part by part of the body."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled


@compiled
def describe(increments, poses, scales, weights, joints, sizes, units, described):
    """Write increments by the scale, poses and the scale itself, of the joints of each part.

    Parameters
    ----------
    increments : array-like, shape=[n, O, B, 3]
    poses : array-like, shape=[n, B, 9]
    scales : array-like, shape=[n, P]
    weights : array-like, shape=[O]
        Of the increments; of a part, divided by the root of the number of joints.
    joints : array-like of int, shape=[P, J]
        Of each part, the first of a row.
    sizes : array-like of int, shape=[P]
        How many of each row are.
    units : array-like, shape=[P, 3]
        Of poses; mean and unit of the logarithm of the scale.
    described : array-like, shape=[P, n, D]
        Written: (3 O + 9) numbers a joint, then one.
    """
    for p in range(len(sizes)):
        size = sizes[p]
        per_pose, of_increment = 1.0 / units[p, 0], weights / np.sqrt(size)
        for i in range(len(increments)):
            row, at = described[p, i], 0
            for o in range(len(weights)):
                weight = of_increment[o] / scales[i, p]
                for j in range(size):
                    for x in range(3):
                        row[at + x] = weight * increments[i, o, joints[p, j], x]
                    at += 3
            for j in range(size):
                for x in range(9):
                    row[at + x] = per_pose * poses[i, joints[p, j], x]
                at += 9
            row[at] = (np.log(scales[i, p]) - units[p, 1]) / units[p, 2]
