"""Time codes from the command line, and those that a sparse animation remembers."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from usd_tools.errors import ToolError
from usd_tools.metric_attributes import read_source_codes
from usd_tools.skel_reader import SkelClip

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
            If it does not remember its source's.
        """
        if self._codes is not None:
            return self._codes
        codes = read_source_codes(clip.source.prim)
        if codes is None:
            raise ToolError(
                f"--times {SOURCE}: {clip.path} does not say where its source had samples; usd_tools.downsample writes "
                "that, or give the time codes."
            )
        # a layer offset moves samples, and not the numbers of an attribute: both keep the first and the last sample
        first, last = clip.codes[0], clip.codes[-1]
        if (codes[0], codes[-1]) == (first, last) or codes[-1] == codes[0]:
            return codes
        return np.clip(first + (codes - codes[0]) * ((last - first) / (codes[-1] - codes[0])), first, last)


def _numbers(text: str) -> np.ndarray:
    numbers = [float(word) for word in text.replace(",", " ").split()]
    if not numbers or not all(math.isfinite(number) for number in numbers):
        raise ValueError(text)
    return np.array(numbers)
