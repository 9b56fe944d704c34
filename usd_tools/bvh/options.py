"""Options of `from_bvh`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from usd_tools.console.arguments import positive_number
from usd_tools.console.options import Options, one_of, option
from usd_tools.skel.frame_rates import typed_rate

UP_AXES = ("Y", "Z")


@dataclass(frozen=True, kw_only=True)
class FromBvhOptions(Options):
    """Options of `from_bvh`, in the words of its command line.

    Parameters
    ----------
    scale : float
        Metres per unit of the BVH file.
        Optional, default: 0.01.
    fps : float
        Frames per second; 29.97 and its like mean 30000 / 1001.
        Optional, default: as the file says.
    skip_first : bool
        Leave out the first frame.
    up : str
        Axis of the file that points up, "Y" or "Z".
        Optional, default: "Y".
    usd_format : str
        "usda" or "usdc", for a name that ends in .usd; an open stage does not use it.
        Optional, default: "usdc".
    report : Path
        JSON file to write the result to as well.
        Optional, default: none.
    """

    scale: float = option(0.01, positive_number)
    fps: float | None = option(None, typed_rate)
    skip_first: bool = option(False, bool)
    up: str = option("Y", one_of(UP_AXES))
    usd_format: str | None = option(None, one_of(("usda", "usdc")), recorded=False, word="usdFormat")
    report: Path | None = option(None, Path, recorded=False)
