"""What slerping from one frame to another would cost, for every pair of frames that could be neighbouring keys.

Slerp is the bi-invariant geodesic, and the only scheme whose error between two keys depends on nothing but them: with
it, choosing keys is a shortest path.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.kernels.vectors import compiled, multiply, rotate
from geomstats_anim.kinematics import breadth_first, world_pose
from geomstats_anim.rotations import Array


class Measure(NamedTuple):
    """What counts as error.

    Attributes
    ----------
    location, rotation : array-like, shape=[B]
        Weight of each joint's squared distance of bone ends, square metres, and of its angle, radians.
    largest : bool
        Whether the largest distance of bone ends counts instead, over joints and frames, metres.
    """

    location: Array
    rotation: Array
    largest: bool


def segment_errors(animation: Animation, candidates: np.ndarray, window: int, measure: Measure) -> Array:
    """Measure the error of every segment between candidates that are not further apart than a window.

    Parameters
    ----------
    animation : Animation
        The truth.
    candidates : array-like of int, shape=[N]
        Frames that may be keys, increasing.
    window : int
        Candidates that a segment may reach ahead, W.
    measure : Measure

    Returns
    -------
    errors : array-like, shape=[N, W]
        Of the segment from candidate n to candidate n + 1 + w: the sum over its inner frames, or the largest;
        infinite beyond the last candidate.
    """
    errors = np.full((len(candidates), window), np.inf)
    truth = _truth(animation, measure)

    def run(part: slice) -> None:
        _fill(part.start, part.stop, candidates, truth, errors)

    in_threads(run, errors.size)
    return errors


def fewest(animation: Animation, candidates: np.ndarray, forced: np.ndarray, tolerance: float) -> np.ndarray:
    """Find the fewest candidates between which slerping stays within a tolerance.

    Parameters
    ----------
    animation : Animation
        The truth.
    candidates : array-like of int, shape=[N]
        Frames that may be keys, increasing.
    forced : array-like of bool, shape=[N]
        Those that must be, the first and the last among them.
    tolerance : float
        Largest distance of bone ends, metres.

    Returns
    -------
    chosen : array-like of int, shape=[K]
        Indices of candidates.
    """
    nothing = np.zeros(animation.n_joints)
    before = np.zeros(len(candidates), dtype=np.intp)
    _reach(candidates, forced, _truth(animation, Measure(nothing, nothing, True)), tolerance, before)
    chosen = [len(candidates) - 1]
    while chosen[-1]:
        chosen.append(int(before[chosen[-1]]))
    return np.array(chosen[::-1], dtype=np.intp)


def cheapest(errors: Array, forced: np.ndarray, count: int, largest: bool) -> np.ndarray:
    """Choose candidates so that the segments between them cost least, by dynamic programming.

    Parameters
    ----------
    errors : array-like, shape=[N, W]
        See `segment_errors`.
    forced : array-like of bool, shape=[N]
        Candidates that must be chosen, the first and the last among them.
    count : int
        How many to choose, K.
    largest : bool
        Whether the largest error of a segment counts, not the sum.

    Returns
    -------
    chosen : array-like of int, shape=[K]
        Indices of candidates. None if the window is too narrow for so few.
    """
    steps = np.zeros((count, len(errors)), dtype=np.uint16)
    total = _cheapest(errors, forced, largest, steps)
    if not np.isfinite(total):
        return np.zeros(0, dtype=np.intp)
    chosen = [len(errors) - 1]
    for row in steps[:0:-1]:
        chosen.append(chosen[-1] - int(row[chosen[-1]]))
    return np.array(chosen[::-1], dtype=np.intp)


class _Truth(NamedTuple):
    """What the compiled code needs to know of an animation and a measure."""

    order: np.ndarray
    parents: np.ndarray
    bone_ends: Array
    times: Array
    rotations: Array
    translations: Array
    ends: Array
    location: Array
    rotation: Array
    largest: bool


def _truth(animation: Animation, measure: Measure) -> _Truth:
    skeleton = animation.skeleton
    # copies, as compiled code has one variant for arrays that may be written to and another for those that may not
    return _Truth(
        breadth_first(skeleton),
        np.array(skeleton.parents),
        np.array(skeleton.bone_ends),
        np.array(animation.times),
        np.array(animation.rotations),
        np.array(animation.translations),
        world_pose(animation).ends,
        np.array(measure.location),
        np.array(measure.rotation),
        measure.largest,
    )


@compiled
def _fill(start, stop, candidates, truth, errors):
    room = _room(len(truth.order))
    for segment in range(start, stop):
        n, w = divmod(segment, errors.shape[1])
        if n + 1 + w < len(candidates):
            errors[n, w] = _error(candidates[n], candidates[n + 1 + w], truth, np.inf, room)


_PATIENCE = 24
"""Segments in a row that are beyond the tolerance before longer ones are no longer tried: slerp may meet a motion that
swings back to it by chance, but not after long."""


@compiled
def _reach(candidates, forced, truth, tolerance, before):
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
def _cheapest(errors, forced, largest, steps):
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
def _room(n_joints):
    """Room for a pose: half the angle and the sign of every turn, rotations and origins in the world."""
    return np.empty((n_joints, 2)), np.empty((n_joints, 4)), np.empty((n_joints, 3))


@compiled
def _error(i, j, truth, limit, room):
    """Error of the segment from frame i to frame j, or any number above the limit if it is above."""
    times, rotations, translations, largest = truth.times, truth.rotations, truth.translations, truth.largest
    location, rotation, bone_ends, ends = truth.location, truth.rotation, truth.bone_ends, truth.ends
    angle, world, origin = room
    n_inner = j - i - 1
    if n_inner < 1:
        return 0.0
    for b in truth.order:
        cosine = 0.0
        for c in range(4):
            cosine += rotations[i, b, c] * rotations[j, b, c]
        # the shorter way round; signs are continuous along time, but not over long gaps
        angle[b, 0] = np.arccos(min(abs(cosine), 1.0))
        angle[b, 1] = 1.0 if cosine >= 0.0 else -1.0
    placed = largest or location.any()
    total = 0.0
    for step in range(n_inner):
        # from the middle on, where errors are largest, so that the limit is met soon
        f = i + 1 + (step + n_inner // 2) % n_inner
        u = (times[f] - times[i]) / (times[j] - times[i])
        for b in truth.order:
            theta = angle[b, 0]
            if theta > 1e-4:
                scale = 1.0 / np.sin(theta)
                first, second = np.sin((1.0 - u) * theta) * scale, np.sin(u * theta) * scale * angle[b, 1]
            else:
                first, second = 1.0 - u, u * angle[b, 1]
            q = (
                first * rotations[i, b, 0] + second * rotations[j, b, 0],
                first * rotations[i, b, 1] + second * rotations[j, b, 1],
                first * rotations[i, b, 2] + second * rotations[j, b, 2],
                first * rotations[i, b, 3] + second * rotations[j, b, 3],
            )
            if not largest and rotation[b] != 0.0:
                r = rotations[f, b]
                sign = 1.0 if q[0] * r[0] + q[1] * r[1] + q[2] * r[2] + q[3] * r[3] >= 0.0 else -1.0
                squared = 0.0
                for c in range(4):
                    squared += (q[c] - sign * r[c]) ** 2
                # by the chord of a quarter of the angle, which is exact where the arc cosine is not
                total += rotation[b] * 4.0 * np.arcsin(0.5 * np.sqrt(squared))
            if placed:
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
                squared = dx * dx + dy * dy + dz * dz
                if largest:
                    total = max(total, squared)
                else:
                    total += location[b] * squared
        if largest and total > limit * limit:
            return np.inf
    return np.sqrt(total) if largest else total
