"""Compiled Gauss-Newton steps that turn the joints above some points until the points reach their goals.

The unknowns of a step are multipliers, three for each point that is pulled, so the system that is solved is small; what
joints turn by follows from them. Each frame is solved by itself, and ends when its own last step is small.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.affine import place_joint
from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.quaternions import exp_of
from geomstats_anim.kernels.vectors import cross, dot, multiply, rotate_back


@compiled
def reach(
    joints, parents, points, moves, root, units, is_right, free, world, scales, goals, softness, least, most, q, t
):
    """Turn joints, and move the root, in every frame.

    Parameters
    ----------
    joints : array-like of int, shape=[J]
        Of a skeleton of B joints: those that matter. All others here count among these.
    parents : array-like of int, shape=[J]
        Parents come before their children.
    points : array-like of int, shape=[P]
        Joints whose origins are the points.
    moves : array-like of bool, shape=[P, J + 1]
        Which points move with turns of which joints, and, last, with moves of the root.
    root : int
    units : array-like, shape=[J + 1, 3, 3]
        Turns that cost one, as columns, and, last, moves of the root.
    is_right : array-like of bool, shape=[J]
        Whose turns are in the frame of the parent.
    free : array-like, shape=[F, J + 1]
        How free each of them is; one at 0 does not move.
    world : array-like, shape=[F, 3, 4]
        What roots are placed by.
    scales : array-like, shape=[F, B, 3]
    goals : array-like, shape=[F, P, 3]
        Metres.
    softness : array-like, shape=[F, P]
        Square metres; infinite for a point that is not pulled.
    least : float
        Radians: the last step.
    most : int
        Number of steps at most.
    q, t : array-like, shape=[F, B, 4], shape=[F, B, 3]
        Rotations and translations; those of joints that move are written.
    """
    n_joints, n_points = len(parents), len(points)
    matrices, axes = np.empty((n_joints, 3, 4)), np.empty((n_joints + 1, 3, 3))
    in_frame, turns = np.zeros((n_joints + 1, 3, 3)), np.zeros((n_joints + 1, 3))
    spread = np.zeros((n_points, n_joints + 1, 3, 3))
    normal = np.empty((3 * n_points, 3 * n_points))
    forces, missing, scale = np.empty(3 * n_points), np.empty(3 * n_points), np.empty(3 * n_points)
    pulled, moving = np.empty(n_points, np.intp), np.empty(n_joints + 1, np.intp)
    for f in range(len(q)):
        n_pulled, n_moving = _chosen(softness[f], moves, free[f], pulled, moving)
        if n_moving == 0:
            continue
        _units_in_frame(units, is_right, free[f], q[f], joints, moving[:n_moving], in_frame)
        forces[:] = 0.0
        for _ in range(most):
            for b in range(n_joints):
                above = world[f] if parents[b] < 0 else matrices[parents[b]]
                turn, way = q[f, joints[b]], t[f, joints[b]]
                rotation, move = (turn[0], turn[1], turn[2], turn[3]), (way[0], way[1], way[2])
                place_joint(above, rotation, move, scales[f, joints[b]], matrices[b])
            above = world[f] if parents[root] < 0 else matrices[parents[root]]
            _unit_axes(matrices, above, moving[:n_moving], in_frame, axes)
            _derivative(matrices, axes, points, moves, pulled[:n_pulled], moving[:n_moving], spread)
            for i in range(n_pulled):
                p = pulled[i]
                for k in range(3):
                    gap = goals[f, p, k] - matrices[points[p], k, 3]
                    missing[3 * i + k] = gap - softness[f, p] * forces[3 * i + k]
            _form(spread, moves, softness[f], pulled[:n_pulled], moving[:n_moving], normal)
            _solve(normal, 3 * n_pulled, scale, missing)
            forces[: 3 * n_pulled] += missing[: 3 * n_pulled]
            _pull_back(spread, moves, missing, in_frame, pulled[:n_pulled], moving[:n_moving], turns)
            if _turn(turns, joints, moving[:n_moving], root, q[f], t[f]) < least:
                break


@compiled
def _chosen(softness, moves, free, pulled, moving):
    """List the points that are pulled, and the joints, or the root's moves, that can move one of them."""
    n_pulled, n_moving = 0, 0
    for p in range(len(softness)):
        if softness[p] < np.inf:
            pulled[n_pulled] = p
            n_pulled += 1
    for b in range(len(free)):
        is_moving = False
        for i in range(n_pulled):
            is_moving |= moves[pulled[i], b]
        if is_moving and free[b] > 0.0:
            moving[n_moving] = b
            n_moving += 1
    return n_pulled, n_moving


@compiled
def _units_in_frame(units, is_right, free, rotations, joints, moving, in_frame):
    """Scale units, and bring those of right-invariant metrics into the frames of their joints."""
    for b in moving:
        for k in range(3):
            v = (free[b] * units[b, 0, k], free[b] * units[b, 1, k], free[b] * units[b, 2, k])
            if b < len(is_right) and is_right[b]:
                q = rotations[joints[b]]
                v = rotate_back((q[0], q[1], q[2], q[3]), v)
            in_frame[b, 0, k], in_frame[b, 1, k], in_frame[b, 2, k] = v


@compiled
def _unit_axes(matrices, above_root, moving, in_frame, axes):
    """Write the units in the world: turns about axes without scales, and moves in the space above the root."""
    for b in moving:
        is_turn = b < len(matrices)
        frame = matrices[b] if is_turn else above_root
        for j in range(3):
            length = np.sqrt(frame[0, j] ** 2 + frame[1, j] ** 2 + frame[2, j] ** 2) if is_turn else 1.0
            share = 1.0 / length if length > 0.0 else 1.0
            for i in range(3):
                for k in range(3):
                    part = share * frame[i, j] * in_frame[b, j, k]
                    axes[b, i, k] = part if j == 0 else axes[b, i, k] + part


@compiled
def _derivative(matrices, axes, points, moves, pulled, moving, spread):
    """Write how points move with units: a turn about an axis moves a point by axis x arm."""
    for p in pulled:
        o = matrices[points[p]]
        for b in moving:
            if not moves[p, b]:
                continue
            if b == len(matrices):
                for i in range(3):
                    for k in range(3):
                        spread[p, b, i, k] = axes[b, i, k]
                continue
            m = matrices[b]
            arm = (o[0, 3] - m[0, 3], o[1, 3] - m[1, 3], o[2, 3] - m[2, 3])
            for k in range(3):
                way = cross((axes[b, 0, k], axes[b, 1, k], axes[b, 2, k]), arm)
                spread[p, b, 0, k], spread[p, b, 1, k], spread[p, b, 2, k] = way


@compiled
def _form(spread, moves, softness, pulled, moving, normal):
    """Write the lower half of J J^T, with the softness on its diagonal."""
    for i in range(len(pulled)):
        for j in range(i + 1):
            p, o = pulled[i], pulled[j]
            soft = softness[p] if i == j else 0.0
            x, y, z = (soft, 0.0, 0.0), (0.0, soft, 0.0), (0.0, 0.0, soft)
            for b in moving:
                if moves[p, b] and moves[o, b]:
                    u, v = _rows(spread, p, b), _rows(spread, o, b)
                    x = (x[0] + dot(u[0], v[0]), x[1] + dot(u[0], v[1]), x[2] + dot(u[0], v[2]))
                    y = (y[0] + dot(u[1], v[0]), y[1] + dot(u[1], v[1]), y[2] + dot(u[1], v[2]))
                    z = (z[0] + dot(u[2], v[0]), z[1] + dot(u[2], v[1]), z[2] + dot(u[2], v[2]))
            for m in range(3):
                normal[3 * i, 3 * j + m], normal[3 * i + 1, 3 * j + m], normal[3 * i + 2, 3 * j + m] = x[m], y[m], z[m]


@compiled
def _rows(spread, p, b):
    """Return how a point moves with three units, row by row."""
    return (
        (spread[p, b, 0, 0], spread[p, b, 0, 1], spread[p, b, 0, 2]),
        (spread[p, b, 1, 0], spread[p, b, 1, 1], spread[p, b, 1, 2]),
        (spread[p, b, 2, 0], spread[p, b, 2, 1], spread[p, b, 2, 2]),
    )


@compiled
def _solve(normal, n, scale, x):
    """Solve in place by Cholesky's method; equations are scaled alike first, so that soft ones do no harm."""
    for i in range(n):
        scale[i] = 1.0 / np.sqrt(normal[i, i])
        x[i] *= scale[i]
    for i in range(n):
        for j in range(i + 1):
            total = scale[i] * scale[j] * normal[i, j]
            for k in range(j):
                total -= normal[i, k] * normal[j, k]
            normal[i, j] = np.sqrt(total) if i == j else total / normal[j, j]
        for k in range(i):
            x[i] -= normal[i, k] * x[k]
        x[i] /= normal[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= normal[k, i] * x[k]
        x[i] /= normal[i, i]
    for i in range(n):
        x[i] *= scale[i]


@compiled
def _pull_back(spread, moves, forces, in_frame, pulled, moving, turns):
    """Write the turns, and the move, that multipliers stand for."""
    for b in moving:
        x, y, z = 0.0, 0.0, 0.0
        for i in range(len(pulled)):
            if moves[pulled[i], b]:
                s = spread[pulled[i], b]
                for k in range(3):
                    x += forces[3 * i + k] * s[k, 0]
                    y += forces[3 * i + k] * s[k, 1]
                    z += forces[3 * i + k] * s[k, 2]
        for k in range(3):
            turns[b, k] = in_frame[b, k, 0] * x + in_frame[b, k, 1] * y + in_frame[b, k, 2] * z


@compiled
def _turn(turns, joints, moving, root, rotations, translations):
    """Turn joints by Exp of their turns, move the root, and return the largest turn about an axis."""
    largest = 0.0
    for b in moving:
        x, y, z = turns[b]
        if b == len(joints):
            translations[joints[root], 0] += x
            translations[joints[root], 1] += y
            translations[joints[root], 2] += z
            continue
        largest = max(largest, abs(x), abs(y), abs(z))
        turned = multiply(rotations[joints[b]], exp_of((x, y, z)))
        for k in range(4):
            rotations[joints[b], k] = turned[k]
    return largest
