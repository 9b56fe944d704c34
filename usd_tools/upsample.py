"""Add samples to skeletal animation, along geodesics of an invariant metric; every sample that is there stays.

python -m usd_tools.upsample walk.usda -o walk_x4.usda --factor 4
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.main import Work, run_on_files
from usd_tools.console.arguments import add_inputs, add_output, add_prim, add_several, time_codes, whole_number
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.skel.frame_rates import typed_rate
from usd_tools.upsampling.arguments import add_contacts, add_cuts, add_library, add_metric
from usd_tools.upsampling.joint_styles import Style
from usd_tools.upsampling.options import UpsampleOptions
from usd_tools.upsampling.result import UpsampledAnimation, UpsampleResult

if TYPE_CHECKING:
    from pxr import Usd

__all__ = [
    "Style",
    "UpsampleOptions",
    "UpsampleResult",
    "UpsampledAnimation",
    "main",
    "parser",
    "upsample",
    "upsample_stage",
]

PROG = "python -m usd_tools.upsample"


def upsample(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: UpsampleOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> UpsampleResult:
    """Add samples to the skeletal animation of a USD file.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place` or `dry_run`.
    options : UpsampleOptions
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : UpsampleResult

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the file or the options do not fit it; nothing is written then.

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
    >>> result = upsample(folder / "turn.usda", folder / "out.usda", UpsampleOptions(factor=4))
    >>> result.path.name, result.animations[0].samples_before, result.animations[0].samples_after
    ('out.usda', 2, 5)
    """
    from usd_tools.upsampling.run import upsample_file

    return upsample_file(Path(source), None if out is None else Path(out), options, progress, warn)


def upsample_stage(
    stage: Usd.Stage,
    options: UpsampleOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> UpsampleResult:
    """Add samples to the skeletal animation of an open stage, in the layer of its edit target.

    Parameters
    ----------
    stage : Usd.Stage
    options : UpsampleOptions
        Those about files are not used.
    progress, warn : callable
        See `upsample`.

    Returns
    -------
    result : UpsampleResult

    Raises
    ------
    UsageError
        If `retime` is asked for: a stage keeps its rate.
    ToolError
        If something is wrong with the stage, the options do not fit it, or stronger opinions would hide what is
        written; the layer is as it was then.

    Examples
    --------
    >>> from pxr import Gf, Usd, UsdSkel
    >>> stage = Usd.Stage.CreateInMemory()
    >>> turn = UsdSkel.Animation.Define(stage, "/Turn")
    >>> _ = turn.CreateJointsAttr(["arm"])
    >>> _ = turn.CreateRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0)], 0)
    >>> _ = turn.CreateRotationsAttr().Set([Gf.Quatf(0, 1, 0, 0)], 24)
    >>> stage.SetEditTarget(stage.GetSessionLayer())
    >>> _ = upsample_stage(stage, UpsampleOptions(factor=4))
    >>> turn.GetRotationsAttr().GetTimeSamples()
    [0.0, 6.0, 12.0, 18.0, 24.0]
    """
    from usd_tools.upsampling.run import upsample_open_stage

    return upsample_open_stage(stage, options, progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Add samples to skeletal animation, along geodesics of an invariant metric. Every source sample "
        "is kept bit for bit. The output is a layer over the source and references it; --flatten copies "
        "everything but textures into the output; a name that ends in .usdz packs all files.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file, or folder, to write; .usdz packs all")
    _add_times(parse)
    add_cuts(parse)
    add_contacts(parse)
    add_metric(parse)
    add_library(parse)
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--dry-run", action="store_true", help="compute, but write no OUT")
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")
    parse.add_argument("-v", "--verbose", action="store_true", help="print details, and warn of every doubtful step")
    add_several(parse)
    return parse


def _add_times(parse: argparse.ArgumentParser) -> None:
    where = parse.add_mutually_exclusive_group(required=True)
    where.add_argument("--factor", metavar="N", type=whole_number, help="divide every gap between samples into N")
    where.add_argument("--fps", metavar="F", type=typed_rate, help="add samples at F per second")
    where.add_argument(
        "--times",
        metavar="T",
        type=time_codes,
        help="add samples at these time codes: comma-separated numbers, a text file of numbers, or the word source, "
        "which restores the samples that usd_tools.downsample removed; write '--times=-7.5,-3' if the first "
        "number is negative",
    )
    parse.add_argument(
        "--retime",
        action="store_true",
        help="with --fps: set the stage to F time codes per second, so that the new samples are whole frames; the "
        "motion keeps its speed",
    )


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.upsample", UpsampleOptions, _work)


def _work() -> Work:
    from usd_tools.upsampling.run import upsample_file
    from usd_tools.upsampling.summary import print_summary

    return upsample_file, lambda result, args: print_summary(result, args.verbose)


if __name__ == "__main__":
    sys.exit(main())
