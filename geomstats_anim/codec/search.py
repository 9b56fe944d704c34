"""Search for integers that take few bits and keep every marker within a tolerance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Skeleton
from geomstats_anim.kernels import lattice_search as kernel
from geomstats_anim.kernels.contexts import CLASSES, PARTS, Lattice
from geomstats_anim.kernels.lattice_search import Pose
from geomstats_anim.rotations import Array

_EXPECTED = 2.0 ** (0.5 * np.arange(CLASSES)[:, None] - 1.0) / PARTS
"""Sizes in the middle of every class, with which costs begin: those of geometric distributions."""

_WORTH = 8.0
"""Integers that these are worth beside those that are counted."""

_WHOLE = 4
"""Passes from one that visits everything to the next; those between visit what has moved, except in repairs."""

_CLOSE = 0.97
"""Of the tolerance: joints with errors beyond this weigh more from then on."""


class Effort(NamedTuple):
    """Limits of a search.

    Attributes
    ----------
    passes : tuple of float
        Bits that an error of the tolerance at one marker is worth, pass by pass.
    free : int
        Passes after which joints with errors about the tolerance weigh more, by `growth` each time.
    growth : float
    repairs : int
        Passes at most in which they weigh twice as much each time, until none is beyond the tolerance. With none at
        all, steps are so fine that rounding keeps the tolerance, and passes that lose it are taken back.
    """

    passes: tuple[float, ...]
    free: int
    growth: float
    repairs: int


EFFORTS = {"full": Effort((1.0, 0.5, *30 * (0.2,)), 4, 1.3, 30), "fast": Effort((16.0,), 1, 1.0, 0)}


def joints_below(parents: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return `below`, `members` and `member_parents` of a `Pose`."""
    members: list[list[int]] = [[joint] for joint in range(len(parents))]
    places: list[list[int]] = [[0] for _ in parents]
    at: list[dict[int, int]] = [{joint: 0} for joint in range(len(parents))]
    for joint, parent in enumerate(parents.tolist()):
        ancestor = parent
        while ancestor >= 0:
            at[ancestor][joint] = len(members[ancestor])
            places[ancestor].append(at[ancestor][parent])
            members[ancestor].append(joint)
            ancestor = int(parents[ancestor])
    below = np.cumsum([0] + [len(each) for each in members])
    flat = [np.array([x for each in lists for x in each], dtype=np.intp) for lists in (members, places)]
    return below.astype(np.intp), flat[0], flat[1]


def search(pose: Pose, lattice: Lattice, groups: np.ndarray, tolerance: float, effort: Effort) -> bool:
    """Improve the integers of some groups.

    Parameters
    ----------
    pose : Pose
        Of these integers; moved along with them.
    lattice : Lattice
    groups : array-like of int
        To visit, joints from the root down.
    tolerance : float
        Metres.
    effort : Effort

    Returns
    -------
    done : bool
        Whether every marker is within the tolerance, up to rounding.
    """
    if not effort.repairs:
        return _thinned(pose, lattice, groups, tolerance, effort)
    components = chosen = _components(groups)
    moved = np.zeros(len(chosen), dtype=np.intp)
    for attempt in range(len(effort.passes) + effort.repairs + 1):
        if attempt > effort.free:
            distances = largest_errors(pose)
            is_repair = attempt >= len(effort.passes)
            if is_repair and distances.max(initial=0.0) <= tolerance:
                return True
            pose.weights[distances > _CLOSE * tolerance] *= 2.0 if is_repair else effort.growth
        weight = effort.passes[min(attempt, len(effort.passes) - 1)]
        if not effort.free < attempt < len(effort.passes) or attempt % _WHOLE == 0:
            chosen = components
        else:
            chosen = chosen[moved > 0]
        moved = _sweep(pose, lattice, chosen, attempt % 2 == 1, tolerance, weight)
    return bool(largest_errors(pose).max(initial=0.0) <= tolerance)


def _thinned(pose: Pose, lattice: Lattice, groups: np.ndarray, tolerance: float, effort: Effort) -> bool:
    """Sweep over integers that keep the tolerance; take back what loses it. Return False if they do not."""
    if largest_errors(pose).max(initial=0.0) > tolerance:
        return False
    for weight in effort.passes:
        before = lattice.integers.copy()
        _sweep(pose, lattice, _components(groups), False, tolerance, weight)
        if largest_errors(pose).max(initial=0.0) > tolerance:
            lattice.integers[:] = before
            break
    return True


def search_plain(pose: Pose, lattice: Lattice, groups: np.ndarray, effort: Effort) -> bool:
    """Improve the integers of groups of plain numbers; return whether all are within their tolerances."""
    if not effort.repairs:
        return is_kept(pose)
    weight = 1.0
    for attempt in range(len(effort.passes) + effort.repairs if len(groups) else 0):
        weight = effort.passes[attempt] if attempt < len(effort.passes) else 2.0 * weight
        _sweep(pose, lattice, _components(groups), False, 1.0, weight)
        if attempt >= len(effort.passes) - 1 and is_kept(pose):
            return True
    return is_kept(pose)


def _components(groups: np.ndarray) -> np.ndarray:
    return (3 * groups[:, None] + np.arange(3)).ravel()


def _sweep(
    pose: Pose, lattice: Lattice, components: np.ndarray, upwards: bool, tolerance: float, weight: float
) -> np.ndarray:
    """Visit components once; return how many integers of each moved."""
    moved = np.zeros(len(components), dtype=np.intp)
    kernel.sweep(pose, lattice, components, upwards, tolerance, weight, _costs(lattice), moved)
    return moved


def is_kept(pose: Pose) -> bool:
    """Return whether plain numbers are within their tolerances."""
    return not np.any(np.abs(pose.plain - pose.plain_targets) > pose.plain_tolerances[:, None])


def largest_errors(pose: Pose) -> Array:
    """Return the largest distance of each joint's markers from their places, shape=[F, B], metres."""
    distances = np.empty(pose.weights.shape)
    kernel.errors(pose, distances)
    return distances


def _costs(lattice: Lattice) -> Array:
    """Return the bits of every size of integer, by class of the expected size, as the integers are now."""
    counts = np.zeros((CLASSES, kernel.LARGEST + 1))
    kernel.recount(lattice, counts)
    around = np.pad(counts, ((1, 1), (0, 0)))
    counts += 0.5 * (around[:-2] + around[2:])
    ratio = _EXPECTED / (1.0 + _EXPECTED)
    geometric = (1.0 - ratio) * ratio ** np.arange(kernel.LARGEST + 1)
    geometric[:, -1] = ratio[:, 0] ** kernel.LARGEST
    return -np.log2((counts + _WORTH * geometric) / (counts.sum(axis=-1, keepdims=True) + _WORTH))


def marker_places(skeleton: Skeleton, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order markers by joint: return the order, and where each joint's begin, shape=[B + 1]."""
    order = np.argsort(joints, kind="stable")
    return order, np.searchsorted(joints[order], np.arange(skeleton.n_joints + 1)).astype(np.intp)
