"""Result of `demo`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class DemoResult:
    """Result of `demo`.

    Parameters
    ----------
    path : Path
        Folder that was written.
    clip : Path
        The clip, as USD.
    page : Path
        HTML page on which the clip plays beside what was rebuilt of it.
    picture : Path
        Overlay of the same, as PNG.
    samples, keys : int
        Samples of the clip, and how many of them were kept.
    centimetres : dict
        Mean and largest distance of bone ends from the original, by scheme.
    """

    path: Path
    clip: Path
    page: Path
    picture: Path
    samples: int
    keys: int
    centimetres: dict[str, tuple[float, float]]
