"""Entropy coding of integers: a binary arithmetic coder whose probabilities are mixed from several contexts.

Mixing of stretched probabilities follows Mahoney, "Adaptive weighing of context models for lossless data compression",
2005. Everything is in integers, so that a stream is the same on every machine. Encoding and decoding are one function.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.kernels.compilation import compiled
from geomstats_anim.kernels.contexts import above_of, activity_class, neighbours

INPUTS = 6
"""Contexts per decision."""

UNARY = 14
"""Sizes up to here are coded as one decision per unit, the rest by its length in binary."""

DIGITS = 29
"""Binary digits of the largest numbers, so that integers have room in 32 bits."""

LARGEST = 2**DIGITS - 1
"""Largest size of an integer that is coded."""

KINDS = 64
"""Sets of weights."""

_SQUASH = np.array(
    [
        1, 2, 3, 6, 10, 16, 27, 45, 73, 120, 194, 310, 488, 747, 1101, 1546, 2047, 2549, 2994, 3348, 3607, 3785, 3901,
        3975, 4022, 4050, 4068, 4079, 4085, 4089, 4092, 4093, 4094,
    ]
)  # fmt: skip
"""4096 / (1 + exp(-x)) for x from -8 to 8 by halves."""


def _stretch_table() -> np.ndarray:
    """Invert `squash`: 256 times log(p / (1 - p)), for p in 1 / 4096."""
    table = np.full(4096, 2047)
    first = 0
    for x in range(-2047, 2048):
        p = _squash_of(x)
        table[first : p + 1] = np.where(np.arange(first, p + 1) >= first, x, 0)
        first = max(first, p + 1)
    return table


def _squash_of(x: int) -> int:
    at, rest = (x + 2048) // 128, (x + 2048) % 128
    return int((_SQUASH[at] * (128 - rest) + _SQUASH[min(at + 1, 32)] * rest + 64) // 128)


STRETCH = _stretch_table()
SQUASH = np.array([_squash_of(x) for x in range(-2047, 2048)])
RATES = np.array([65536 * 2 // (2 * n + 3) for n in range(256)])
"""How far a probability moves at its n-th decision: 1 / (n + 1.5), in 1 / 65536."""

LIMIT = 160
LEARNING = 10

# positions in the state of the coder
LOW, HIGH, CODE, AT = 0, 1, 2, 3


class Model(NamedTuple):
    """What has been learned so far, and the coder.

    Attributes
    ----------
    coder : array-like of int, shape=[4]
        Bounds of the interval, the code that is read, and the place in the stream.
    stream : array-like of uint8
    decoding : bool
    odds : array-like of int, shape=[INPUTS, n]
        Probability of 1 in each context, in 1 / 65536.
    seen : array-like of int, shape=[INPUTS, n]
        Decisions seen in each context, up to `LIMIT`.
    weights : array-like of int, shape=[KINDS, INPUTS]
        Of the contexts, in 1 / 65536.
    slots, inputs : array-like of int, shape=[INPUTS]
        Contexts of the decision, and their stretched probabilities.
    section : int
        Contexts for each kind of decision.
    """

    coder: np.ndarray
    stream: np.ndarray
    decoding: bool
    odds: np.ndarray
    seen: np.ndarray
    weights: np.ndarray
    slots: np.ndarray
    inputs: np.ndarray
    section: int


@compiled
def code_bit(coder, stream, decoding, probability, bit):
    """Code one decision, or return the one that was coded; the probability of 1 is in 1 / 65536."""
    low, high = coder[LOW], coder[HIGH]
    middle = low + ((high - low) >> 16) * probability + ((((high - low) & 0xFFFF) * probability) >> 16)
    if decoding:
        bit = 1 if coder[CODE] <= middle else 0
    if bit:
        high = middle
    else:
        low = middle + 1
    while (low ^ high) & 0xFF000000 == 0:
        if decoding:
            byte = stream[coder[AT]] if coder[AT] < len(stream) else 0
            coder[CODE] = ((coder[CODE] << 8) & 0xFFFFFFFF) | byte
        else:
            stream[coder[AT]] = high >> 24
        coder[AT] += 1
        low = (low << 8) & 0xFFFFFFFF
        high = ((high << 8) & 0xFFFFFFFF) | 0xFF
    coder[LOW], coder[HIGH] = low, high
    return bit


@compiled
def decide(model, kind, bit):
    """Code one decision by the mix of the contexts in `model.slots`."""
    slots, inputs, weights = model.slots, model.inputs, model.weights[kind]
    total = 0
    for i in range(INPUTS):
        inputs[i] = STRETCH[model.odds[i, slots[i]] >> 4]
        total += inputs[i] * weights[i]
    total = min(max(total >> 16, -2047), 2047)
    mixed = SQUASH[total + 2047]
    probability = min(max(mixed * 16, 32), 65536 - 32)
    bit = code_bit(model.coder, model.stream, model.decoding, probability, bit)
    error = ((bit << 12) - mixed) * LEARNING
    for i in range(INPUTS):
        weights[i] += (inputs[i] * error + 0x8000) >> 16
        n = model.seen[i, slots[i]]
        p = model.odds[i, slots[i]]
        model.odds[i, slots[i]] = p + ((((bit << 16) - bit - p) * RATES[n]) >> 16)
        if n < LIMIT:
            model.seen[i, slots[i]] = n + 1
    return bit


@compiled
def few(n):
    """Return a class of a size: 0, 1, 2, 3 to 4, 5 to 8, more."""
    return n if n < 3 else 3 if n < 5 else 4 if n < 9 else 5


@compiled
def set_slots(model, base, a, b, c, d, e, f):
    """Choose the contexts of a decision, each behind the base of its kind."""
    slots = model.slots
    slots[0], slots[1], slots[2] = base + a, base + b, base + c
    slots[3], slots[4], slots[5] = base + d, base + e, base + f


@compiled
def code_size(model, lattice, band, k, group, c, crowd, size):
    """Code the size of an integer."""
    q, bands = lattice.integers, lattice.bands
    before, coarser, others, family = neighbours(q, bands, lattice.parents, band, k, group, c)
    level = min(len(bands) - 2 - band, 7)
    busy = activity_class(before, coarser, others, family)
    channel = group * 3 + c
    near = (few(before) * 6 + few(coarser)) * 8 + level
    beside = (few(others) * 6 + few(family)) * 3 + min(before, 2)
    nonzero = decide_at(
        model,
        0,
        0 + level,
        near,
        beside,
        channel * 8 + level,
        busy * 8 + level,
        group * 6 + few(busy // 2),
        (few(crowd) * 16 + busy) * 3 + c,
        size > 0,
    )
    if not nonzero:
        return 0
    n = 1
    while n <= UNARY:
        m = min(n - 1, 6)
        more = decide_at(
            model,
            1,
            8 + m,
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
    return UNARY + 1 + code_number(model, 3, group, size - UNARY - 1)


@compiled
def decide_at(model, section, kind, a, b, c, d, e, f, bit):
    """Set the contexts and decide; sections of the tables are for kinds of decisions."""
    set_slots(model, section * model.section, a, b, c, d, e, f)
    return decide(model, kind, 1 if bit else 0)


@compiled
def code_number(model, section, group, number):
    """Code a number from 0 on: the length of its binary form, then its bits."""
    length = 0
    if not model.decoding:
        while (number + 1) >> (length + 1):
            length += 1
    n = 0
    while n < DIGITS:
        more = decide_at(model, section, 16 + min(n, 15), n, 32 + n, group * 32 + n, n, 64 + n, 96 + n, length > n)
        if not more:
            break
        n += 1
    value = 1
    for i in range(n - 1, -1, -1):
        first = n - 1 - i
        bit = decide_at(
            model,
            section,
            32,
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


@compiled
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
        model, 2, 33 + level, past, over, channel * 3 + family, beside, channel * 3 + left, around, negative
    )


@compiled
def code_scaling(model, lattice, k, group, c):
    """Code a scaling coefficient, as its difference from the one before."""
    q = lattice.integers
    before = q[k - 1, group, c] if k > 0 else 0
    rest = q[k, group, c] - before
    first = 0 if k == 0 else 1
    number = code_number(model, 4 + first, group, abs(rest))
    if number:
        channel = group * 3 + c
        negative = decide_at(model, 6, 48 + first, first, channel, 0, 0, 0, 0, rest < 0)
        number = -number if negative else number
    if model.decoding:
        q[k, group, c] = min(max(before + number, -LARGEST), LARGEST)


@compiled
def code(model, lattice):
    """Code all integers, from coarse to fine; what is decoded is written into `lattice.integers`.

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
    for band in range(len(bands) - 1):
        code_used(model, lattice, band, is_used)
        for k in range(bands[band], bands[band + 1]):
            crowd = 0
            for group in range(n_groups):
                for c in range(3 if is_used[group] else 0):
                    if band == 0:
                        code_scaling(model, lattice, k, group, c)
                    else:
                        crowd += code_integer(model, lattice, band, k, group, c, crowd)


@compiled
def code_integer(model, lattice, band, k, group, c, crowd):
    """Code one integer of a wavelet; return its size."""
    q = lattice.integers
    size = code_size(model, lattice, band, k, group, c, crowd, abs(q[k, group, c]))
    if size:
        negative = code_sign(model, lattice, band, k, group, c, q[k, group, c] < 0)
        if model.decoding:
            size = min(size, LARGEST)
            q[k, group, c] = -size if negative else size
    return size


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
            7,
            50,
            level * 2 + is_used[group],
            group,
            group * 2 + is_used[group],
            (level * 3 + family) * 2 + is_used[group],
            level,
            is_used[group],
            used,
        )


@compiled
def finish(coder, stream):
    """Write the fewest bytes that end the stream, as zeros follow it; return its length."""
    low, high = coder[LOW], coder[HIGH]
    for n in range(5):
        kept = (high >> (32 - 8 * n)) << (32 - 8 * n) if n else 0
        if low <= kept <= high:
            for i in range(n):
                stream[coder[AT]] = (kept >> (24 - 8 * i)) & 0xFF
                coder[AT] += 1
            break
    n = coder[AT]
    while n > 0 and stream[n - 1] == 0:
        n -= 1
    return n
