"""Compiled forward kinematics with scales: matrices of joints, and markers that move with several of them.

A matrix, shape=[3, 4], takes a point of a joint's frame to the world: columns 0 to 2 times the point, plus column 3.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled


@compiled
def place_joints(order, parents, world, rotations, translations, scales, matrices):
    """Place joints in the world.

    Parameters
    ----------
    order, parents : array-like of int, shape=[B]
        Parents come before their children in `order`.
    world : array-like, shape=[F, 3, 4]
        What roots are placed by.
    rotations : array-like, shape=[F, B, 4]
    translations, scales : array-like, shape=[F, B, 3]
    matrices : array-like, shape=[F, B, 3, 4]
        Written.
    """
    for f in range(rotations.shape[0]):
        for b in order:
            above = world[f] if parents[b] < 0 else matrices[f, parents[b]]
            q, t = rotations[f, b], translations[f, b]
            place_joint(above, (q[0], q[1], q[2], q[3]), (t[0], t[1], t[2]), scales[f, b], matrices[f, b])


@compiled
def place_joint(above, q, t, scale, matrix):
    """Write the matrix of a joint whose parent's is given; a point is scaled, rotated and translated, in this order."""
    x, y, z, w = q
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )
    for i in range(3):
        a, b, c = above[i, 0], above[i, 1], above[i, 2]
        matrix[i, 0] = (a * rows[0][0] + b * rows[1][0] + c * rows[2][0]) * scale[0]
        matrix[i, 1] = (a * rows[0][1] + b * rows[1][1] + c * rows[2][1]) * scale[1]
        matrix[i, 2] = (a * rows[0][2] + b * rows[1][2] + c * rows[2][2]) * scale[2]
        matrix[i, 3] = a * t[0] + b * t[1] + c * t[2] + above[i, 3]


@compiled
def place_marker(matrices, joints, offsets, weights):
    """Return the place of a marker, by the matrices of joints, shape=[B, 3, 4]."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(len(joints)):
        m, o, weight = matrices[joints[k]], offsets[k], weights[k]
        if weight != 0.0:
            x += weight * (m[0, 0] * o[0] + m[0, 1] * o[1] + m[0, 2] * o[2] + m[0, 3])
            y += weight * (m[1, 0] * o[0] + m[1, 1] * o[1] + m[1, 2] * o[2] + m[1, 3])
            z += weight * (m[2, 0] * o[0] + m[2, 1] * o[1] + m[2, 2] * o[2] + m[2, 3])
    return x, y, z


@compiled
def place_markers(matrices, joints, offsets, weights, places):
    """Place markers.

    Parameters
    ----------
    matrices : array-like, shape=[F, B, 3, 4]
    joints : array-like of int, shape=[P, I]
    offsets : array-like, shape=[P, I, 3]
    weights : array-like, shape=[P, I]
    places : array-like, shape=[F, P, 3]
        Written.
    """
    for f in range(matrices.shape[0]):
        for p in range(len(joints)):
            x, y, z = place_marker(matrices[f], joints[p], offsets[p], weights[p])
            places[f, p, 0], places[f, p, 1], places[f, p, 2] = x, y, z


@compiled
def largest_distances(matrices, others, owners, joints, offsets, weights, distances):
    """Measure how far markers are apart under two poses, without keeping their places.

    Parameters
    ----------
    matrices, others : array-like, shape=[F, B, 3, 4]
    owners : array-like of int, shape=[P]
        Joint that each marker counts for.
    joints, offsets, weights
        See `place_markers`.
    distances : array-like, shape=[F, B]
        Raised to the largest distance of each joint's markers.
    """
    for f in range(matrices.shape[0]):
        for p in range(len(joints)):
            x, y, z = place_marker(matrices[f], joints[p], offsets[p], weights[p])
            u, v, w = place_marker(others[f], joints[p], offsets[p], weights[p])
            distance = np.sqrt((x - u) ** 2 + (y - v) ** 2 + (z - w) ** 2)
            if distance > distances[f, owners[p]]:
                distances[f, owners[p]] = distance
