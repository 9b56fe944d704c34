"""Keep few samples of skeletal animation, chosen so that the others can be rebuilt, and the metric that rebuilds them.

python -m usd_tools.downsample walk.usda -o walk_small.usdc --tolerance 1
python -m usd_tools.upsample walk_small.usdc -o walk_back.usda --times source
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from geomstats_anim.names import (
    CRITERIA,
    DEFAULT_SCHEME,
    FAMILIES,
    MEASURES,
    OWN_SCHEMES,
    SELECTIONS,
    WEIGHTS_TOLERANCE,
)
from usd_tools.batch.main import Work, run_on_files
from usd_tools.console.arguments import (
    add_inputs,
    add_output,
    add_prim,
    add_several,
    positive_number,
    share,
    time_codes,
    whole_number,
)
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.downsampling.options import DownsampleOptions
from usd_tools.downsampling.result import DownsampledAnimation, DownsampleResult

if TYPE_CHECKING:
    from pxr import Usd

__all__ = [
    "DownsampleOptions",
    "DownsampleResult",
    "DownsampledAnimation",
    "downsample",
    "downsample_stage",
    "main",
    "parser",
]

PROG = "python -m usd_tools.downsample"


def downsample(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: DownsampleOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> DownsampleResult:
    """Keep few samples of the skeletal animation of a USD file, and the metric that rebuilds the others.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place`.
    options : DownsampleOptions
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : DownsampleResult

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the file, the options do not fit it, or what would be written does not hold the
        tolerance; nothing is written then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Gf, Usd, UsdSkel
    >>> folder = Path(tempfile.mkdtemp())
    >>> stage = Usd.Stage.CreateNew(str(folder / "turn.usda"))
    >>> turn = UsdSkel.Animation.Define(stage, "/Turn")
    >>> _ = turn.CreateJointsAttr(["arm"])
    >>> for code in range(11):
    ...     _ = turn.CreateRotationsAttr().Set([Gf.Quatf(Gf.Rotation((1, 0, 0), 9 * code).GetQuat())], code)
    >>> stage.Save()
    >>> result = downsample(folder / "turn.usda", folder / "out.usda", DownsampleOptions(rate=0.2))
    >>> result.animations[0].samples, result.animations[0].kept_time_codes
    (11, (0.0, 10.0))
    """
    from usd_tools.downsampling.run import downsample_file

    return downsample_file(Path(source), None if out is None else Path(out), options, progress, warn)


def downsample_stage(
    stage: Usd.Stage,
    options: DownsampleOptions,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> DownsampleResult:
    """Keep few samples of the skeletal animation of an open stage, in the layer of its edit target.

    The samples that are left hide those of weaker layers, which stay there.

    Parameters
    ----------
    stage : Usd.Stage
    options : DownsampleOptions
        Those about files are not used.
    progress, warn : callable
        See `downsample`.

    Returns
    -------
    result : DownsampleResult

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
    >>> for code in range(11):
    ...     _ = turn.CreateRotationsAttr().Set([Gf.Quatf(Gf.Rotation((1, 0, 0), 9 * code).GetQuat())], code)
    >>> _ = downsample_stage(stage, DownsampleOptions(rate=0.2))
    >>> turn.GetRotationsAttr().GetTimeSamples()
    [0.0, 10.0]
    """
    from usd_tools.downsampling.run import downsample_open_stage

    return downsample_open_stage(stage, options, progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Keep few samples of skeletal animation, bit for bit, and store the metric and tensions that "
        "rebuild the others: usd_tools.upsample OUT -o BACK --times source. Everything else on the stage is "
        "unchanged. OUT does not need the samples of IN, and plays in any viewer, which shows slerp between the "
        "kept samples.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file or folder to write")
    _add_choice(parse)
    _add_metric(parse)
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write all errors, also per joint, as JSON")
    parse.add_argument(
        "--picture",
        metavar="FILE",
        type=Path,
        help="draw the kept samples over the speed of the motion: .png, .svg or .pdf",
    )
    parse.add_argument("-v", "--verbose", action="store_true", help="print the errors of every joint")
    add_several(parse)
    return parse


def _add_choice(parse: ArgumentParser) -> None:
    how_many = parse.add_mutually_exclusive_group(required=True)
    how_many.add_argument(
        "--rate", metavar="S", type=share, help="share of the samples of joints to keep, above 0 and below 1"
    )
    how_many.add_argument(
        "--keys", metavar="K", type=whole_number, help="number of samples of joints to keep in each animation"
    )
    how_many.add_argument(
        "--tolerance",
        metavar="CM",
        type=positive_number,
        help="keep the fewest samples with which every measured point stays within this distance in the world, in "
        "centimetres",
    )
    how_many.add_argument(
        "--keep-only",
        metavar="T",
        type=time_codes,
        help="keep exactly the samples at these time codes, and the ends of stretches between cuts: comma-separated "
        "numbers, or a text file of them",
    )
    parse.add_argument(
        "--weights-tolerance",
        metavar="W",
        type=positive_number,
        default=WEIGHTS_TOLERANCE,
        help="keep the fewest samples of blend shape weights with which every weight stays within W, whether joints go "
        "by --rate, --keys or --tolerance; default: %(default)g",
    )
    parse.add_argument(
        "--measure",
        choices=MEASURES,
        help="points that --tolerance is about: joints, bone ends and points around the joints (shell, the default); "
        "joints and bone ends alone (ends), which twists about a bone's axis do not move; or the points of the skin "
        "too (skin)",
    )
    parse.add_argument(
        "--shell",
        metavar="CM",
        type=positive_number,
        help="distance of the points of --measure shell from the joints, in centimetres; default: 3",
    )
    parse.add_argument(
        "--select",
        choices=SELECTIONS,
        default=SELECTIONS[0],
        help="which samples to keep: the best (optimal, the default), or equally spaced ones (uniform)",
    )
    parse.add_argument(
        "--keep",
        metavar="T",
        type=time_codes,
        help="samples to keep in any case: comma-separated time codes, or a text file of them; write '--keep=-7,-3' "
        "if the first is negative",
    )


def _add_metric(parse: ArgumentParser) -> None:
    parse.add_argument(
        "--contacts",
        action="store_true",
        help="store what is planted on the ground, such as feet, and when, so that upsample --contacts also knows it "
        "between the samples that are kept",
    )
    parse.add_argument(
        "--scheme",
        choices=OWN_SCHEMES,
        default=DEFAULT_SCHEME,
        help="interpolation that rebuilds the rest; default: %(default)s",
    )
    parse.add_argument(
        "--family",
        choices=FAMILIES,
        help="family of the metric, see usd_tools.learn; default: spd, or diagonal with --tolerance",
    )
    parse.add_argument(
        "--kind",
        choices=CRITERIA,
        help="error that --rate, --keys and --keep-only minimise: distances of bone ends (loc), joint angles (rot), "
        "half of each (hyb, the default), or the largest distance (max), which --tolerance always uses",
    )


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.downsample", DownsampleOptions, _work, for_one=("picture",))


def _work() -> Work:
    from usd_tools.downsampling.run import downsample_file
    from usd_tools.downsampling.summary import print_summary

    return downsample_file, lambda result, args: print_summary(result, args.input[0], args.verbose)


if __name__ == "__main__":
    sys.exit(main())
