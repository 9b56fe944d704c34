"""Give skeletal animation exactly F samples per second, on whole frames and nowhere else.

python -m usd_tools.resample capture_120.usda -o capture_30.usda --fps 30 --antialias --retime
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.main import Work, run_on_files
from usd_tools.console.arguments import add_inputs, add_output, add_prim, add_several
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.resampling.options import ResampleOptions
from usd_tools.resampling.result import ResampleResult
from usd_tools.skel.frame_rates import typed_rate
from usd_tools.upsampling.arguments import add_cuts, add_library, add_metric

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["ResampleOptions", "ResampleResult", "main", "parser", "resample", "resample_stage"]

PROG = "python -m usd_tools.resample"


def resample(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: ResampleOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> ResampleResult:
    """Give the skeletal animation of a USD file exactly so many samples per second.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place` or `dry_run`.
    options : ResampleOptions
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : ResampleResult

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
    >>> _ = resample(folder / "turn.usda", folder / "out.usda", ResampleOptions(fps=5, retime=True))
    >>> stage = Usd.Stage.Open(str(folder / "out.usda"))
    >>> stage.GetTimeCodesPerSecond(), stage.GetPrimAtPath("/Turn").GetAttribute("rotations").GetTimeSamples()
    (5.0, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    """
    from usd_tools.resampling.run import resample_file

    return resample_file(Path(source), None if out is None else Path(out), options, progress, warn)


def resample_stage(
    stage: Usd.Stage,
    options: ResampleOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> ResampleResult:
    """Give the skeletal animation of an open stage so many samples per second, in the layer of its edit target.

    Parameters
    ----------
    stage : Usd.Stage
    options : ResampleOptions
        Those about files are not used.
    progress, warn : callable
        See `resample`.

    Returns
    -------
    result : ResampleResult

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
    >>> for code in range(25):
    ...     _ = turn.CreateRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0)], code)
    >>> stage.SetEditTarget(stage.GetSessionLayer())
    >>> _ = resample_stage(stage, ResampleOptions(fps=4))
    >>> turn.GetRotationsAttr().GetTimeSamples()
    [0.0, 6.0, 12.0, 18.0, 24.0]
    """
    from usd_tools.resampling.run import resample_open_stage

    return resample_open_stage(stage, options, progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Give skeletal animation exactly F samples per second, on the whole frames of that rate and "
        "nowhere else: joints, blend shapes and the transforms that move a character. Source samples on such frames "
        "are kept bit for bit, unless --antialias filters them; cuts, holds and value blocks stay.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file, or folder, to write; .usdz packs all")
    parse.add_argument("--fps", metavar="F", type=typed_rate, required=True, help="samples per second")
    parse.add_argument(
        "--antialias",
        action="store_true",
        help="before taking fewer samples, filter motion that is faster than they can hold, without delay: half of the "
        "amplitude is left at 0.4 F, a thirtieth at 0.5 F",
    )
    parse.add_argument(
        "--retime",
        action="store_true",
        help="set the stage to F time codes per second, so that every sample is on a whole one; the motion keeps its "
        "speed",
    )
    add_cuts(parse)
    add_metric(parse)
    add_library(parse)
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--dry-run", action="store_true", help="compute, but write no OUT")
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")
    parse.add_argument("-v", "--verbose", action="store_true", help="print details, and warn of every doubtful step")
    add_several(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.resample", ResampleOptions, _work)


def _work() -> Work:
    from usd_tools.resampling.run import resample_file
    from usd_tools.upsampling.summary import print_summary

    return resample_file, lambda result, args: print_summary(result, args.verbose)


if __name__ == "__main__":
    sys.exit(main())
