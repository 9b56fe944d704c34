"""Compiled loops over rows of quaternions (x, y, z, w) and of vectors; `rotations` gives them arrays of any shape.

NumPy takes a dozen passes, and more time between them than in them, where a loop takes one.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels import vectors
from geomstats_anim.kernels.compilation import compiled


@compiled
def multiply(left, right, out):
    """Compose rotations, shape=[n, 4]."""
    for i in range(len(out)):
        product = vectors.multiply(left[i], right[i])
        for k in range(4):
            out[i, k] = product[k]


@compiled
def cross(left, right, out):
    """Multiply vectors, shape=[n, 3]."""
    for i in range(len(out)):
        product = vectors.cross(left[i], right[i])
        for k in range(3):
            out[i, k] = product[k]


@compiled
def rotate(quaternion, vector, out):
    """Rotate vectors, shape=[n, 3], by unit quaternions, shape=[n, 4]."""
    for i in range(len(out)):
        rotated = vectors.rotate(quaternion[i], vector[i])
        for k in range(3):
            out[i, k] = rotated[k]


@compiled
def to_matrix(quaternion, out):
    """Turn unit quaternions, shape=[n, 4], into rotation matrices, row by row, shape=[n, 9]."""
    for i in range(len(out)):
        x, y, z, w = quaternion[i]
        out[i, 0], out[i, 4] = 1.0 - 2.0 * (y * y + z * z), 1.0 - 2.0 * (x * x + z * z)
        out[i, 8] = 1.0 - 2.0 * (x * x + y * y)
        out[i, 1], out[i, 3] = 2.0 * (x * y - z * w), 2.0 * (x * y + z * w)
        out[i, 2], out[i, 6] = 2.0 * (x * z + y * w), 2.0 * (x * z - y * w)
        out[i, 5], out[i, 7] = 2.0 * (y * z - x * w), 2.0 * (y * z + x * w)


@compiled
def exp_of(v):
    """Turn a rotation vector into a unit quaternion."""
    half = 0.5 * np.sqrt(vectors.dot(v, v))
    scale = 0.5 * np.sin(half) / half if half > 0.0 else 0.5
    return (scale * v[0], scale * v[1], scale * v[2], np.cos(half))


@compiled
def exp(rotation_vector, out):
    """Turn rotation vectors, shape=[n, 3], into unit quaternions, shape=[n, 4]."""
    for i in range(len(out)):
        q = exp_of(rotation_vector[i])
        for k in range(4):
            out[i, k] = q[k]


@compiled
def log_of(q):
    """Turn a unit quaternion into the shortest rotation vector."""
    sign = -1.0 if q[3] < 0.0 else 1.0
    sine = np.sqrt(vectors.dot(q, q))
    # half / sine tends to 1 / cosine = 1 at the identity
    ratio = np.arctan2(sine, sign * q[3]) / sine if sine > 0.0 else 1.0
    return (2.0 * ratio * (sign * q[0]), 2.0 * ratio * (sign * q[1]), 2.0 * ratio * (sign * q[2]))


@compiled
def log(quaternion, out):
    """Turn unit quaternions, shape=[n, 4], into the shortest rotation vectors, shape=[n, 3]."""
    for i in range(len(out)):
        q = quaternion[i]
        vector = log_of((q[0], q[1], q[2], q[3]))
        for k in range(3):
            out[i, k] = vector[k]


@compiled
def difference(left, right, out):
    """Turn the rotations that lead from unit quaternions to others, shape=[n, 4], into rotation vectors."""
    for i in range(len(out)):
        vector = log_of(vectors.multiply(vectors.conjugate(left[i]), right[i]))
        for k in range(3):
            out[i, k] = vector[k]


@compiled
def write_quaternion(m, out):
    """Write the unit quaternion of a rotation matrix, shape=[3, 3].

    It is the largest of the four columns of 4 q q^T, which never cancels (Markley, "Unit quaternion from rotation
    matrix", 2008), normalised.
    """
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    largest, size = 3, 1.0 + trace
    for i in range(3):
        if 1.0 + 2.0 * m[i, i] - trace > size:
            largest, size = i, 1.0 + 2.0 * m[i, i] - trace
    if largest == 3:
        out[0], out[1], out[2] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        out[j], out[k], out[3] = m[i, j] + m[j, i], m[i, k] + m[k, i], m[k, j] - m[j, k]
    out[largest] = size
    norm = np.sqrt(vectors.dot(out, out) + out[3] * out[3])
    for i in range(4):
        out[i] /= norm


@compiled
def from_matrix(entries, out):
    """Turn rotation matrices, shape=[n, 9], into unit quaternions, shape=[n, 4]."""
    for i in range(len(out)):
        write_quaternion(entries[i].reshape(3, 3), out[i])
