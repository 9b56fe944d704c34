"""Compiled errors of slerp between two frames, and the shortest paths over them; see `keyframes.dynamic_programming`.

A truth has the attributes of `keyframes.dynamic_programming.Truth`.
"""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.affine import place_joint, place_marker
from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.vectors import conjugate, dot, multiply, rotate

_PATIENCE = 24
"""Segments in a row that are beyond the tolerance before longer ones are no longer tried: slerp may meet a motion that
swings back to it by chance, but not after long."""


@compiled
def fill(start, stop, candidates, truth, errors):
    """Fill in the elements from start to stop of the flattened errors, shape=[N, W]."""
    room = _room(len(truth.order))
    for segment in range(start, stop):
        n, w = divmod(segment, errors.shape[1])
        if n + 1 + w < len(candidates):
            errors[n, w] = _error(candidates[n], candidates[n + 1 + w], truth, np.inf, room)


@compiled
def fill_layers(start, stop, layers, truth, errors):
    """Fill in the elements from start to stop of the flattened errors, shape=[K - 1, M, M], between layers of frames.

    The layers, shape=[K, M], hold frames, and -1 where they have fewer.
    """
    room, width = _room(len(truth.order)), layers.shape[1]
    for segment in range(start, stop):
        k, pair = divmod(segment, width * width)
        i, j = divmod(pair, width)
        first, last = layers[k, i], layers[k + 1, j]
        if 0 <= first < last:
            errors[k, i, j] = _error(first, last, truth, np.inf, room)


@compiled
def reach(candidates, forced, truth, tolerance, before):
    """Fill in the candidate before each one, shape=[N], on the path of fewest keys within a tolerance.

    Where no path leads, it is -1.
    """
    n_candidates, room = len(candidates), _room(len(truth.order))
    keys = np.full(n_candidates, n_candidates + 1)
    keys[0] = 0
    for n in range(n_candidates):
        failed = 0
        for m in range(n + 1, n_candidates):
            if keys[n] + 1 < keys[m]:
                if _error(candidates[n], candidates[m], truth, tolerance, room) <= tolerance:
                    failed = 0
                    keys[m] = keys[n] + 1
                    before[m] = n
                else:
                    failed += 1
            if forced[m] or failed > _PATIENCE:
                break


@compiled
def cheapest(errors, forced, largest, steps):
    """Fill in how far back the key before each candidate is, for every number of keys so far; return the cost."""
    n_candidates, window = errors.shape
    barrier = np.zeros(n_candidates, np.int64)
    for n in range(1, n_candidates):
        barrier[n] = n - 1 if forced[n - 1] else barrier[n - 1]
    cost, longer = np.full(n_candidates, np.inf), np.empty(n_candidates)
    cost[0] = 0.0
    for k in range(1, len(steps)):
        longer[:] = np.inf
        for m in range(k, n_candidates):
            for n in range(max(barrier[m], m - window), m):
                error = errors[n, m - n - 1]
                total = max(cost[n], error) if largest else cost[n] + error
                if total < longer[m]:
                    longer[m] = total
                    steps[k, m] = m - n
        cost, longer = longer, cost
    return cost[-1]


@compiled
def cheapest_of_layers(errors, largest, steps):
    """Fill in the element of the layer before, shape=[K, M], on the cheapest path to each; return the costs, shape=[M].

    A path may start at any element of the first layer that a segment leaves.
    """
    n_layers, width = steps.shape
    cost = np.zeros(width)
    for k in range(1, n_layers):
        longer = np.full(width, np.inf)
        for j in range(width):
            for i in range(width):
                error = errors[k - 1, i, j]
                total = max(cost[i], error) if largest else cost[i] + error
                if total < longer[j]:
                    longer[j] = total
                    steps[k, j] = i
        cost = longer
    return cost


@compiled
def hold_starts(rotations, translations, still, starts):
    """Fill in the first frame, shape=[F], from which no joint has turned or moved by more than what is still."""
    n_frames, n_joints = rotations.shape[:2]
    start = 0
    for f in range(1, n_frames):
        starts[f] = start
        for b in range(n_joints):
            turn = multiply(conjugate(rotations[start, b]), rotations[f, b])
            angle = 2.0 * np.arctan2(np.sqrt(dot(turn, turn)), abs(turn[3]))
            moved = 0.0
            for i in range(3):
                moved = max(moved, abs(translations[f, b, i] - translations[start, b, i]))
            if angle > still or moved > still:
                start = f
                starts[f] = f
                break


@compiled
def _room(n_joints):
    """Return room for a pose: half the angle and the sign of every turn; rotations, origins, matrices in the world."""
    return np.empty((n_joints, 2)), np.empty((n_joints, 4)), np.empty((n_joints, 3)), np.empty((n_joints, 3, 4))


@compiled
def _error(i, j, truth, limit, room):
    """Return the error of the segment from frame i to frame j, or infinity if it is above the limit."""
    n_inner = j - i - 1
    if n_inner < 1:
        return 0.0
    times, largest = truth.times, truth.largest
    angle = room[0]
    _measure_turns(i, j, truth, angle)
    placed = truth.location.any()
    total = 0.0
    for step in range(n_inner):
        # from the middle on, where errors are largest, so that the limit is met soon
        f = i + 1 + (step + n_inner // 2) % n_inner
        u = (times[f] - times[i]) / (times[j] - times[i])
        if largest:
            total = max(total, _largest_squared_miss(i, j, f, u, truth, room))
            if total > limit * limit:
                return np.inf
            continue
        for b in truth.order:
            q = _slerp(truth.rotations[i, b], truth.rotations[j, b], u, angle[b, 0], angle[b, 1])
            if truth.rotation[b] != 0.0:
                total += truth.rotation[b] * _angle_between(q, truth.rotations[f, b])
            if placed:
                total += truth.location[b] * _squared_miss(i, j, f, u, b, q, truth, room)
    return np.sqrt(total) if largest else total


@compiled
def _measure_turns(i, j, truth, angle):
    """Write half the angle of every joint's turn, the shorter way round, and the sign of the second quaternion."""
    for b in truth.order:
        cosine = 0.0
        for c in range(4):
            cosine += truth.rotations[i, b, c] * truth.rotations[j, b, c]
        # signs are continuous along time, but not over long gaps
        angle[b, 0] = np.arccos(min(abs(cosine), 1.0))
        angle[b, 1] = 1.0 if cosine >= 0.0 else -1.0


@compiled
def _slerp(start, end, u, theta, sign):
    """Interpolate quaternions that are theta apart, the second one with a sign."""
    if theta > 1e-4:
        scale = 1.0 / np.sin(theta)
        first, second = np.sin((1.0 - u) * theta) * scale, np.sin(u * theta) * scale * sign
    else:
        first, second = 1.0 - u, u * sign
    return (
        first * start[0] + second * end[0],
        first * start[1] + second * end[1],
        first * start[2] + second * end[2],
        first * start[3] + second * end[3],
    )


@compiled
def _angle_between(q, r):
    """Return the angle between two rotations, radians."""
    sign = 1.0 if q[0] * r[0] + q[1] * r[1] + q[2] * r[2] + q[3] * r[3] >= 0.0 else -1.0
    squared = 0.0
    for c in range(4):
        squared += (q[c] - sign * r[c]) ** 2
    # by the chord of a quarter of the angle, which is exact where the arc cosine is not
    return 4.0 * np.arcsin(0.5 * np.sqrt(squared))


@compiled
def _largest_squared_miss(i, j, f, u, truth, room):
    """Place all joints, and return the largest squared distance of a marker from where it is in frame f."""
    angle, _, _, matrices = room
    a, b = truth.translations[i], truth.translations[j]
    for joint in truth.order:
        q = _slerp(truth.rotations[i, joint], truth.rotations[j, joint], u, angle[joint, 0], angle[joint, 1])
        t = (
            (1.0 - u) * a[joint, 0] + u * b[joint, 0],
            (1.0 - u) * a[joint, 1] + u * b[joint, 1],
            (1.0 - u) * a[joint, 2] + u * b[joint, 2],
        )
        parent = truth.parents[joint]
        above = truth.world[f] if parent < 0 else matrices[parent]
        place_joint(above, q, t, truth.scales[f, joint], matrices[joint])
    largest = 0.0
    for p in range(len(truth.joints)):
        x, y, z = place_marker(matrices, truth.joints[p], truth.offsets[p], truth.weights[p])
        dx, dy, dz = x - truth.places[f, p, 0], y - truth.places[f, p, 1], z - truth.places[f, p, 2]
        largest = max(largest, dx * dx + dy * dy + dz * dz)
    return largest


@compiled
def _squared_miss(i, j, f, u, b, q, truth, room):
    """Place a joint in the world, and return the squared distance of its bone's end from where it is in frame f."""
    _, world, origin, _ = room
    translations, bone_ends, ends = truth.translations, truth.bone_ends, truth.ends
    x = (1.0 - u) * translations[i, b, 0] + u * translations[j, b, 0]
    y = (1.0 - u) * translations[i, b, 1] + u * translations[j, b, 1]
    z = (1.0 - u) * translations[i, b, 2] + u * translations[j, b, 2]
    p = truth.parents[b]
    if p >= 0:
        above = (world[p, 0], world[p, 1], world[p, 2], world[p, 3])
        q = multiply(above, q)
        moved = rotate(above, (x, y, z))
        x, y, z = origin[p, 0] + moved[0], origin[p, 1] + moved[1], origin[p, 2] + moved[2]
    for c in range(4):
        world[b, c] = q[c]
    origin[b, 0], origin[b, 1], origin[b, 2] = x, y, z
    end = rotate(q, (bone_ends[b, 0], bone_ends[b, 1], bone_ends[b, 2]))
    dx = x + end[0] - ends[f, b, 0]
    dy = y + end[1] - ends[f, b, 1]
    dz = z + end[2] - ends[f, b, 2]
    return dx * dx + dy * dy + dz * dz
