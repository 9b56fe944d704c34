"""Arrays as text for the script of a page: deflated, in base 64."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_LARGEST = 32_000
"""Of the whole numbers of 16 bits that stand for values."""


def encoded(values: np.ndarray, kind: str) -> str:
    """Encode numbers of a type such as "<f4"."""
    return base64.b64encode(zlib.compress(np.ascontiguousarray(values, dtype=kind).tobytes(), 9)).decode("ascii")


@dataclass(frozen=True, eq=False)
class Steps:
    """Values of channels as whole numbers n of 16 bits: base + unit n.

    Parameters
    ----------
    base : array-like, shape=[C]
        One per channel.
    unit : array-like, shape=[C]
        Positive.
    """

    base: np.ndarray
    unit: np.ndarray

    @classmethod
    def of(cls, motions: Sequence[np.ndarray], least: float) -> Steps:
        """Choose steps for the values of several motions, shape=[F, C], none finer than `least`.

        A channel that stands still in all of them by that measure costs nothing.
        """
        base = motions[0][0].astype(np.float32).astype(np.float64)
        largest = np.max([np.abs(values - base).max(axis=0) for values in motions], axis=0)
        return cls(base, np.maximum(largest / _LARGEST, least).astype(np.float32).astype(np.float64))

    def packed(self, values: np.ndarray) -> str:
        """Pack values, shape=[F, C]: differences in time, a row per channel, which wrap around.

        The lower byte of every number comes first, then the upper one of every number: alike bytes deflate well.
        """
        whole = np.round((values - self.base) / self.unit).astype("<i2")
        steps = np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1]))
        return encoded(np.ascontiguousarray(steps.T).view("u1").reshape(-1, 2).T, "u1")

    def as_dict(self) -> dict[str, str]:
        """Return the steps as plain values."""
        return {"base": encoded(self.base, "<f4"), "unit": encoded(self.unit, "<f4")}
