"""Time codes from the command line, and those that a sparse animation remembers."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from usd_tools.console.errors import Messages, ToolError
from usd_tools.metrics.attributes import read_source_codes
from usd_tools.skel.clip import SkelClip

SOURCE = "source"
"""The word for the samples that an animation had before it was made sparse."""


class TimeCodes:
    """Time codes from the command line, and how they were written there.

    Parameters
    ----------
    text : str
        Numbers with commas between them, the name of a text file of numbers, or `SOURCE`.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._codes: np.ndarray | None = None
        if text == SOURCE:
            return
        try:
            self._codes = _numbers(text)
        except ValueError:
            try:
                self._codes, self.text = _numbers(Path(text).read_text(encoding="utf-8")), Path(text).name
            except (OSError, ValueError):
                raise argparse.ArgumentTypeError(
                    f"must be finite numbers with commas between them, or a file of such, not {text!r}"
                ) from None

    def of(self, clip: SkelClip) -> np.ndarray:
        """Time codes for an animation, shape=[F].

        Raises
        ------
        ToolError
            If it does not remember its source's, or its samples are elsewhere now.
        """
        if self._codes is not None:
            return self._codes
        remembered = _remembered(clip)
        if remembered is None:
            raise ToolError(
                f"--times {SOURCE}: {clip.path} does not say where its source had samples; usd_tools.downsample writes "
                "that, or give the time codes."
            )
        codes, n_found = remembered
        if n_found <= len(clip.codes) / 2.0:
            raise ToolError(
                f"--times {SOURCE}: {n_found} of the {len(clip.codes)} samples of {clip.path} are where "
                "usd_tools.downsample left them; give the time codes."
            )
        return codes


def remembering(clips: Sequence[SkelClip], messages: Messages) -> list[SkelClip]:
    """Clips that say where their source had samples; all of them if none does, which is an error to be told later.

    Parameters
    ----------
    clips : sequence of SkelClip
    messages : Messages
        Told of the others.
    """
    found = [clip for clip in clips if read_source_codes(clip.source.prim) is not None]
    for clip in clips:
        if found and clip not in found:
            messages.warn(f"{clip.path} does not say where its source had samples, so it is left as it is.")
    return found or list(clips)


def left_sparse(clip: SkelClip) -> list[str]:
    """Note on an animation that `usd_tools.downsample` made sparse and nobody has rebuilt; none on others."""
    remembered = _remembered(clip)
    n_kept = min((len(channel.codes) for channel in clip.channels.values() if channel.is_animated), default=0)
    if remembered is None or len(remembered[0]) <= n_kept:
        return []
    return [
        f"{clip.path} is sparse: it keeps {n_kept} of {len(remembered[0])} samples, only these are looked at, "
        "and with another metric the rest cannot be rebuilt; run usd_tools.upsample --times source first."
    ]


def _remembered(clip: SkelClip) -> tuple[np.ndarray, int] | None:
    """Time codes at which a clip's source had samples, within its range, and how many of its own are among them."""
    codes = read_source_codes(clip.source.prim)
    if codes is None or not len(clip.codes):
        return None
    # A layer offset moves samples, and not the numbers of an attribute; who trims or extends a clip moves neither.
    first, last = clip.codes[0], clip.codes[-1]
    stretch = (last - first) / (codes[-1] - codes[0]) if codes[-1] > codes[0] else 1.0
    candidates = [codes, np.clip(first + (codes - codes[0]) * stretch, first, last)]
    found = [_n_among(clip.codes, each) for each in candidates]
    best = int(np.argmax(found))
    return candidates[best][(candidates[best] >= first) & (candidates[best] <= last)], found[best]


def _n_among(samples: np.ndarray, codes: np.ndarray) -> int:
    """Count samples that are at one of some increasing time codes, but for rounding."""
    near = 1e-3 * float(np.diff(codes).min(initial=1.0))
    after = np.searchsorted(codes, samples - near)
    return int((codes[np.minimum(after, len(codes) - 1)] <= samples + near)[after < len(codes)].sum())


def _numbers(text: str) -> np.ndarray:
    numbers = [float(word) for word in text.replace(",", " ").split()]
    if not numbers or not all(math.isfinite(number) for number in numbers):
        raise ValueError(text)
    return np.array(numbers)
