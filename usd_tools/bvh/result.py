"""The result of `from_bvh`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FromBvhResult:
    """The result of `from_bvh`.

    Parameters
    ----------
    path : Path or None
        File that was written; None for an open stage.
    prim : str
        Path of the SkelRoot.
    joints : int
    frames : int
        Frames of the animation, the first one left out if that was asked for.
    rate : float
        Frames per second.
    height_metres : float
        From the lowest to the highest point of the skeleton at rest.
    warnings : tuple of str
    """

    path: Path | None
    prim: str
    joints: int
    frames: int
    rate: float
    height_metres: float
    warnings: tuple[str, ...]
