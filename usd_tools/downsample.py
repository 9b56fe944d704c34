"""Keep few samples of skeletal animation, chosen so that the others can be rebuilt, and the metric that rebuilds them.

python -m usd_tools.downsample walk.usda -o walk_small.usdc --tolerance 1
python -m usd_tools.upsample walk_small.usdc -o walk_back.usda --times source
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pxr import Usd

from geomstats_anim import SCHEMES, __version__
from geomstats_anim.names import CRITERIA, FAMILIES, SELECTIONS, WITH_METRIC
from usd_tools.console.arguments import add_output, add_prim, positive_number, share, time_codes, whole_number
from usd_tools.console.errors import Messages, ToolError, print_warning, run
from usd_tools.console.options import OutputOptions
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar, SearchProgress
from usd_tools.downsampling import summary as downsample_report
from usd_tools.downsampling.reduce import Reduced, Wanted, reduce_clip, verified
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_unheard, usd_warnings
from usd_tools.files.paths import check_output, same_file
from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.skel.output import Output

TOOL = "usd_tools.downsample"

PROG = "python -m usd_tools.downsample"


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Keep few samples of skeletal animation, bit for bit, and with them the metric and the tensions "
        "that rebuild the others: usd_tools.upsample OUT -o BACK --times source. Everything else on the stage stays. "
        "OUT does not need the samples of IN, and plays in any viewer, as slerp between those that are left.",
    )
    parse.add_argument("input", metavar="IN", type=Path, help="USD file")
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file to write")
    how_many = parse.add_mutually_exclusive_group(required=True)
    how_many.add_argument("--rate", metavar="S", type=share, help="share of the samples to keep, above 0 and below 1")
    how_many.add_argument("--keys", metavar="K", type=whole_number, help="number of samples to keep, of each animation")
    how_many.add_argument(
        "--tolerance",
        metavar="CM",
        type=positive_number,
        help="keep the fewest with which no bone end is ever further than this from its place, in centimetres; turning "
        "about a bone's own axis moves no bone end, so such turns may go",
    )
    parse.add_argument(
        "--select", choices=SELECTIONS, default=SELECTIONS[0], help="which samples: the best (default), or every n-th"
    )
    parse.add_argument(
        "--keep",
        metavar="T",
        type=time_codes,
        help="samples that must stay: time codes with commas between them, or a text file of them; say '--keep=-7,-3' "
        "where the first is below zero",
    )
    parse.add_argument(
        "--scheme",
        choices=list(SCHEMES),
        default="geodesic-spline",
        help="what rebuilds the rest; default: %(default)s",
    )
    parse.add_argument(
        "--family",
        choices=FAMILIES,
        help=f"of the metric of {' or '.join(WITH_METRIC)}, see usd_tools.learn; default: spd, or diagonal for "
        "--tolerance",
    )
    parse.add_argument(
        "--kind",
        choices=CRITERIA,
        help="what --rate and --keys make least: distances of bone ends (loc), angles of joints (rot), half of each "
        "(hyb, the default), or the largest distance (max), which is what --tolerance is about",
    )
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write all errors, joint by joint, as JSON")
    parse.add_argument(
        "--picture", metavar="FILE", type=Path, help="draw the samples kept over the motion's speed: .png, .svg or .pdf"
    )
    parse.add_argument("-v", "--verbose", action="store_true", help="print the errors of every joint")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)
    if args.out is None and not args.in_place:
        parse.error("name the output with -o/--out")
    if args.tolerance is not None and args.kind not in (None, "max"):
        parse.error(f"--kind {args.kind} goes with --rate or --keys; --tolerance is about the largest distance")
    if args.keep is not None and args.select == "uniform":
        parse.error("--keep goes with --select optimal; uniform samples are where they are")
    if args.family is not None and args.scheme not in WITH_METRIC:
        parse.error(f"--scheme {args.scheme} has no metric, so it has no family; leave out --family {args.family}")
    return run(lambda: downsample(args))


@openusd_errors()
def downsample(args: argparse.Namespace) -> int:
    """Do what the arguments say."""
    messages = Messages(print_warning)
    target = Output(args.input, args.out, OutputOptions.from_args(args))
    target.check()
    _check_picture(args, target)
    with usd_warnings(messages):
        stage = open_stage(args.input)
    target.check_layers(stage)
    size_before = args.input.stat().st_size
    with usd_warnings(messages), reading(args.input):
        sources = select_animations(args.input, find_animations(stage), args.prim)
        target = target.without_source(sources)
        wanted = Wanted.of(args)
        reduced = []
        for source in sources:
            with ProgressBar() as bar:
                progress = SearchProgress(bar, None)
                reduced.append(reduce_clip(args.input, read_clip(source), wanted, messages, progress.watch))
        moving = [each for each in reduced if each is not None]
        if not moving:
            raise ToolError(f"{args.input} has no skeletal animation with two samples or more to choose from.")
        _write(args, target, stage, moving, messages)
    with usd_unheard():  # the source has told what is wrong
        checked = verified(target.path, moving, wanted)
    described = [downsample_report.described(each) for each in checked]
    for each, values in zip(checked, described, strict=True):
        downsample_report.tell(each.clip, values, args.verbose)
        if args.tolerance is not None:
            downsample_report.warn_of_twists(values, args.tolerance, messages)
    downsample_report.tell_file(args.input, size_before, target.path, messages)
    if args.picture is not None:
        downsample_report.draw(checked, args.picture)
    if args.report is not None:
        write_json(args.report, _report(args, target, size_before, described, messages))
    return 0


def _check_picture(args: argparse.Namespace, target: Output) -> None:
    if args.picture is None:
        return
    if args.picture.suffix not in downsample_report.PICTURES:
        raise ToolError(f"--picture {args.picture}: the name must end in {', '.join(downsample_report.PICTURES)}.")
    check_output(args.picture, "--picture")
    others = [path for path in (args.input, target.path, args.report) if path is not None]
    if same_file(args.picture, others) or args.picture.resolve() in [other.resolve() for other in others]:
        raise ToolError(f"--picture {args.picture} is the input or another output; choose another name.")


def _write(
    args: argparse.Namespace, target: Output, stage: Usd.Stage, reduced: Sequence[Reduced], messages: Messages
) -> None:
    layer = target.layer(stage, TOOL, _settings(args), messages)
    for each in reduced:
        sampled = {name: channel for name, channel in each.sparse.channels.items() if len(channel.codes)}
        constant = {name: each.sparse.channels[name].default for name in each.sparse.channels if name not in sampled}
        source = each.clip.source
        layer.write_animation(
            source, sampled, {**each.clip.missing, **constant}, each.metric, messages, each.clip.codes
        )
    target.save(layer)


def _settings(args: argparse.Namespace) -> dict[str, Any]:
    """Arguments that say what was done, as plain values without paths of this machine."""
    settings = {
        word: getattr(args, word) for word in ("rate", "keys", "tolerance", "select", "scheme", "family", "kind")
    }
    settings |= {"keep": None if args.keep is None else args.keep.text, "prim": " ".join(args.prim) or None}
    return {name: value for name, value in settings.items() if value is not None}


def _report(
    args: argparse.Namespace,
    target: Output,
    size_before: int,
    animations: Sequence[dict[str, Any]],
    messages: Messages,
) -> dict[str, Any]:
    """Tell what was done, as plain values."""
    return {
        "tool": TOOL,
        "version": __version__,
        "source": args.input.name,
        "output": target.path.name,
        "settings": _settings(args),
        "file_bytes_before": size_before,
        "file_bytes_after": target.path.stat().st_size,
        "animations": list(animations),
        "warnings": messages.warnings,
    }


if __name__ == "__main__":
    sys.exit(main())
