"""Repair skeletal animation: gaps, spikes, drop-outs and sign flips, rebuilt from the good samples beside them.

python -m usd_tools.repair capture.usda -o repaired.usda
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.main import Work, run_on_files
from usd_tools.console.arguments import add_inputs, add_output, add_prim, add_several, positive_number, whole_number
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.repairing.options import RepairOptions
from usd_tools.repairing.result import RepairResult

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["RepairOptions", "RepairResult", "main", "parser", "repair", "repair_stage"]

PROG = "python -m usd_tools.repair"


def repair(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: RepairOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> RepairResult:
    """Repair the skeletal animation of a USD file.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place` or `dry_run`.
    options : RepairOptions
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : RepairResult

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
    >>> for code in range(24):
    ...     quat = Gf.Quatf(Gf.Rotation((1, 0, 0), 2.0 * code + (90 if code == 12 else 0)).GetQuat())
    ...     _ = turn.CreateRotationsAttr().Set([quat], code)
    >>> stage.Save()
    >>> repair(folder / "turn.usda", folder / "out.usda", RepairOptions()).brief
    '1 spike'
    """
    from usd_tools.repairing.run import repair_file

    return repair_file(Path(source), None if out is None else Path(out), options, progress, warn)


def repair_stage(
    stage: Usd.Stage,
    options: RepairOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> RepairResult:
    """Repair the skeletal animation of an open stage, in the layer of its edit target.

    Parameters
    ----------
    stage : Usd.Stage
    options : RepairOptions
        Those about files are not used.
    progress, warn : callable
        See `repair`.

    Returns
    -------
    result : RepairResult

    Raises
    ------
    ToolError
        If something is wrong with the stage, the options do not fit it, or stronger opinions would hide what is
        written; the layer is as it was then.

    Examples
    --------
    >>> from pxr import Gf, Usd, UsdSkel
    >>> stage = Usd.Stage.CreateInMemory()
    >>> turn = UsdSkel.Animation.Define(stage, "/Turn")
    >>> _ = turn.CreateJointsAttr(["arm"])
    >>> for code in range(24):
    ...     _ = turn.CreateRotationsAttr().Set([Gf.Quatf(code != 12, 0, 0, 0)], code)
    >>> repair_stage(stage, RepairOptions()).brief
    '1 gap'
    >>> turn.GetRotationsAttr().Get(12)[0]
    Gf.Quatf(1.0, Gf.Vec3f(0.0, 0.0, 0.0))
    """
    from usd_tools.repairing.run import repair_open_stage

    return repair_open_stage(stage, options, progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Find the faults of recorded motion and rebuild them from the samples beside them, on the geodesic "
        "spline: gaps (numbers that are not finite, quaternions of no length), spikes of one to three samples, flips "
        "by half a turn, drop-outs that repeat a sample while the motion goes on, and sign flips. All other samples "
        "stay bit for bit. Motion that is fast, and poses that are held, are left alone; of keys with "
        "fewer than 15 per second only gaps are found. usd_tools.inspect lists faults, too.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file, or folder, to write; .usdz packs all")
    parse.add_argument(
        "--max-gap",
        metavar="N",
        type=whole_number,
        help="rebuild at most so many samples in a row, and leave what is longer; default: those of a second",
    )
    parse.add_argument(
        "--smooth",
        metavar="HZ",
        type=positive_number,
        help="then filter motion that is faster than this, without delay: half of the amplitude is left at HZ, a "
        "thirtieth at 5/4 HZ",
    )
    parse.add_argument(
        "--no-xforms",
        action="store_true",
        help="leave the transforms that move a character as a whole as they are",
    )
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--dry-run", action="store_true", help="list the faults, but write no OUT")
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")
    add_several(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.repair", RepairOptions, _work)


def _work() -> Work:
    from usd_tools.repairing.run import repair_file
    from usd_tools.repairing.summary import print_summary

    return repair_file, lambda result, _: print_summary(result)


if __name__ == "__main__":
    sys.exit(main())
