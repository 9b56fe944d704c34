"""The results of `from_bvh` and `to_bvh`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geomstats_anim._version import __version__
from usd_tools.console.text import counted

TOOL = "usd_tools.from_bvh"
TO_TOOL = "usd_tools.to_bvh"


@dataclass(frozen=True)
class FromBvhResult:
    """The result of `from_bvh`.

    Parameters
    ----------
    source : str
        Name of the BVH file.
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

    source: str
    path: Path | None
    prim: str
    joints: int
    frames: int
    rate: float
    height_metres: float
    warnings: tuple[str, ...]

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        return f"{counted(self.joints, 'joint')}, {counted(self.frames, 'frame')}"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": TOOL,
            "version": __version__,
            "source": self.source,
            "output": None if self.path is None else self.path.name,
            "prim": self.prim,
            "joints": self.joints,
            "frames": self.frames,
            "rate": self.rate,
            "height_metres": self.height_metres,
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True)
class ToBvhResult:
    """The result of `to_bvh`.

    Parameters
    ----------
    source : str
        Name of the USD file, or of the stage's root layer.
    path : Path
        File that was written.
    prim : str
        Path of the SkelAnimation.
    joints, frames : int
    rate : float
        Frames per second.
    metres_per_unit : float
        Of the BVH file, which does not say it.
    warnings : tuple of str
    """

    source: str
    path: Path
    prim: str
    joints: int
    frames: int
    rate: float
    metres_per_unit: float
    warnings: tuple[str, ...]

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        return f"{counted(self.joints, 'joint')}, {counted(self.frames, 'frame')}"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": TO_TOOL,
            "version": __version__,
            "source": self.source,
            "output": self.path.name,
            "prim": self.prim,
            "joints": self.joints,
            "frames": self.frames,
            "rate": self.rate,
            "metres_per_unit": self.metres_per_unit,
            "warnings": list(self.warnings),
        }
