"""What is known of an integer before it is coded: the integers around it, in time, in scale and in the skeleton."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.kernels.compilation import inlined

ROTATION, TRANSLATION, PLAIN = 0, 1, 2
"""Kinds of groups: rotation vectors and translations of joints, and numbers that place nothing."""


class Lattice(NamedTuple):
    """Integers of wavelets in time, and what they stand for; three components make a group.

    Attributes
    ----------
    integers : array-like of int, shape=[F, G, 3]
        From coarse to fine.
    bands : array-like of int, shape=[L + 2]
        Where each band begins, and F.
    kinds, joints, parents : array-like of int, shape=[G]
        Kind of each group, its joint or place, and the group that it hangs below, -1 for none.
    units : array-like, shape=[L + 1, G]
        What an integer of a band stands for: radians, metres, or units of its own.
    pointers, starts, values : array-like
        Basis functions, see `Basis`.
    """

    integers: np.ndarray
    bands: np.ndarray
    kinds: np.ndarray
    joints: np.ndarray
    parents: np.ndarray
    units: np.ndarray
    pointers: np.ndarray
    starts: np.ndarray
    values: np.ndarray


ACTIVITIES = 16
"""Classes of how large the integers around one are."""


@inlined
def above_of(bands, band, k):
    """Return the coefficient of the next coarser band at the same time, -1 if there is none."""
    if band == 0:
        return -1
    first, coarser = bands[band], bands[band - 1]
    offset = k - first if band == 1 else (k - first) // 2
    return min(coarser + offset, first - 1)


@inlined
def neighbours(q, bands, parents, band, k, group, c):
    """Return the sizes of what is coded before an integer: before in time, coarser, other components, parent joint."""
    first = bands[band]
    before = 2 * abs(q[k - 1, group, c]) if k > first else 0
    before += abs(q[k - 2, group, c]) if k > first + 1 else 0
    up = above_of(bands, band, k)
    coarser = 0
    if up >= 0:
        coarser = 2 * abs(q[up, group, c])
        coarser += abs(q[up + 1, group, c]) if up + 1 < first else 0
    others = 0
    for i in range(3):
        if i < c:
            others += 2 * abs(q[k, group, i])
        elif i > c and k > first:
            others += abs(q[k - 1, group, i])
    above = parents[group]
    family = 0
    if above >= 0:
        family = abs(q[k, above, 0]) + abs(q[k, above, 1]) + abs(q[k, above, 2])
    return before, coarser, others, family


@inlined
def activity_class(before, coarser, others, family):
    """Return the class, below `ACTIVITIES`, of the sizes that `neighbours` gives."""
    total = 3 * before + 2 * coarser + 2 * others + family
    if total < 6:
        return total
    if total < 24:
        return 6 + (total - 6) // 4  # 6 to 10
    if total < 48:
        return 11 + (total - 24) // 12  # 11, 12
    return 13 if total < 80 else 14 if total < 160 else 15
