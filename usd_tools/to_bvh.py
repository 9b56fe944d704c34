"""Convert skeletal animation in USD to BVH: every sample a frame, Euler angles without jumps.

python -m usd_tools.to_bvh walk.usda -o walk.bvh
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.main import Work, run_on_files
from usd_tools.bvh.options import UP_AXES
from usd_tools.bvh.result import ToBvhResult
from usd_tools.bvh.to_options import ToBvhOptions
from usd_tools.console.arguments import add_inputs, add_prim, add_several, positive_number
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.console.text import counted, say

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["ToBvhOptions", "ToBvhResult", "main", "parser", "to_bvh", "to_bvh_stage"]

PROG = "python -m usd_tools.to_bvh"


def to_bvh(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str],
    options: ToBvhOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> ToBvhResult:
    """Convert the skeletal animation of a USD file to a BVH file.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like
        BVH file to write.
    options : ToBvhOptions
        Optional, default: the skeleton's own unit, Y up.
    progress : callable
        Called with the work done, all the work, and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : ToBvhResult

    Raises
    ------
    ToolError
        If the file has not one animation with evenly spaced samples, or something is wrong with the output; nothing
        is written then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Gf, Usd, UsdSkel
    >>> folder = Path(tempfile.mkdtemp())
    >>> stage = Usd.Stage.CreateNew(str(folder / "turn.usda"))
    >>> turn = UsdSkel.Animation.Define(stage, "/Turn")
    >>> _ = turn.CreateJointsAttr(["arm"])
    >>> _ = turn.CreateRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0)], 0)
    >>> _ = turn.CreateRotationsAttr().Set([Gf.Quatf(0, 1, 0, 0)], 24)
    >>> stage.Save()
    >>> _ = to_bvh(folder / "turn.usda", folder / "turn.bvh")
    >>> (folder / "turn.bvh").read_text().split()[-6:]
    ['0.000000', '0.000000', '0.000000', '0.000000', '0.000000', '180.000000']
    """
    from usd_tools.bvh.export import to_bvh_file

    return to_bvh_file(Path(source), Path(out), options or ToBvhOptions(), progress, warn)


def to_bvh_stage(
    stage: Usd.Stage,
    out: str | os.PathLike[str],
    options: ToBvhOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> ToBvhResult:
    """Convert the skeletal animation of an open stage to a BVH file.

    Parameters
    ----------
    stage : Usd.Stage
    out : path-like
        BVH file to write.
    options, progress, warn
        See `to_bvh`.

    Returns
    -------
    result : ToBvhResult

    Raises
    ------
    ToolError
        See `to_bvh`.
    """
    from usd_tools.bvh.export import to_bvh_from_stage

    return to_bvh_from_stage(stage, Path(out), options or ToBvhOptions(), progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Convert skeletal animation to BVH. Every sample is a frame, so samples must be evenly spaced "
        "(usd_tools.resample makes them so). Angles do not jump; transforms above the skeleton are in the root. Files "
        "that usd_tools.from_bvh converted come back with the same channels.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="BVH file, or folder, to write")
    parse.add_argument(
        "--scale",
        metavar="METRES_PER_UNIT",
        type=positive_number,
        help="metres per unit of OUT, such as 0.01 for centimetres; default: that of the skeleton's own numbers",
    )
    parse.add_argument(
        "--up", choices=UP_AXES, default="Y", help="Y turns a stage whose z axis points up, Z leaves it; default: Y"
    )
    add_prim(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")
    add_several(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.to_bvh", ToBvhOptions, _work, suffix=".bvh")


def _work() -> Work:
    from usd_tools.bvh.export import to_bvh_file

    return to_bvh_file, _print


def _print(result: ToBvhResult, args: argparse.Namespace) -> None:
    say(f"{result.prim}: {counted(result.joints, 'joint')}; {counted(result.frames, 'frame')}.")
    say(
        f"Wrote {args.out} ({result.rate:g} frames per second). BVH does not state its unit: one unit is "
        f"{result.metres_per_unit:.6g} metres."
    )


if __name__ == "__main__":
    sys.exit(main())
