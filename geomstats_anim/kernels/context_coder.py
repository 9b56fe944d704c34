"""Entropy coding of the integers of a lattice: what is decided, and in which contexts."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.binary_coder import AT, BEYOND, CODE, EVEN, decide_at
from geomstats_anim.kernels.compilation import compiled, inlined
from geomstats_anim.kernels.context_priors import ANY, LONGER, MORE, NONZERO, USED
from geomstats_anim.kernels.contexts import above_of, activity_class, neighbours

UNARY = 14
"""Sizes up to here are coded as one decision per unit, the rest by its length in binary."""

DIGITS = 29
"""Binary digits of the largest numbers, so that integers have room in 32 bits."""

LARGEST = 2**DIGITS - 1
"""Largest size of an integer that is coded."""


@inlined
def few(n):
    """Return a class of a size: 0, 1, 2, 3 to 4, 5 to 8, more."""
    return n if n < 3 else 3 if n < 5 else 4 if n < 9 else 5


@compiled
def code_triple(model, lattice, sums, band, k, group, crowd):
    """Code the three integers of a group; return the sum of their sizes."""
    q, level = lattice.integers, min(len(lattice.bands) - 2 - band, 7)
    before, coarser, family = around_triple(sums, lattice.bands, lattice.parents, band, k, group)
    busy = activity_class(before, coarser, 0, family)
    is_any = q[k, group, 0] != 0 or q[k, group, 1] != 0 or q[k, group, 2] != 0
    near = (few(before) * 6 + few(coarser)) * 8 + level
    beside = (few(family) * 6 + few(crowd)) * 3 + min(before, 2)
    crowded = (few(crowd) * 16 + busy) * 8 + level
    is_any = decide_at(
        model, 0, level, ANY[busy, level], near, beside, group * 8 + level, busy * 8 + level,
        group * 6 + few(busy // 2), crowded, is_any,
    )  # fmt: skip
    if not is_any:
        return 0
    total = 0
    for c in range(3):
        size = code_size(model, lattice, band, k, group, c, crowd, total, abs(q[k, group, c]))
        if size:
            negative = code_sign(model, lattice, band, k, group, c, q[k, group, c] < 0)
            if model.decoding:
                size = min(size, LARGEST)
                q[k, group, c] = -size if negative else size
        total += size
    return total


@inlined
def around_triple(sums, bands, parents, band, k, group):
    """Return sums over components of what `neighbours` gives: before in time, coarser, parent joint."""
    first, up = bands[band], above_of(bands, band, k)
    before = 2 * sums[k - 1, group] if k > first else 0
    before += sums[k - 2, group] if k > first + 1 else 0
    coarser = 2 * sums[up, group] if up >= 0 else 0
    coarser += sums[up + 1, group] if up >= 0 and up + 1 < first else 0
    above = parents[group]
    return before, coarser, sums[k, above] if above >= 0 else 0


@compiled
def code_size(model, lattice, band, k, group, c, crowd, total, size):
    """Code the size of an integer, in a group that has any, when those before it have a total."""
    before, coarser, others, family = neighbours(lattice.integers, lattice.bands, lattice.parents, band, k, group, c)
    channel, level = group * 3 + c, min(len(lattice.bands) - 2 - band, 7)
    busy = activity_class(before, coarser, others, family)
    near = (few(before) * 6 + few(coarser)) * 8 + level
    beside = (few(others) * 6 + few(family)) * 3 + min(before, 2)
    state = c if total == 0 else c + 2  # 0, 1, 3, 4: in the last component of three, one must be there
    if total > 0 or c < 2:
        nonzero = decide_at(
            model, 1, 15 + state, NONZERO[busy, state], near * 5 + state, beside * 5 + state, channel * 5 + state,
            busy * 5 + state, group * 5 + state, (few(crowd) * 16 + busy) * 5 + state, size > 0,
        )  # fmt: skip
        if not nonzero:
            return 0
    n = 1
    while n <= UNARY:
        m = min(n - 1, 6)
        more = decide_at(
            model,
            2,
            8 + m,
            MORE[busy, m],
            near * 7 + m,
            beside * 7 + m,
            channel * 7 + m,
            (busy * 8 + level) * 7 + m,
            group * 7 + m,
            (few(crowd) * 16 + busy) * 7 + m,
            size > n,
        )
        if not more:
            return n
        n += 1
    return UNARY + 1 + code_number(model, 4, group, size - UNARY - 1)


@compiled
def code_number(model, section, group, number):
    """Code a number from 0 on: the length of its binary form, then its bits."""
    length = 0
    if not model.decoding:
        while (number + 1) >> (length + 1):
            length += 1
    n = 0
    while n < DIGITS:
        more = decide_at(
            model,
            section,
            20 + min(n, 12),
            LONGER[1 if section == 6 else 0, min(n, 15)],
            n,
            32 + n,
            group * 32 + n,
            n,
            64 + n,
            96 + n,
            length > n,
        )
        if not more:
            break
        n += 1
    value = 1
    for i in range(n - 1, -1, -1):
        first = n - 1 - i
        bit = decide_at(
            model,
            section,
            41,
            EVEN,
            128 + min(first, 3) * 32 + n,
            256 + value % 4,
            256,
            256,
            256,
            256,
            ((number + 1) >> i) & 1,
        )
        value = 2 * value + bit
    return value - 1


@inlined
def sign_class(n):
    """Return 0, 1 or 2 for zero, positive, negative."""
    return 0 if n == 0 else 1 if n > 0 else 2


@compiled
def code_sign(model, lattice, band, k, group, c, negative):
    """Code the sign of an integer that is not zero."""
    q, bands = lattice.integers, lattice.bands
    left = sign_class(q[k - 1, group, c]) if k > bands[band] else 0
    second = sign_class(q[k - 2, group, c]) if k > bands[band] + 1 else 0
    up = above_of(bands, band, k)
    coarser = sign_class(q[up, group, c]) if up >= 0 else 0
    after = sign_class(q[up + 1, group, c]) if up >= 0 and up + 1 < bands[band] else 0
    above = lattice.parents[group]
    family = sign_class(q[k, above, c]) if above >= 0 else 0
    o1 = sign_class(q[k, group, 0]) if c > 0 else 0
    o2 = sign_class(q[k, group, 1]) if c > 1 else 0
    level = min(len(bands) - 2 - band, 7)
    channel = group * 3 + c
    beside = (channel * 3 + o1) * 3 + o2
    over = ((coarser * 3 + after) * 2 + (k - bands[band]) % 2) * 3 + left
    around = ((family * 3 + c) * 3 + o1) * 3 + o2
    past = (left * 3 + second) * 8 + level
    return decide_at(
        model, 3, 42 + level, EVEN, past, over, channel * 3 + family, beside, channel * 3 + left, around, negative
    )


@compiled
def code_scaling(model, lattice, k, group, c):
    """Code a scaling coefficient, as its difference from the one before."""
    q = lattice.integers
    before = q[k - 1, group, c] if k > 0 else 0
    rest = q[k, group, c] - before
    first = 0 if k == 0 else 1
    number = code_number(model, 5 + first, group, abs(rest))
    if number:
        channel = group * 3 + c
        negative = decide_at(model, 7, 50 + first, EVEN, first, channel, 0, 0, 0, 0, rest < 0)
        number = -number if negative else number
    if model.decoding:
        q[k, group, c] = min(max(before + number, -LARGEST), LARGEST)


@compiled
def code(model, lattice):
    """Code all integers, from coarse to fine; what is decoded is written into `lattice.integers`.

    Returns False, at once, where a stream that is decoded has ended long before its integers.

    Parameters
    ----------
    model : Model
    lattice : Lattice
    """
    q, bands = lattice.integers, lattice.bands
    n_groups = q.shape[1]
    if model.decoding:
        for i in range(4):
            model.coder[CODE] = (model.coder[CODE] << 8) | (model.stream[i] if i < len(model.stream) else 0)
        model.coder[AT] = 4
    is_used = np.ones(n_groups, dtype=np.int64)
    sums = np.zeros((len(q), n_groups), dtype=np.int64)  # of the sizes in each group
    for band in range(len(bands) - 1):
        code_used(model, lattice, band, is_used)
        for k in range(bands[band], bands[band + 1]):
            if model.decoding and model.coder[AT] > len(model.stream) + BEYOND:
                return False
            crowd = 0
            for group in range(n_groups):
                if not is_used[group]:
                    continue
                if band == 0:
                    for c in range(3):
                        code_scaling(model, lattice, k, group, c)
                        sums[k, group] += abs(q[k, group, c])
                else:
                    sums[k, group] = code_triple(model, lattice, sums, band, k, group, crowd)
                    crowd += sums[k, group]
    return True


@compiled
def code_used(model, lattice, band, is_used):
    """Code which groups have anything in a band."""
    q, bands = lattice.integers, lattice.bands
    level = min(len(bands) - 2 - band, 15)
    for group in range(q.shape[1]):
        used = 0
        for k in range(bands[band], bands[band + 1]):
            for c in range(3):
                used |= q[k, group, c] != 0
        above = lattice.parents[group]
        family = is_used[above] if above >= 0 else 2
        is_used[group] = decide_at(
            model,
            8,
            52,
            USED[level, family, is_used[group]],
            level * 2 + is_used[group],
            group,
            group * 2 + is_used[group],
            (level * 3 + family) * 2 + is_used[group],
            level,
            is_used[group],
            used,
        )
