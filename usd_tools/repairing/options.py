"""Options of `repair`."""

from __future__ import annotations

from dataclasses import dataclass

from usd_tools.console.arguments import positive_number, whole_number
from usd_tools.console.options import OutputOptions, option


@dataclass(frozen=True, kw_only=True)
class RepairOptions(OutputOptions):
    """Options of `repair`, in the words of its command line.

    Parameters
    ----------
    max_gap : int
        Samples in a row that are rebuilt at most; longer faults are listed and left.
        Optional, default: those of a second.
    smooth : float
        Hertz; faster motion is filtered away after the repair, without delay.
        Optional, default: nothing is filtered.
    no_xforms : bool
        Leave the transforms that move a character as a whole as they are.
    dry_run : bool
        Do all but write.
    """

    max_gap: int | None = option(None, whole_number)
    smooth: float | None = option(None, positive_number)
    no_xforms: bool = option(False, bool)
    dry_run: bool = option(False, bool, recorded=False)
