"""Entropy coding of the integers of a lattice: what is decided, and in which contexts."""

from __future__ import annotations

import numpy as np

from geomstats_anim.kernels.binary_coder import (
    AT,
    BEYOND,
    CODE,
    EVEN,
    code_digits,
    decide_alone,
    decide_at,
)
from geomstats_anim.kernels.compilation import compiled, inlined
from geomstats_anim.kernels.context_priors import ANY, FIRST_DIGIT, LONGER, LONGER_SCALING, NONZERO, USED
from geomstats_anim.kernels.contexts import (
    CLASSES,
    CROWD,
    above_of,
    class_of,
    expected_beside,
    expected_in_time,
    octave_of,
)

DIGITS = 29
"""Binary digits of the largest integers, so that they have room in 32 bits."""

LARGEST = 2**DIGITS - 1
"""Largest size of an integer that is coded."""

_LEVELS, _STATES, _LENGTHS, _OCTAVES = 8, 5, 16, 16
"""Bands from the finest, states of a group, lengths of sizes and octaves of expected sizes that are told apart."""

_SECOND_DIGIT, _DIGIT_OF_SCALING = 31000, 32000
"""Priors of digits, in 1 / 65536."""

# sets of weights
KIND_ANY, KIND_NONZERO, KIND_LONGER, KIND_SIGN, KIND_SCALING, KIND_SCALING_SIGN, KIND_DIGIT, KIND_USED = (
    0, 8, 16, 40, 48, 51, 54, 60,
)  # fmt: skip


def _places(*sizes: int) -> list[int]:
    """Return where tables of these sizes begin, one behind the other, and where the last one ends."""
    return np.cumsum([0, *sizes]).tolist()


# tables that all groups share, by what is decided
(
    ANY_0, ANY_1, ANY_2, NONZERO_0, NONZERO_1, NONZERO_2, LONGER_0, LONGER_1, LONGER_2,
    DIGIT_0, DIGIT_1, DIGIT_2, SECOND, SIGN_0, SIGN_1, SIGN_2,
    SCALING_0, SCALING_1, SCALING_2, SCALING_3, SCALING_DIGIT, SCALING_SIGN, USED_0, USED_1, USED_2, SHARED,
) = _places(
    CLASSES * _LEVELS, _OCTAVES * _OCTAVES, CLASSES * _LEVELS,
    CLASSES * _STATES, _OCTAVES * _OCTAVES * _STATES, CLASSES * _LEVELS * _STATES,
    CLASSES * _LENGTHS, _OCTAVES * _OCTAVES * _LENGTHS, CLASSES * _LEVELS * _LENGTHS,
    CLASSES * _LENGTHS, _OCTAVES * _OCTAVES * _LENGTHS, _LEVELS * _LENGTHS,
    2 * _LENGTHS * _LENGTHS, 9 * _LEVELS, 108, 81,
    3 * _OCTAVES * _LENGTHS, 3 * _OCTAVES * _LENGTHS, 3 * _OCTAVES * _LENGTHS, 9 * _LENGTHS, 3 * _LENGTHS, 51,
    32, 96, 12,
)  # fmt: skip

# tables of a group, and those of each of its components
(
    GROUP_ANY, GROUP_BUSY, GROUP_NONZERO, GROUP_LONGER, GROUP_USED, GROUP_SCALING, GROUP_SCALING_SIGN, GROUP_COMPONENTS,
) = _places(8, 16, 40, 128, 3, 48, 24)  # fmt: skip
OWN_NONZERO, OWN_LONGER, OWN_RELATIVE, OWN_DIGIT, OWN_SIGN, OWN_PAST, COMPONENT = _places(8, 16, 16, 16, 9, 9)
GROUP = GROUP_COMPONENTS + 3 * COMPONENT
"""Contexts of a group."""


@inlined
def level_of(bands, band):
    """Return the number of a band from the finest, as far as bands are told apart."""
    return min(len(bands) - 2 - band, _LEVELS - 1)


@inlined
def length_of(size):
    """Return the number of binary digits of a size."""
    length = 0
    while size >> length:
        length += 1
    return length


@inlined
def sign_class(n):
    """Return 0, 1 or 2 for zero, positive, negative."""
    return 0 if n == 0 else 1 if n > 0 else 2


@inlined
def code_triple(model, lattice, sums, band, k, group, crowd):
    """Code the three integers of a group, when a size of `crowd` is expected by the groups before; return their sum."""
    q, bands, level = lattice.integers, lattice.bands, level_of(lattice.bands, band)
    above = lattice.parents[group]
    past = expected_in_time(sums[:, group], bands, band, k)
    near = crowd + (sums[k, above] if above >= 0 else 0)
    busy, crowded = class_of(past + near), class_of(crowd)
    own = SHARED + group * GROUP
    is_any = q[k, group, 0] != 0 or q[k, group, 1] != 0 or q[k, group, 2] != 0
    is_any = decide_at(
        model, KIND_ANY + level, ANY[busy, level],
        ANY_0 + busy * _LEVELS + level, ANY_1 + octave_of(past) * _OCTAVES + octave_of(near),
        own + GROUP_ANY + level, own + GROUP_BUSY + busy // 2, ANY_2 + crowded * _LEVELS + level, is_any,
    )  # fmt: skip
    if not is_any:
        return 0
    return code_components(model, lattice, band, level, k, group, crowd, crowded)


@compiled
def code_components(model, lattice, band, level, k, group, crowd, crowded):
    """Code the integers of a group that has any; return the sum of their sizes."""
    q, total = lattice.integers, 0
    for c in range(3):
        past = expected_in_time(q[:, group, c], lattice.bands, band, k)
        near = crowd // 3 + expected_beside(q, lattice.bands, lattice.parents, band, k, group, c)
        size = abs(q[k, group, c])
        state = c if total == 0 else c + 2  # 0, 1, 3, 4: in the last component of three, one must be there
        busy, pair = class_of(past + near), octave_of(past) * _OCTAVES + octave_of(near)
        own = SHARED + group * GROUP
        component = own + GROUP_COMPONENTS + c * COMPONENT
        if total > 0 or c < 2:
            nonzero = decide_at(
                model, KIND_NONZERO + state, NONZERO[busy, state],
                NONZERO_0 + busy * _STATES + state, NONZERO_1 + pair * _STATES + state,
                component + OWN_NONZERO + busy // 4, own + GROUP_NONZERO + state * _LEVELS + level,
                NONZERO_2 + (crowded * _LEVELS + level) * _STATES + state, size > 0,
            )  # fmt: skip
            if not nonzero:
                continue
        size = code_size(model, busy, pair, crowded, level, own, component, size)
        negative = code_sign(model, lattice, band, level, k, group, c, component, q[k, group, c] < 0)
        if model.decoding:
            q[k, group, c] = -size if negative else size
        total += size
    return total


@inlined
def code_size(model, busy, pair, crowded, level, own, component, size):
    """Code a size from 1 on: the number of its binary digits, then those behind the first."""
    length, n = length_of(size), 1
    while n < DIGITS:
        m, relative = min(n, _LENGTHS - 1), min(max(2 * n - busy // 2 + 8, 0), 15)
        longer = decide_at(
            model, KIND_LONGER + m, LONGER[busy, m],
            LONGER_0 + busy * _LENGTHS + m, LONGER_1 + pair * _LENGTHS + m,
            component + OWN_LONGER + relative, own + GROUP_LONGER + level * 16 + relative,
            LONGER_2 + (crowded * _LEVELS + level) * _LENGTHS + m, length > n,
        )  # fmt: skip
        if not longer:
            break
        n += 1
    if n == 1:
        return 1
    m, relative = min(n, _LENGTHS - 1), min(max(2 * n - busy // 2 + 8, 0), 15)
    digit = decide_at(
        model, KIND_DIGIT + min(n - 2, 3), FIRST_DIGIT[busy, m],
        DIGIT_0 + busy * _LENGTHS + m, DIGIT_1 + pair * _LENGTHS + m,
        component + OWN_RELATIVE + relative, component + OWN_DIGIT + m, DIGIT_2 + level * _LENGTHS + m,
        (size >> (n - 2)) & 1,
    )  # fmt: skip
    found = 2 + digit
    if n > 2:
        second = decide_alone(
            model, _SECOND_DIGIT, SECOND + (m * 2 + digit) * _LENGTHS + relative, (size >> (n - 3)) & 1
        )
        found = 2 * found + second
    if n > 3:
        found = found << (n - 3) | code_digits(model, n - 3, size & ((1 << (n - 3)) - 1))
    return found


@inlined
def code_sign(model, lattice, band, level, k, group, c, component, negative):
    """Code the sign of an integer that is not zero."""
    q, bands = lattice.integers, lattice.bands
    first, up = bands[band], above_of(bands, band, k)
    left = sign_class(q[k - 1, group, c]) if k > first else 0
    second = sign_class(q[k - 2, group, c]) if k > first + 1 else 0
    coarser = sign_class(q[up, group, c])
    after = sign_class(q[up + 1, group, c]) if up + 1 < first else 0
    above = lattice.parents[group]
    family = sign_class(q[k, above, c]) if above >= 0 else 0
    o1 = sign_class(q[k, group, 0]) if c > 0 else 0
    o2 = sign_class(q[k, group, 1]) if c > 1 else 0
    over = ((coarser * 3 + after) * 2 + (k - first) % 2) * 3 + left
    return decide_at(
        model, KIND_SIGN + level, EVEN,
        SIGN_0 + (left * 3 + second) * _LEVELS + level, SIGN_1 + over * 2 + (1 if level == 0 else 0),
        component + OWN_SIGN + o1 * 3 + o2, component + OWN_PAST + left * 3 + family,
        SIGN_2 + ((family * 3 + c) * 3 + o1) * 3 + o2, negative,
    )  # fmt: skip


@inlined
def step_of(q, k, group, c):
    """Return the difference of a scaling coefficient from the one before."""
    return q[k, group, c] - (q[k - 1, group, c] if k > 0 else 0)


@compiled
def code_scaling(model, lattice, k, group, c, crowd):
    """Code a scaling coefficient, as its difference from the one before; return the size of that."""
    q, above = lattice.integers, lattice.parents[group]
    before = q[k - 1, group, c] if k > 0 else 0
    rest, which = q[k, group, c] - before, min(k, 2)
    past = 40 * abs(step_of(q, k - 1, group, c)) if k > 1 else 0
    for i in range(c):
        past += 20 * abs(step_of(q, k, group, i))
    near, parent = crowd, 0
    if above >= 0:
        parent = sign_class(step_of(q, k, above, c))
        for i in range(3):
            near += 8 * abs(step_of(q, k, above, i))
    busy, row = octave_of(past + near), which * _OCTAVES
    whole, in_time, beside = row + busy, row + octave_of(past), row + octave_of(near)
    own, length, n = SHARED + group * GROUP, length_of(abs(rest)), 0
    while n <= DIGITS:
        m = min(n, _LENGTHS - 1)
        longer = decide_at(
            model, KIND_SCALING + which, LONGER_SCALING[which, busy, m],
            SCALING_0 + whole * _LENGTHS + m, SCALING_1 + in_time * _LENGTHS + m, SCALING_2 + beside * _LENGTHS + m,
            own + GROUP_SCALING + which * _LENGTHS + m, SCALING_3 + (which * 3 + c) * _LENGTHS + m, length > n,
        )  # fmt: skip
        if not longer:
            break
        n += 1
    if n == 0:
        return set_scaling(model, q, k, group, c, before)
    size = 1
    if n > 1:
        context = SCALING_DIGIT + which * _LENGTHS + min(n, _LENGTHS - 1)
        size = 2 + decide_alone(model, _DIGIT_OF_SCALING, context, (abs(rest) >> (n - 2)) & 1)
        size = size << (n - 2) | code_digits(model, n - 2, abs(rest) & ((1 << (n - 2)) - 1))
    last = sign_class(step_of(q, k - 1, group, c)) if k > 1 else 0
    negative = decide_at(
        model, KIND_SCALING_SIGN + which, EVEN,
        own + GROUP_SCALING_SIGN + which * 4 + last, own + GROUP_SCALING_SIGN + 12 + c * 4 + last,
        SCALING_SIGN + which * 4 + last, SCALING_SIGN + 12 + (which * 3 + parent) * 3 + c, SCALING_SIGN + 48 + which,
        rest < 0,
    )  # fmt: skip
    return set_scaling(model, q, k, group, c, before - size if negative else before + size)


@inlined
def set_scaling(model, q, k, group, c, value):
    """Write a scaling coefficient that was decoded; return the size of its difference from the one before."""
    if model.decoding:
        q[k, group, c] = min(max(value, -LARGEST), LARGEST)
    return abs(step_of(q, k, group, c))


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
        used = np.flatnonzero(is_used)
        for k in range(bands[band], bands[band + 1]):
            if model.decoding and model.coder[AT] > len(model.stream) + BEYOND:
                return False
            crowd = 0
            for i in range(len(used)):
                group, before = used[i], max(i, 1)
                if band == 0:
                    for c in range(3):
                        size = code_scaling(model, lattice, k, group, c, 10 * crowd // (3 * before))
                        sums[k, group] += size if k > 0 else 0
                else:
                    sums[k, group] = code_triple(model, lattice, sums, band, k, group, CROWD * crowd // before)
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
        family, was = is_used[above] if above >= 0 else 2, is_used[group]
        last = is_used[group - 1] if group > 0 else 0
        own = SHARED + group * GROUP + GROUP_USED
        is_used[group] = decide_at(
            model, KIND_USED, USED[level, family, was],
            USED_0 + level * 2 + was, own, own + 1 + was, USED_1 + (level * 3 + family) * 2 + was,
            USED_2 + (family * 2 + last) * 2 + was, used,
        )  # fmt: skip
