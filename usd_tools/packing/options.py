"""Options of `pack` and `unpack`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from geomstats_anim.names import EFFORTS, MEASURES, SHELL_RADIUS, WEIGHTS_TOLERANCE
from usd_tools.console.arguments import positive_number
from usd_tools.console.errors import UsageError
from usd_tools.console.options import OutputOptions, one_of, option


def preview_keys(text: str | int) -> int:
    """Parse a number of keys: 0, or at least 2."""
    try:
        number = int(text)
    except ValueError:
        number = -1
    if number != 0 and number < 2:
        raise argparse.ArgumentTypeError(f"must be 0, or a whole number of at least 2, not {text!r}")
    return number


@dataclass(frozen=True, kw_only=True)
class PackOptions(OutputOptions):
    """Options of `pack`, in the words of its command line; `tolerance` is needed.

    Parameters
    ----------
    tolerance : float
        Centimetres in the world: no measured point is further from its place at any sample.
    measure : str
        Points that the tolerance is about: "ends", the joints and the ends of their bones; "shell", points around the
        joints too, which twists move; "skin", the points of the meshes that the skeleton deforms too.
        Optional, default: "shell".
    shell : float
        Distance of a shell from the joints, centimetres.
        Optional, default: 3.
    weights_tolerance : float
        No weight of a blend shape is further from its value at any sample.
        Optional, default: 0.01.
    preview : int
        Samples of each animation that stay for viewers, which know nothing of packed motion; 0 for one pose.
        Optional, default: 0.
    segment : float
        Seconds of the pieces that can be unpacked alone.
        Optional, default: one piece.
    no_xforms : bool
        Whether transforms that move a character as a whole keep their samples.
        Optional, default: False, they are packed.
    effort : str
        "full", or "fast" for a tenth of the time and larger files.
        Optional, default: "full".
    """

    tolerance: float | None = option(None, positive_number)
    measure: str = option("shell", one_of(MEASURES))
    shell: float | None = option(None, positive_number)
    weights_tolerance: float = option(WEIGHTS_TOLERANCE, positive_number)
    preview: int = option(0, preview_keys)
    segment: float | None = option(None, positive_number)
    no_xforms: bool = option(False, bool)
    effort: str = option(EFFORTS[0], one_of(EFFORTS))

    def check(self) -> None:
        """Refuse values that do not go together."""
        if self.tolerance is None:
            raise UsageError("name the largest error with --tolerance, in centimetres")
        if self.shell is not None and self.measure == "ends":
            raise UsageError("--shell goes with --measure shell or skin")

    @property
    def metres(self) -> float:
        """The tolerance in metres."""
        assert self.tolerance is not None  # which `check` has seen to
        return 0.01 * self.tolerance

    @property
    def shell_metres(self) -> float:
        """Distance of the shell from the joints; next to nothing where bone ends alone are measured."""
        if self.measure == "ends":
            return 1e-6
        return SHELL_RADIUS if self.shell is None else 0.01 * self.shell


@dataclass(frozen=True, kw_only=True)
class UnpackOptions(OutputOptions):
    """Options of `unpack`, in the words of its command line: those of `OutputOptions`."""
