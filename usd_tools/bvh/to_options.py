"""Options of `to_bvh`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from usd_tools.bvh.options import UP_AXES
from usd_tools.console.arguments import positive_number
from usd_tools.console.options import PrimOptions, one_of, option


@dataclass(frozen=True, kw_only=True)
class ToBvhOptions(PrimOptions):
    """Options of `to_bvh`, in the words of its command line.

    Parameters
    ----------
    scale : float
        Metres per unit of the BVH file.
        Optional, default: those of the skeleton's own numbers.
    up : str
        Axis of the BVH file that points up: "Y", or "Z" for the stage's own axes.
        Optional, default: "Y".
    report : Path
        JSON file to write the result to as well.
        Optional, default: none.
    """

    scale: float | None = option(None, positive_number)
    up: str = option("Y", one_of(UP_AXES))
    report: Path | None = option(None, Path, recorded=False)
