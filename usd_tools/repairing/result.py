"""Result of `repair`, as plain values."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from geomstats_anim._version import __version__
from usd_tools.skel.fault_words import count_kinds

TOOL = "usd_tools.repair"


@dataclass(frozen=True)
class RepairedAnimation:
    """Result for one animation.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation.
    skeletons : tuple of str
        Paths of the Skeletons that it drives.
    joints, samples : int
    faults : tuple of dict
        kind ("gap", "spike", "drop-out" or "sign flip"), channel, joint, joint_name (short), start and end (time codes
        of the first and the last sample), samples, degrees or centimetres (what a spike departs, or what the step after
        a drop-out makes up for), repaired (False for those longer than --max-gap).
    smoothed : tuple of str
        Channels and transforms that were filtered.
    """

    prim: str
    skeletons: tuple[str, ...]
    joints: int
    samples: int
    faults: tuple[dict[str, Any], ...]
    smoothed: tuple[str, ...]


@dataclass(frozen=True)
class RepairResult:
    """Result of `repair`.

    Parameters
    ----------
    source : str
        Name of the file, or of the stage's root layer.
    path : Path or None
        File that was written; None for a dry run or an open stage.
    output : str or None
        Its name, or that of the layer that was edited.
    settings : dict
        Options that were asked for, plain values.
    animations : tuple of RepairedAnimation
    warnings : tuple of str
    dependencies : str
        Sentence on the other files that a flattened output needs, else "".
    """

    source: str
    path: Path | None
    output: str | None
    settings: dict[str, Any]
    animations: tuple[RepairedAnimation, ...]
    warnings: tuple[str, ...]
    dependencies: str = ""

    @property
    def faults(self) -> list[dict[str, Any]]:
        """Faults of all animations."""
        return [fault for animation in self.animations for fault in animation.faults]

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        words = count_kinds(self.faults) or "no faults"
        left = sum(not fault["repaired"] for fault in self.faults)
        return words + (f"; {left} left" if left else "")

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": TOOL,
            "version": __version__,
            "source": self.source,
            "output": self.output,
            "settings": self.settings,
            "animations": [asdict(animation) for animation in self.animations],
            "warnings": list(self.warnings),
        }
