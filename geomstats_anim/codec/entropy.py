"""Integers as bytes, and back, by context mixing."""

from __future__ import annotations

import numpy as np

from geomstats_anim.codec.bytestream import StreamError
from geomstats_anim.kernels import binary_coder as kernel
from geomstats_anim.kernels.context_coder import GROUP, SHARED, code
from geomstats_anim.kernels.context_priors import FIRST_WEIGHTS
from geomstats_anim.kernels.contexts import Lattice

_BYTES_PER_INTEGER = 12
"""More than the coder ever needs, escapes included."""


def encode(lattice: Lattice) -> bytes:
    """Return the integers of a lattice as bytes."""
    model = _new_model(lattice, np.zeros(_BYTES_PER_INTEGER * lattice.integers.size + 64, dtype=np.uint8), False)
    code(model, lattice)
    return model.stream[: kernel.finish(model.coder, model.stream)].tobytes()


def decode(payload: bytes, lattice: Lattice) -> None:
    """Write the integers of `payload` into a lattice whose integers are all zero.

    Raises
    ------
    StreamError
        If the payload ends before the integers do.
    """
    if not code(_new_model(lattice, np.frombuffer(payload, dtype=np.uint8).copy(), True), lattice):
        raise StreamError("The stream ends too early; it is damaged or cut off.")


def _new_model(lattice: Lattice, stream: np.ndarray, decoding: bool) -> kernel.Model:
    return kernel.Model(
        coder=np.array([0, 0xFFFFFFFF, 0, 0], dtype=np.int64),
        stream=stream,
        decoding=decoding,
        odds=np.zeros(SHARED + lattice.integers.shape[1] * GROUP, dtype=np.int32),
        weights=FIRST_WEIGHTS.copy(),
    )
