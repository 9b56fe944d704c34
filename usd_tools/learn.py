"""Learn the metric whose geodesics rebuild skeletal animation best from few of its samples.

python -m usd_tools.learn walk.usda -o walk_learned.usda
python -m usd_tools.learn walk.usda run.usda takes/ -o hero.json
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from geomstats_anim.names import DEFAULT_SCHEME, FAMILIES, INVARIANCE_CHOICES, KINDS, LEARNABLE, PURPOSES, SEARCHES
from usd_tools.console.arguments import add_output, add_prim, add_workers, seed, share, whole_number
from usd_tools.console.errors import print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar, ProgressCallback
from usd_tools.learning.options import PAPERS_RATE, LearnOptions
from usd_tools.learning.result import LearnResult, MetricReport

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["LearnOptions", "LearnResult", "MetricReport", "learn", "learn_stage", "main", "parser"]

PROG = "python -m usd_tools.learn"


def learn(
    sources: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str] | None,
    options: LearnOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> LearnResult:
    """Learn a metric from the skeletal animation of USD files.

    Parameters
    ----------
    sources : path-like or sequence of path-like
        USD files, and folders that are searched with all folders in them.
    out : path-like or None
        USD file to write: a layer over the one source, with a metric on each animation, learned from it alone. Or a
        JSON file: one metric for one rig, learned from all animations together. None with `in_place`.
    options : LearnOptions
        Optional, default: `LearnOptions()`.
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : LearnResult

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the files or the options do not fit them; nothing is written then.

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
    >>> result = learn(folder / "swing.usda", folder / "out.usda", LearnOptions(rate=0.5))
    >>> (score,) = [each for each in result.metrics[0].scores if each["in_sample"]]
    >>> score["score"] < score["slerp_score"]
    True
    """
    from usd_tools.learning.run import learn_files

    paths = [sources] if isinstance(sources, str | os.PathLike) else sources
    target = None if out is None else Path(out)
    return learn_files(list(map(Path, paths)), target, options or LearnOptions(), progress, warn)


def learn_stage(
    stage: Usd.Stage,
    options: LearnOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> LearnResult:
    """Learn a metric from each skeletal animation of an open stage, and store it in the layer of its edit target.

    Parameters
    ----------
    stage : Usd.Stage
    options : LearnOptions
        Those about files are not used.
        Optional, default: `LearnOptions()`.
    progress, warn : callable
        See `learn`.

    Returns
    -------
    result : LearnResult

    Raises
    ------
    ToolError
        If something is wrong with the stage, the options do not fit it, or stronger opinions would hide what is
        written; the layer is as it was then.

    Examples
    --------
    >>> from pxr import Gf, Usd, UsdSkel
    >>> stage = Usd.Stage.CreateInMemory()
    >>> swing = UsdSkel.Animation.Define(stage, "/Swing")
    >>> _ = swing.CreateJointsAttr(["arm"])
    >>> for code in range(12):
    ...     turn = Gf.Rotation((1, 0, 0), 40 * (code % 5)) * Gf.Rotation((0, 1, 0), 9 * code)
    ...     _ = swing.CreateRotationsAttr().Set([Gf.Quatf(turn.GetQuat())], code)
    >>> _ = learn_stage(stage, LearnOptions(rate=0.5))
    >>> swing.GetPrim().GetAttribute("geodesicMetric:joints").Get()[0]
    'arm'
    """
    from usd_tools.learning.run import learn_open_stage

    return learn_open_stage(stage, options or LearnOptions(), progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Learn the metric whose geodesics rebuild skeletal animation best from few of its samples, and "
        "score it against slerp on the frames it was learned from and on unseen ones.",
        epilog="If OUT is a USD file, it is a layer over the one IN, with a metric on each animation, learned from "
        "that animation alone; usd_tools.upsample uses it. If OUT is a .json file, it holds one metric for one "
        "rig, learned from all animations of all IN together; pass it to usd_tools.upsample as --metric OUT.",
    )
    parse.add_argument(
        "inputs",
        metavar="IN",
        type=Path,
        nargs="+",
        help="USD file, or a folder to search with its subfolders",
    )
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file, .json file or .inbetween file to write")
    _add_metric(parse)
    add_prim(parse)
    parse.add_argument(
        "--skip-mismatched", action="store_true", help="skip animations whose rig differs from the first"
    )
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write all scores, also per joint, as JSON")
    parse.add_argument("-v", "--verbose", action="store_true", help="print what the metric means for each joint")
    _add_tune(parse)
    return parse


def _add_metric(parse: ArgumentParser) -> None:
    parse.add_argument(
        "--rate",
        metavar="S",
        type=share,
        default=PAPERS_RATE,
        help="share of the samples to keep as keys; the others are rebuilt from them; default: %(default)s, as in "
        "the papers",
    )
    parse.add_argument(
        "--purpose",
        choices=PURPOSES,
        default=PURPOSES[0],
        help="reconstruct: fit these samples as closely as possible (default); predict: only as far as "
        "cross-validation shows a gain on unseen frames",
    )
    parse.add_argument(
        "--library",
        action="store_true",
        help="with --purpose predict: learn from 10 to 120 clips of one rig what splines miss, for other clips of it, "
        "instead of a metric; OUT ends in .inbetween, and is used by usd_tools.upsample --library OUT",
    )
    parse.add_argument(
        "--search",
        choices=SEARCHES,
        default=SEARCHES[0],
        help="gradient: about a second (default); tpe: HyperOpt, joint by joint; tpe-joint: the search of the "
        "papers, on Ray Tune",
    )
    parse.add_argument(
        "--family",
        choices=FAMILIES,
        default=FAMILIES[0],
        help="diagonal: along the joints' own axes (default); spd: tilted axes too",
    )
    parse.add_argument(
        "--invariance",
        choices=INVARIANCE_CHOICES,
        default="joint",
        help="left, right, the better side for all joints (clip), or for each joint (joint, the default)",
    )
    parse.add_argument("--scheme", choices=LEARNABLE, default=DEFAULT_SCHEME, help="interpolation to learn for")
    parse.add_argument(
        "--kind",
        choices=KINDS,
        default="hyb",
        help="quality to minimise: positions of bone ends (loc), joint angles (rot), or half of each (hyb, the "
        "default)",
    )
    parse.add_argument("--weights", choices=("depth",), help="weight joints by their depth, as in the papers")
    parse.add_argument("--seed", metavar="N", type=seed, default=0, help="seed of the TPE searches; default: 0")


def _add_tune(parse: ArgumentParser) -> None:
    tune = parse.add_argument_group("TPE searches and Ray", "These need: pip install 'geomstats-anim[tune]'")
    tune.add_argument("--trials", metavar="N", type=whole_number, help="number of evaluations; for tpe, per joint")
    where = tune.add_mutually_exclusive_group()
    where.add_argument(
        "--folder", metavar="FOLDER", type=Path, help="keep the results of tpe-joint here, for TensorBoard"
    )
    where.add_argument(
        "--resume",
        metavar="FOLDER",
        type=Path,
        help="continue an interrupted tpe-joint search from its trials.jsonl; nothing else in FOLDER is read",
    )
    add_workers(tune)
    tune.add_argument("--wandb", metavar="PROJECT", help="log tpe-joint to Weights & Biases (the extra wandb)")


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)

    def command() -> int:
        options = LearnOptions.from_args(args)
        with ProgressBar() as bar:
            result = learn(args.inputs, args.out, options, progress=bar, warn=print_warning)
        from usd_tools.learning.summary import print_summary

        print_summary(result, args.verbose)
        return 0

    return run(command, parse.error)


if __name__ == "__main__":
    sys.exit(main())
