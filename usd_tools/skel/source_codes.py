"""Find out where the source of a sparse animation had samples and cuts, on the clock of the animation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pxr import Usd

from usd_tools.metrics.attributes import read_source_codes, read_source_cuts


class SourceCodes(NamedTuple):
    """Hold what a sparse animation stores of its source.

    Attributes
    ----------
    codes : array-like, shape=[F]
        Time codes of the source's samples.
    cuts : array-like, shape=[C, 2]
        Time codes on both sides of each cut.
    n_found : int
        How many samples of the sparse animation are among `codes`.
    n_before, n_all : int
        How many samples the source has before `codes`, and all in all.
    """

    codes: np.ndarray
    cuts: np.ndarray
    n_found: int
    n_before: int
    n_all: int


def stored_source_codes(prim: Usd.Prim, samples: np.ndarray) -> SourceCodes | None:
    """Read what a SkelAnimation stores of its source; None if it is not sparse.

    Parameters
    ----------
    prim : Usd.Prim
    samples : array-like, shape=[K]
        Time codes of its samples, increasing.

    Raises
    ------
    ToolError
        If it cannot be used.
    """
    codes = read_source_codes(prim)
    if codes is None or not len(samples):
        return None
    cuts = read_source_cuts(prim, len(codes))
    # A layer offset moves samples, and not the numbers of an attribute; who trims or extends a clip moves neither.
    first, last = samples[0], samples[-1]
    stretch = (last - first) / (codes[-1] - codes[0]) if codes[-1] > codes[0] else 1.0
    candidates = [codes, np.clip(first + (codes - codes[0]) * stretch, first, last)]
    found = [_n_among(samples, each) for each in candidates]
    best = int(np.argmax(found))
    codes = candidates[best]
    inside = (codes >= first) & (codes <= last)
    return SourceCodes(codes[inside], codes[cuts], found[best], int((codes < first).sum()), len(codes))


def _n_among(samples: np.ndarray, codes: np.ndarray) -> int:
    """Count samples that are at one of some increasing time codes, but for rounding."""
    near = 1e-3 * float(np.diff(codes).min(initial=1.0))
    after = np.searchsorted(codes, samples - near)
    return int((codes[np.minimum(after, len(codes) - 1)] <= samples + near)[after < len(codes)].sum())
