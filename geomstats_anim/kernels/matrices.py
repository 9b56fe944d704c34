"""Compiled passage between matrices, as Geomstats has them, and quaternions and velocities, as the kernels want them.

A tangent vector at R is the matrix R hat(w) = hat(R w) R: w is the angular velocity in the body frame, R w the one in
the parent's frame.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.quaternions import write_quaternion
from geomstats_anim.kernels.vectors import conjugate, cross, dot, rotate, rotate_back


@compiled
def read_rotations(matrices, tolerance, quaternions):
    """Turn rotation matrices into unit quaternions, projecting rounding away.

    Parameters
    ----------
    matrices : array-like, shape=[n, 3, 3]
    tolerance : float
        Largest entry of R^T R - 1 that is taken for rounding.
    quaternions : array-like, shape=[n, 4]
        Written.

    Returns
    -------
    index : int
        First matrix that is not a rotation, or -1.
    """
    excess, m = np.empty((3, 3)), np.empty((3, 3))
    for n in range(len(matrices)):
        r = matrices[n]
        for i in range(3):
            for j in range(3):
                excess[i, j] = r[0, i] * r[0, j] + r[1, i] * r[1, j] + r[2, i] * r[2, j] - (1.0 if i == j else 0.0)
                if not abs(excess[i, j]) <= tolerance:
                    return n
        if dot(cross(r[0], r[1]), r[2]) < 0.0:
            return n
        # one Newton step towards the polar factor, whose error is the square of the excess
        for i in range(3):
            for j in range(3):
                m[i, j] = r[i, j] - 0.5 * (r[i, 0] * excess[0, j] + r[i, 1] * excess[1, j] + r[i, 2] * excess[2, j])
        write_quaternion(m, quaternions[n])
    return -1


@compiled
def read_velocities(tangent_vecs, base, is_right, velocities):
    """Turn tangent vectors into angular velocities, projecting away what is not tangent.

    Parameters
    ----------
    tangent_vecs : array-like, shape=[n, B, 3, 3]
    base : array-like, shape=[n, B, 4]
        Unit quaternions of the base points.
    is_right : array-like of bool, shape=[B]
    velocities : array-like, shape=[n, B, 3]
        Written: in the body frame, or in the parent's frame for a right-invariant joint.
    """
    for n in range(len(base)):
        for b in range(len(is_right)):
            q, v = base[n, b], tangent_vecs[n, b]
            x = rotate_back((q[0], q[1], q[2], q[3]), (v[0, 0], v[1, 0], v[2, 0]))
            y = rotate_back((q[0], q[1], q[2], q[3]), (v[0, 1], v[1, 1], v[2, 1]))
            z = rotate_back((q[0], q[1], q[2], q[3]), (v[0, 2], v[1, 2], v[2, 2]))
            w = (0.5 * (y[2] - z[1]), 0.5 * (z[0] - x[2]), 0.5 * (x[1] - y[0]))
            if is_right[b]:
                w = rotate_back(conjugate(q), w)
            for i in range(3):
                velocities[n, b, i] = w[i]


@compiled
def write_tangent_vectors(velocities, base, is_right, tangent_vecs):
    """Write the tangent vectors of velocities as `read_velocities` gives them; the arguments are the same."""
    for n in range(len(base)):
        for b in range(len(is_right)):
            q = base[n, b]
            w = (velocities[n, b, 0], velocities[n, b, 1], velocities[n, b, 2])
            if is_right[b]:
                w = rotate_back((q[0], q[1], q[2], q[3]), w)
            # column j of R hat(w) is R (w x e_j)
            x, y, z = rotate(q, (0.0, w[2], -w[1])), rotate(q, (-w[2], 0.0, w[0])), rotate(q, (w[1], -w[0], 0.0))
            for i in range(3):
                tangent_vecs[n, b, i, 0], tangent_vecs[n, b, i, 1], tangent_vecs[n, b, i, 2] = x[i], y[i], z[i]
