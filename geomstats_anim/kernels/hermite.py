"""Compiled equations for the velocities at the keys of a spline; see `interpolation.tangents`."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.compilation import compiled

_NATURAL = 0.5
"""c'' = 0 at u = 0 where v_k - w_k^- = -(v_{k+1} - w_k^+) / 2."""


@compiled
def weights(parameter):
    """Return the weights of the two bends of a segment in c, at parameters from 0 to 1; runs on arrays too."""
    rest = 1.0 - parameter
    return parameter * rest**2, -(parameter**2) * rest


@compiled
def fill_rows(durations, holds, is_smooth, matrix, sources):
    """Fill in the equations for the velocities at the keys.

    Parameters
    ----------
    durations : array-like, shape=[n]
    holds : array-like of bool, shape=[n, B]
        Segments that do not move.
    is_smooth : bool
        Whether acceleration is continuous; else the parabola through three keys is followed.
    matrix : array-like, shape=[3, K, B]
        Written: lower, main and upper coefficients.
    sources : array-like, shape=[4, K, B]
        Written: coefficients of the velocities of the segments before and after.
    """
    n_keys, n_joints = matrix.shape[1:]
    for k in range(n_keys):
        for b in range(n_joints):
            if (k > 0 and holds[k - 1, b]) or (k < n_keys - 1 and holds[k, b]):
                # the keys of segments that do not move are at rest
                matrix[1, k, b] = 1.0
            elif k == 0:
                matrix[1, k, b], matrix[2, k, b] = 1.0, _NATURAL
                sources[2, k, b], sources[3, k, b] = 1.0, _NATURAL
            elif k == n_keys - 1:
                matrix[0, k, b], matrix[1, k, b] = _NATURAL, 1.0
                sources[0, k, b], sources[1, k, b] = _NATURAL, 1.0
            elif is_smooth:
                before, after = 2.0 / durations[k - 1], 2.0 / durations[k]
                matrix[0, k, b], matrix[1, k, b], matrix[2, k, b] = before, 2.0 * (before + after), after
                sources[0, k, b], sources[1, k, b] = before, 2.0 * before
                sources[2, k, b], sources[3, k, b] = 2.0 * after, after
            else:
                before, after = durations[k - 1], durations[k]
                matrix[1, k, b] = 1.0
                sources[1, k, b], sources[2, k, b] = after / (before + after), before / (before + after)


@compiled
def fill_right_side(sources, start, end, right):
    """Add the right sides, shape=[K, B, 3], for velocities at both ends of the segments, shape=[n, B, 3]."""
    for k in range(len(right)):
        for b in range(right.shape[1]):
            for i in range(3):
                if k > 0:
                    right[k, b, i] += sources[0, k, b] * start[k - 1, b, i] + sources[1, k, b] * end[k - 1, b, i]
                if k < len(start):
                    right[k, b, i] += sources[2, k, b] * start[k, b, i] + sources[3, k, b] * end[k, b, i]


@compiled
def add_right_side(sources, by_row, start, end):
    """Pull a derivative by `fill_right_side` back, and add it."""
    for k in range(len(by_row)):
        for b in range(by_row.shape[1]):
            for i in range(3):
                if k > 0:
                    start[k - 1, b, i] += sources[0, k, b] * by_row[k, b, i]
                    end[k - 1, b, i] += sources[1, k, b] * by_row[k, b, i]
                if k < len(start):
                    start[k, b, i] += sources[2, k, b] * by_row[k, b, i]
                    end[k, b, i] += sources[3, k, b] * by_row[k, b, i]


@compiled
def eliminate(lower, main, upper, turn, right, out):
    """Solve lower v_{k-1} + main v_k + v_k x turn_k + upper v_{k+1} = right_k by block elimination.

    Parameters
    ----------
    lower, main, upper : array-like, shape=[K, B]
    turn, right : array-like, shape=[K, B, 3]
    out : array-like, shape=[K, B, 3]
        Written: v.
    """
    n_keys, n_joints = main.shape
    inverse = np.zeros((n_keys, 3, 3))
    rest = np.zeros((n_keys, 3))
    block = np.zeros((3, 3))
    for b in range(n_joints):
        for k in range(n_keys):
            x, y, z = turn[k, b]
            block[0, 0] = block[1, 1] = block[2, 2] = main[k, b]
            block[0, 1], block[0, 2], block[1, 2] = z, -y, x
            block[1, 0], block[2, 0], block[2, 1] = -z, y, -x
            for i in range(3):
                rest[k, i] = right[k, b, i]
            if k > 0 and lower[k, b] != 0.0:
                for i in range(3):
                    for j in range(3):
                        block[i, j] -= lower[k, b] * upper[k - 1, b] * inverse[k - 1, i, j]
                        rest[k, i] -= lower[k, b] * inverse[k - 1, i, j] * rest[k - 1, j]
            _invert(block, inverse[k])
        for k in range(n_keys - 1, -1, -1):
            for i in range(3):
                out[k, b, i] = 0.0
            for j in range(3):
                known = rest[k, j] - (upper[k, b] * out[k + 1, b, j] if k + 1 < n_keys else 0.0)
                for i in range(3):
                    out[k, b, i] += inverse[k, i, j] * known


@compiled
def _invert(block, inverse):
    """Write the inverse of a 3 x 3 matrix."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for column in range(3):
            p, q = (column + 1) % 3, (column + 2) % 3
            inverse[column, i] = block[j, p] * block[k, q] - block[j, q] * block[k, p]
    determinant = block[0, 0] * inverse[0, 0] + block[0, 1] * inverse[1, 0] + block[0, 2] * inverse[2, 0]
    for i in range(3):
        for column in range(3):
            inverse[i, column] /= determinant
