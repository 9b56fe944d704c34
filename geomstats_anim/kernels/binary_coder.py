"""A binary arithmetic coder whose probabilities are mixed from several contexts, encoder and decoder in one.

Stretched probabilities are mixed by weights that learn, as by Mahoney, "Adaptive weighing of context models for
lossless data compression", 2005. Everything is in integers, so that a stream is the same on every machine.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.kernels.compilation import compiled, inlined

INPUTS = 5
"""Contexts per decision."""

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

LIMIT = 255
"""Decisions from which on the rate stays."""

LEARNING = 40
"""How fast the weights of contexts follow."""

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
    odds : array-like of int, shape=[n]
        In each context the probability of 1, in 1 / 65536, times 256, plus the number of decisions, up to `LIMIT`.
    weights : array-like of int, shape=[KINDS, INPUTS]
        Of the contexts, in 1 / 65536, for every kind of decision.
    """

    coder: np.ndarray
    stream: np.ndarray
    decoding: bool
    odds: np.ndarray
    weights: np.ndarray


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
def known(odds, context, prior):
    """Return what a context knows; one that is new begins at the prior."""
    entry = odds[context]
    return entry if entry else prior << 8 | 1


@inlined
def learn(odds, context, entry, bit):
    """Move the probability of a context towards a decision, the less the more it has seen."""
    p, n = entry >> 8, entry & 0xFF
    odds[context] = (p + ((((bit << 16) - bit - p) * RATES[n]) >> 16)) << 8 | min(n + 1, LIMIT)


@inlined
def decide_at(model, kind, prior, a, b, c, d, e, bit):
    """Code one decision in five contexts.

    Parameters
    ----------
    model : Model
    kind : int
        Of the weights.
    prior : int
        Probability of 1, in 1 / 65536, in contexts that are new.
    a, b, c, d, e : int
        Contexts.
    bit : bool
        The decision, if it is encoded.

    Returns
    -------
    bit : int
    """
    odds, weights = model.odds, model.weights
    ka, kb, kc = known(odds, a, prior), known(odds, b, prior), known(odds, c, prior)
    kd, ke = known(odds, d, prior), known(odds, e, prior)
    ia, ib, ic, id_, ie = STRETCH[ka >> 12], STRETCH[kb >> 12], STRETCH[kc >> 12], STRETCH[kd >> 12], STRETCH[ke >> 12]
    total = ia * weights[kind, 0] + ib * weights[kind, 1] + ic * weights[kind, 2]
    total += id_ * weights[kind, 3] + ie * weights[kind, 4]
    mixed = SQUASH[min(max(total >> 16, -2047), 2047) + 2047]
    bit = code_bit(model.coder, model.stream, model.decoding, min(max(mixed * 16, 32), 65536 - 32), 1 if bit else 0)
    error = ((bit << 12) - mixed) * LEARNING
    weights[kind, 0] += (ia * error + 0x8000) >> 16
    weights[kind, 1] += (ib * error + 0x8000) >> 16
    weights[kind, 2] += (ic * error + 0x8000) >> 16
    weights[kind, 3] += (id_ * error + 0x8000) >> 16
    weights[kind, 4] += (ie * error + 0x8000) >> 16
    learn(odds, a, ka, bit)
    learn(odds, b, kb, bit)
    learn(odds, c, kc, bit)
    learn(odds, d, kd, bit)
    learn(odds, e, ke, bit)
    return bit


@inlined
def decide_alone(model, prior, context, bit):
    """Code one decision in one context; see `decide_at`."""
    entry = known(model.odds, context, prior)
    p = min(max(entry >> 8, 64), 65536 - 64)
    bit = code_bit(model.coder, model.stream, model.decoding, p, 1 if bit else 0)
    learn(model.odds, context, entry, bit)
    return bit


@compiled
def code_digits(model, count, digits):
    """Code binary digits of which nothing is known, the highest first; return them."""
    value = 0
    for i in range(count - 1, -1, -1):
        bit = code_bit(model.coder, model.stream, model.decoding, EVEN, (digits >> i) & 1)
        value = 2 * value + bit
    return value


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
