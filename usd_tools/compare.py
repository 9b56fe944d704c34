"""Compare interpolation schemes: rebuild animations from few of their samples, score each, and write a report.

python -m usd_tools.compare walk.usda run.usda -o comparison
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from geomstats_anim.names import KINDS, OWN_SCHEMES
from usd_tools.comparison.options import DEFAULT_CHOICES, RATES, CompareOptions, SchemeChoice
from usd_tools.comparison.result import CompareResult
from usd_tools.console.arguments import add_prim, add_workers, positive_number, share
from usd_tools.console.errors import print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar, ProgressCallback

__all__ = ["CompareOptions", "CompareResult", "SchemeChoice", "compare", "main", "parser"]

PROG = "python -m usd_tools.compare"


def compare(
    sources: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    options: CompareOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> CompareResult:
    """Rebuild skeletal animation from few samples by several schemes, score each, and write a report.

    Parameters
    ----------
    sources : path-like or sequence of path-like
        USD files, and folders that are searched with all folders in them.
    out : path-like
        Folder to make; replaced if all its files were made by an earlier comparison.
    options : CompareOptions
        Optional, default: `CompareOptions()`.
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : CompareResult

    Raises
    ------
    ToolError
        If something is wrong with the files or the folder; nothing is written then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Gf, Usd, UsdSkel
    >>> folder = Path(tempfile.mkdtemp())
    >>> stage = Usd.Stage.CreateNew(str(folder / "swing.usda"))
    >>> swing = UsdSkel.Animation.Define(stage, "/Swing")
    >>> _ = swing.CreateJointsAttr(["arm"])
    >>> for code in range(12):
    ...     turn = Gf.Rotation((1, 0, 0), 40 * (code % 5)) * Gf.Rotation((0, 1, 0), 9 * code)
    ...     _ = swing.CreateRotationsAttr().Set([Gf.Quatf(turn.GetQuat())], code)
    >>> stage.Save()
    >>> options = CompareOptions(rates=[0.5], schemes=["constant", "slerp"])
    >>> result = compare(folder / "swing.usda", folder / "report", options)
    >>> constant, slerp = [row.q_hyb for row in result.rows if not row.out_of_sample]
    >>> slerp < constant
    True
    """
    from usd_tools.comparison.run import compare_files

    paths = [sources] if isinstance(sources, str | os.PathLike) else sources
    return compare_files(list(map(Path, paths)), Path(out), options or CompareOptions(), progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Rebuild skeletal animation from a share of its samples by every interpolation scheme, score each "
        "against the original, and write a report: the experiment of Kushner, Modi and Miolane, for any clip.",
        epilog="FOLDER receives results.json and results.csv, figures, every rebuilt clip as a USD layer over its "
        "source, and index.html, an offline page with all results and a player. Metrics are learned per clip and "
        "rate and scored on the same frames (in-sample); out-of-sample scores are learned from the first half "
        "and scored on the second.",
    )
    parse.add_argument(
        "inputs",
        metavar="IN",
        type=Path,
        nargs="+",
        help="USD file, or a folder to search with its subfolders",
    )
    parse.add_argument(
        "-o",
        "--out",
        metavar="FOLDER",
        type=Path,
        required=True,
        help="output folder; replaced only if an earlier run of this command created it",
    )
    parse.add_argument(
        "--rates",
        metavar="S",
        type=share,
        nargs="+",
        default=list(RATES),
        help=f"shares of the samples to keep as uniform keys; default: {' '.join(f'{rate:g}' for rate in RATES)}",
    )
    parse.add_argument(
        "--schemes",
        metavar="SCHEME",
        type=SchemeChoice.parse,
        nargs="+",
        default=list(DEFAULT_CHOICES),
        help=f"of {', '.join(OWN_SCHEMES)}; a learned scheme may name its family, as in geodesic:spd, "
        "or be plain, with nothing learned; default: all, and geodesic-spline:plain, as upsample without a metric",
    )
    parse.add_argument(
        "--kind",
        choices=KINDS,
        default="hyb",
        help="quality to minimise: positions of bone ends (loc), joint angles (rot), or half of each (hyb, the "
        "default)",
    )
    parse.add_argument(
        "--tolerances",
        metavar="CM",
        type=positive_number,
        nargs="+",
        default=[],
        help="count the bytes of motion that usd_tools.pack, usd_tools.downsample, slerp and plain rounding need to "
        "keep every joint, bone end and point around joints within each distance; default: none",
    )
    parse.add_argument(
        "--library",
        metavar="FILE",
        type=Path,
        help="compare the scheme learned, too, by this library of clips of the same rig, made by usd_tools.learn "
        "--library; a clip of the library is scored by what its other clips teach, which are looked for beside it",
    )
    add_workers(parse)
    add_prim(parse)
    parse.add_argument("-v", "--verbose", action="store_true", help="print all columns of the tables")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)

    def command() -> int:
        options = CompareOptions.from_args(args)
        with ProgressBar() as bar:
            result = compare(args.inputs, args.out, options, progress=bar, warn=print_warning)
        from usd_tools.comparison.tables import print_summary

        print_summary(result, options.kind, args.verbose)
        return 0

    return run(command, parse.error)


if __name__ == "__main__":
    sys.exit(main())
