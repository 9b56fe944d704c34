"""Vectors and quaternions (x, y, z, w) as tuples, in compiled code: of numbers, or of lanes."""

from __future__ import annotations

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.simd import load, store


@compiled
def cross(a, b):
    """Return the cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@compiled
def dot(a, b):
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def multiply(a, b):
    """Return the product of quaternions."""
    return (
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    )


@compiled
def conjugate(q):
    """Return the inverse of a unit quaternion."""
    return (-q[0], -q[1], -q[2], q[3])


@compiled
def rotate_back(q, v):
    """Apply the inverse of a unit quaternion to a vector."""
    tx, ty, tz = cross(v, (q[0], q[1], q[2]))
    tx, ty, tz = 2.0 * tx, 2.0 * ty, 2.0 * tz
    cx, cy, cz = cross((tx, ty, tz), (q[0], q[1], q[2]))
    return (v[0] + q[3] * tx + cx, v[1] + q[3] * ty + cy, v[2] + q[3] * tz + cz)


@compiled
def rotate(q, v):
    """Apply a unit quaternion to a vector."""
    return rotate_back(conjugate(q), (v[0], v[1], v[2]))


@compiled
def load3(array, row):
    """Read three rows."""
    return (load(array, row), load(array, row + 1), load(array, row + 2))


@compiled
def load4(array, row):
    """Read four rows."""
    return (load(array, row), load(array, row + 1), load(array, row + 2), load(array, row + 3))


@compiled
def store3(array, row, v):
    """Write three rows."""
    store(array, row, v[0])
    store(array, row + 1, v[1])
    store(array, row + 2, v[2])
