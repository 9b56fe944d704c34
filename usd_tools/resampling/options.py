"""Options of `resample`."""

from __future__ import annotations

from dataclasses import dataclass

from usd_tools.console.errors import UsageError
from usd_tools.console.options import option
from usd_tools.skel.frame_rates import typed_rate
from usd_tools.upsampling.options import CurveOptions


@dataclass(frozen=True, kw_only=True)
class ResampleOptions(CurveOptions):
    """Options of `resample`, in the words of its command line; `fps` is needed.

    Those of `CurveOptions` are not repeated here.

    Parameters
    ----------
    fps : float
        Samples per second; 29.97 and its like mean 30000 / 1001.
    retime : bool
        Give the output `fps` time codes per second, so that every sample is on a whole time code.
    antialias : bool
        Filter motion that is faster than the new rate can hold.
    """

    fps: float | None = option(None, typed_rate)
    retime: bool = option(False, bool)
    antialias: bool = option(False, bool)

    def check(self) -> None:
        """Refuse values that do not go together."""
        if self.fps is None:
            raise UsageError("name the rate with --fps")
        super().check()
