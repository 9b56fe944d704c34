"""A binary arithmetic coder whose probabilities are mixed from several contexts, encoder and decoder in one.

Stretched probabilities are mixed by weights that learn, as by Mahoney, "Adaptive weighing of context models for
lossless data compression", 2005. Everything is in integers, so that a stream is the same on every machine.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.kernels.compilation import compiled, inlined

INPUTS = 6
"""Contexts per decision."""

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

EVEN = 32768
"""Odds of a decision of which nothing is known."""

LIMIT = 127
"""Decisions from which on the rate stays."""

LEARNING = 20
"""How fast the weights of contexts follow."""

FIRST_WEIGHT = 9830
"""Of every context at the beginning, in 1 / 65536."""

TRIMMED = 4
"""Zeros that are left out at the end of a stream, at most."""

BEYOND = 4 + TRIMMED
"""Bytes that a decoder may read behind the end of a stream."""

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
        In each context the probability of 1, in 1 / 65536, times 256, plus the number of decisions, up to `LIMIT`.
    weights : array-like of int, shape=[KINDS, INPUTS]
        Of the contexts, in 1 / 65536.
    inputs : array-like of int, shape=[INPUTS]
        Stretched probabilities of the contexts of a decision.
    section : int
        Contexts for each kind of decision.
    """

    coder: np.ndarray
    stream: np.ndarray
    decoding: bool
    odds: np.ndarray
    weights: np.ndarray
    inputs: np.ndarray
    section: int


@inlined
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


@inlined
def decide_at(model, section, kind, prior, a, b, c, d, e, f, bit):
    """Code one decision in six contexts of a section of the tables; contexts that are new begin at the prior.

    Parameters
    ----------
    model : Model
    section, kind : int
        Of the tables, and of the weights.
    prior : int
        Probability of 1, in 1 / 65536.
    a, b, c, d, e, f : int
        Contexts.
    bit : bool
        The decision, if it is encoded.

    Returns
    -------
    bit : int
    """
    base = section * model.section
    slots = (base + a, base + b, base + c, base + d, base + e, base + f)
    inputs, weights, odds = model.inputs, model.weights, model.odds
    total = 0
    for i in range(INPUTS):
        entry = odds[i, slots[i]]
        if entry == 0:
            entry = prior << 8 | 1
            odds[i, slots[i]] = entry
        inputs[i] = STRETCH[entry >> 12]
        total += inputs[i] * weights[kind, i]
    mixed = SQUASH[min(max(total >> 16, -2047), 2047) + 2047]
    bit = code_bit(model.coder, model.stream, model.decoding, min(max(mixed * 16, 32), 65536 - 32), 1 if bit else 0)
    error = ((bit << 12) - mixed) * LEARNING
    target = (bit << 16) - bit
    for i in range(INPUTS):
        weights[kind, i] += (inputs[i] * error + 0x8000) >> 16
        entry = odds[i, slots[i]]
        p, n = entry >> 8, entry & 0xFF
        p += ((target - p) * RATES[n]) >> 16
        odds[i, slots[i]] = p << 8 | min(n + 1, LIMIT)
    return bit


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
    length = coder[AT]
    for _ in range(TRIMMED):
        if length > 0 and stream[length - 1] == 0:
            length -= 1
    return length
