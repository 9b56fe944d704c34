"""Compiled passage between poses and the one problem that the kernels solve; see `geodesics.pose_geodesics`.

Each joint has a side, and the rotation P to the principal axes of its metric as a unit quaternion.
"""

from __future__ import annotations

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.quaternions import log_of
from geomstats_anim.kernels.vectors import conjugate, multiply, rotate_back


@compiled
def targets(initial, end, is_right, axes, out):
    """Write the targets of the geodesics from the identity.

    Parameters
    ----------
    initial, end : array-like, shape=[n, B, 4]
    is_right : array-like of bool, shape=[B]
    axes : array-like, shape=[B, 4]
    out : array-like, shape=[n, B, 3]
        Written: the shortest rotation vectors, along the principal axes.
    """
    for k in range(len(initial)):
        for b in range(len(axes)):
            if is_right[b]:
                relative = conjugate(multiply(end[k, b], conjugate(initial[k, b])))
            else:
                relative = multiply(conjugate(initial[k, b]), end[k, b])
            vector = rotate_back(conjugate(axes[b]), log_of(relative))
            for i in range(3):
                out[k, b, i] = vector[i]


@compiled
def poses(initial, index, turned, is_right, axes, out):
    """Turn initial poses by samples of geodesics from the identity.

    Parameters
    ----------
    initial : array-like, shape=[n, B, 4]
    index : array-like of int, shape=[F]
        Of the initial pose of each sample.
    turned : array-like, shape=[F, B, 4]
    is_right : array-like of bool, shape=[B]
    axes : array-like, shape=[B, 4]
    out : array-like, shape=[F, B, 4]
        Written.
    """
    for f in range(len(index)):
        for b in range(len(axes)):
            turn = multiply(multiply(conjugate(axes[b]), turned[f, b]), axes[b])
            start = initial[index[f], b]
            pose = multiply(conjugate(turn), start) if is_right[b] else multiply(start, turn)
            for i in range(4):
                out[f, b, i] = pose[i]


@compiled
def inward(rotations, cotangent, is_right, axes, out):
    """Pull a derivative by what `poses` has written, at fixed axes, back to one by what it was given.

    Parameters
    ----------
    rotations : array-like, shape=[F, B, 4]
    cotangent : array-like, shape=[F, B, 3]
        Derivative by the body variation of the rotations.
    is_right : array-like of bool, shape=[B]
    axes : array-like, shape=[B, 4]
    out : array-like, shape=[F, B, 3]
        Written: derivative by the body variation of the turns, along the principal axes.
    """
    for f in range(len(rotations)):
        for b in range(len(axes)):
            x = cotangent[f, b]
            by_turn = (x[0], x[1], x[2])
            if is_right[b]:
                # the body variation x of a right-invariant geodesic g = e^-1 A comes from -g x of e
                outward = rotate_back(conjugate(rotations[f, b]), by_turn)
                by_turn = (-outward[0], -outward[1], -outward[2])
            by_turn = rotate_back(conjugate(axes[b]), by_turn)
            for i in range(3):
                out[f, b, i] = by_turn[i]
