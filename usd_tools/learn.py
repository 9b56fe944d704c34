"""Learn the metric whose geodesics rebuild skeletal animation best from few of its samples.

python -m usd_tools.learn walk.usda -o walk_learned.usda
python -m usd_tools.learn walk.usda run.usda takes/ -o hero.json
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pxr import Usd

from geomstats_anim import __version__
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.names import FAMILIES, INVARIANCE_CHOICES, KINDS, PURPOSES, SEARCHES, TRIALS, WITH_METRIC
from usd_tools.console.arguments import add_output, add_prim, add_workers, seed, share, whole_number
from usd_tools.console.errors import Messages, ToolError, print_warning, run
from usd_tools.console.options import OutputOptions
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import Progress, ProgressBar, SearchProgress
from usd_tools.files.atomic import write_json, written_beside
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.paths import EXTENSIONS, check_output, same_file
from usd_tools.files.stages import open_stage
from usd_tools.learning import summary as learn_report
from usd_tools.learning.clips import Take
from usd_tools.learning.files import Skipped, files_in, gather, read_clips, take_all
from usd_tools.learning.train import PAPERS_RATE, Lesson, Recipe, teach
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.output import Output, check_report

TOOL = "usd_tools.learn"

_TPE_ONLY = {"trials": "--trials", "folder": "--folder", "resume": "--resume", "wandb": "--wandb"}

PROG = "python -m usd_tools.learn"


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Learn the metric whose geodesics rebuild skeletal animation best from few of its samples, and say "
        "what it is worth beside slerp, on the samples it was learned from and on others.",
        epilog="OUT decides what is made. A USD file: a layer over the one IN, with a metric on each animation, "
        "learned from that animation alone; usd_tools.upsample finds it there. A .json file: one metric for one rig, "
        "learned from all animations of all IN together; give it to usd_tools.upsample as --metric OUT.",
    )
    parse.add_argument(
        "inputs",
        metavar="IN",
        type=Path,
        nargs="+",
        help="USD file, or folder, searched with all folders in it",
    )
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file or .json file to write")
    parse.add_argument(
        "--rate",
        metavar="S",
        type=share,
        default=PAPERS_RATE,
        help="share of the samples kept as keys, from which the others are rebuilt; default: %(default)s, the papers'",
    )
    parse.add_argument(
        "--purpose",
        choices=PURPOSES,
        default=PURPOSES[0],
        help="reconstruct: fit these samples as well as can be (default); predict: only as far as cross-validation "
        "says that it carries over to frames that nobody has seen",
    )
    parse.add_argument(
        "--search",
        choices=SEARCHES,
        default=SEARCHES[0],
        help="gradient: about a second (default); tpe: HyperOpt joint by joint; tpe-joint: the papers', on Ray Tune",
    )
    parse.add_argument(
        "--family", choices=FAMILIES, default=FAMILIES[0], help="axes of the joints (default), or tilted ones too: spd"
    )
    parse.add_argument(
        "--invariance",
        choices=INVARIANCE_CHOICES,
        default="joint",
        help="side: left, right, the better one for all joints (clip), or for each joint (default)",
    )
    parse.add_argument(
        "--scheme", choices=WITH_METRIC, default=WITH_METRIC[0], help="interpolation that the metric is for"
    )
    parse.add_argument(
        "--kind",
        choices=KINDS,
        default="hyb",
        help="what counts: places of bone ends (loc), angles of joints (rot), or half of each (default)",
    )
    parse.add_argument("--weights", choices=("depth",), help="weigh joints by their depth, as the papers do")
    parse.add_argument("--seed", metavar="N", type=seed, default=0, help="of the TPE searches; default: 0")
    add_prim(parse)
    parse.add_argument(
        "--skip-mismatched", action="store_true", help="go on without animations of another rig than the first"
    )
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write all scores, joint by joint too, as JSON")
    parse.add_argument("-v", "--verbose", action="store_true", help="say what the metric means for each joint")
    tune = parse.add_argument_group("TPE searches and Ray", "They need: pip install 'geomstats-anim[tune]'")
    tune.add_argument("--trials", metavar="N", type=whole_number, help="most evaluations; for tpe, of each joint")
    where = tune.add_mutually_exclusive_group()
    where.add_argument("--folder", metavar="FOLDER", type=Path, help="keep the results of tpe-joint, for TensorBoard")
    where.add_argument("--resume", metavar="FOLDER", type=Path, help="go on with a tpe-joint search that was stopped")
    add_workers(tune)
    tune.add_argument("--wandb", metavar="PROJECT", help="log tpe-joint to Weights & Biases (the extra wandb)")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)
    if args.out is None and not args.in_place:
        parse.error("name the output with -o/--out")
    for name, option in _TPE_ONLY.items():
        needed = SEARCHES[1:] if name == "trials" else ("tpe-joint",)
        if getattr(args, name) is not None and args.search not in needed:
            parse.error(f"{option} goes with --search {' or '.join(needed)}")
    if (args.folder or args.resume) and args.purpose == "predict":
        parse.error("--folder and --resume hold one search, but --purpose predict makes several")
    return run(lambda: learn(args))


@openusd_errors()
def learn(args: argparse.Namespace) -> int:
    """Do what the arguments say."""
    messages = Messages(print_warning)
    if args.out is not None and args.out.suffix == ".json":
        return _learn_json(args, messages)
    return _learn_usd(args, messages)


def _learn_json(args: argparse.Namespace, messages: Messages) -> int:
    """Learn one metric for one rig, and write it to a file of its own."""
    check_output(args.out, "--out")
    for_usd = {"--in-place": args.in_place, "--flatten": args.flatten, "--usdFormat": args.usdFormat}
    for option, value in for_usd.items():
        if value:
            raise ToolError(f"{option} is for a USD file, but --out is {args.out}; leave one of them out.")
    check_report(args.report, args.out)
    with usd_warnings(messages):
        files = files_in(args.inputs, messages)
        for argument, path in (("--out", args.out), ("--report", args.report)):
            if path is not None and same_file(path, files):
                raise ToolError(f"{argument} {path} is an input; choose another name.")
        with ProgressBar() as bar:
            progress = Progress(bar, len(files), "Reading")
            takes, skipped = gather(files, args.prim, args.skip_mismatched, messages, progress.advance)
        lesson = _teach(args, takes, messages)
    with written_beside(args.out) as beside:
        beside.write_text(lesson.metric.to_json(), encoding="utf-8")
    learn_report.tell(lesson, args.verbose, messages)
    print(
        f"{args.out} is written; use it with: python -m usd_tools.upsample IN -o OUT --factor 4 --metric "
        f"{shlex.quote(str(args.out))}"
    )
    _report(args, args.out.name, [lesson], skipped, messages)
    return 0


def _learn_usd(args: argparse.Namespace, messages: Messages) -> int:
    """Learn a metric for each animation of one file."""
    if len(args.inputs) > 1 or args.inputs[0].is_dir():
        what = "--in-place changes" if args.out is None else f"--out {args.out} goes over"
        raise ToolError(f"{what} one file; for one metric from several files, name an --out that ends in .json.")
    path = args.inputs[0]
    if args.out is not None and args.out.suffix not in EXTENSIONS:
        raise ToolError(f"--out {args.out}: the name must end in {', '.join(EXTENSIONS)}, .json.")
    target = Output(path, args.out, OutputOptions.from_args(args))
    target.check()
    with usd_warnings(messages), reading(path):
        stage = open_stage(path)
        target.check_layers(stage)
        taken, skipped = take_all(path, read_clips(path, args.prim, messages), messages)
        if len(taken) > 1 and (args.folder or args.resume):
            raise ToolError(
                f"A folder holds one search, but {path} has {len(taken)} animations; choose one with --prim."
            )
        lessons = [_teach(args, [take], messages) for _, take in taken]
        _write(args, target, stage, [clip for clip, _ in taken], lessons, messages)
        for lesson in lessons:
            learn_report.tell(lesson, args.verbose, messages)
    print(f"{target.path} is written: a metric, and every sample as it was; usd_tools.upsample finds the metric there.")
    _report(args, target.path.name, lessons, skipped, messages)
    return 0


def _recipe(args: argparse.Namespace) -> Recipe:
    try:
        tune = TuneSettings(
            trials=args.trials,
            folder=args.resume or args.folder,
            resume=args.resume is not None,
            address=args.address,
            cpus=args.cpus,
            wandb=args.wandb,
        )
    except ValueError as error:
        raise ToolError(str(error)) from error
    words = ("rate", "search", "purpose", "family", "invariance", "scheme", "kind", "weights", "seed")
    return Recipe(**{word: getattr(args, word) for word in words}, tune=tune)


def _teach(args: argparse.Namespace, takes: Sequence[Take], messages: Messages) -> Lesson:
    alone = sum(len(take.stretches) for take in takes) == 1
    if alone and args.search == "gradient" and (args.address or (args.cpus or 1) > 1):
        option = "--address" if args.address else "--cpus"
        messages.warn(f"{option} spreads several clips over workers; {takes[0]} is one, learned in this process.")
    with ProgressBar() as bar:
        progress = SearchProgress(bar, args.trials or TRIALS if args.search == "tpe-joint" else None)
        return teach(takes, _recipe(args), progress.watch)


def _write(
    args: argparse.Namespace,
    target: Output,
    stage: Usd.Stage,
    clips: Sequence[SkelClip],
    lessons: Sequence[Lesson],
    messages: Messages,
) -> None:
    layer = target.layer(stage, TOOL, _settings(args), messages)
    for clip, lesson in zip(clips, lessons, strict=True):
        metric, _ = lesson.metric.for_joints(clip.joints)
        # An animation within an instance may have to move out of it, and must take its samples along.
        moved = clip.channels if clip.source.prim.IsInstanceProxy() else {}
        sampled = {name: channel for name, channel in moved.items() if len(channel.codes)}
        layer.write_animation(clip.source, sampled, {}, metric, messages)
    target.save(layer)


def _settings(args: argparse.Namespace) -> dict[str, Any]:
    """Arguments that say what was done, as plain values without paths of this machine."""
    words = ("rate", "search", "purpose", "family", "invariance", "scheme", "kind", "weights", "seed", "trials")
    settings = {word: getattr(args, word) for word in words} | {"prim": " ".join(args.prim) or None}
    return {name: value for name, value in settings.items() if value is not None}


def _report(
    args: argparse.Namespace, out: str, lessons: Sequence[Lesson], skipped: list[Skipped], messages: Messages
) -> None:
    """Write what was done, as plain values: see `learn_report`."""
    if args.report is not None:
        report = {
            "tool": TOOL,
            "version": __version__,
            "output": out,
            "settings": _settings(args),
            "metrics": [learn_report.described(lesson) for lesson in lessons],
            "skipped": learn_report.described_skipped(skipped),
            "warnings": messages.warnings,
        }
        write_json(args.report, report)


if __name__ == "__main__":
    sys.exit(main())
