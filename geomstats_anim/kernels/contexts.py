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


PARTS = 64
"""Expected sizes are in 64ths."""

CLASSES = 32
"""Classes of expected sizes: 0, then by half octaves."""

# how much of the sizes around it an integer is expected to have: one and two before in time, in the coarser band and
# after that, other components now and before, the parent joint, all groups before; fitted on motion capture
BEFORE, SECOND, COARSER, AFTER, BESIDE, BESIDE_BEFORE, PARENT, CROWD = 22, 4, 6, 1, 5, 3, 3, 4


def _class(expected: int) -> int:
    length = expected.bit_length()
    return expected if expected < 2 else 2 * length - 2 + ((expected >> (length - 2)) & 1)


_CLASS_OF = np.array([_class(expected) for expected in range(4096)])


@inlined
def class_of(expected):
    """Return the class, below `CLASSES`, of an expected size."""
    octaves = 0
    while expected >= 4096:
        expected >>= 1
        octaves += 1
    return min(_CLASS_OF[expected] + 2 * octaves, CLASSES - 1)


@inlined
def octave_of(expected):
    """Return the octave, up to 15, of an expected size: two classes, and 0 for nothing."""
    found = class_of(expected)
    return min(found // 2 + 1, 15) if found else 0


@inlined
def above_of(bands, band, k):
    """Return the coefficient of the next coarser band at the same time, -1 if there is none."""
    if band == 0:
        return -1
    first, coarser = bands[band], bands[band - 1]
    offset = k - first if band == 1 else (k - first) // 2
    return min(coarser + offset, first - 1)


@inlined
def expected_in_time(sizes, bands, band, k):
    """Return the size that is expected of a wavelet, in 64ths, from those before it in time and in the coarser band."""
    first, up = bands[band], above_of(bands, band, k)
    expected = COARSER * abs(sizes[up]) + (AFTER * abs(sizes[up + 1]) if up + 1 < first else 0)
    if k > first:
        expected += BEFORE * abs(sizes[k - 1])
    if k > first + 1:
        expected += SECOND * abs(sizes[k - 2])
    return expected


@inlined
def expected_beside(q, bands, parents, band, k, group, c):
    """Return the size that is expected of a wavelet, in 64ths, from the other components and the parent joint."""
    expected = 0
    for i in range(3):
        if i < c:
            expected += BESIDE * abs(q[k, group, i])
        elif i > c and k > bands[band]:
            expected += BESIDE_BEFORE * abs(q[k - 1, group, i])
    above = parents[group]
    return expected + PARENT * abs(q[k, above, c]) if above >= 0 else expected
