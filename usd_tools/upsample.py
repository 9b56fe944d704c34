"""Add samples to skeletal animation, along geodesics of an invariant metric; every sample that is there stays.

python -m usd_tools.upsample walk.usda -o walk_x4.usda --factor 4
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd

from geomstats_anim import SCHEMES, __version__
from geomstats_anim.names import DEFAULT_SCHEME, INVARIANCES, WITH_METRIC
from usd_tools.console.arguments import add_output, add_prim, positive_number, time_codes, whole_number
from usd_tools.console.errors import Messages, ToolError, print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import Progress
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import open_stage, standing
from usd_tools.skel import output
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.frame_rates import typed_rate
from usd_tools.skel.output import Output
from usd_tools.skel.resampling import Resampled, at_rate, resample, subdivided, with_codes
from usd_tools.skel.time_codes import clips_with_source_codes, codes_for
from usd_tools.upsampling.joint_styles import Style, parse_style
from usd_tools.upsampling.metric import EffectiveMetric, effective_metrics
from usd_tools.upsampling.summary import Job, described, tell

MAX_ROTATIONS = 1 << 27
"""More than these are taken for a slip of the finger: 2 GiB of quaternions."""

_STYLES = ("alpha", "beta", "invariance", "joint")


def parser() -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog="python -m usd_tools.upsample",
        description="Add samples to skeletal animation, along geodesics of an invariant metric. Every source sample "
        "stays as it is, bit for bit. The output is a layer over the source, which it needs; with --flatten it needs "
        "only textures, which stay where they are; a name that ends in .usdz makes a package of all of it.",
    )
    parse.add_argument("input", metavar="IN", type=Path, help="USD file")
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file to write; .usdz packs the source too")
    where = parse.add_mutually_exclusive_group(required=True)
    where.add_argument("--factor", metavar="N", type=whole_number, help="cut every gap between samples into N")
    where.add_argument("--fps", metavar="F", type=typed_rate, help="add samples at F a second")
    where.add_argument(
        "--times",
        metavar="T",
        type=time_codes,
        help="add samples at these time codes: numbers with commas between them, a text file of numbers, or the word "
        "source: where usd_tools.downsample removed them; where the first number is below zero, say '--times=-7.5,-3'",
    )
    parse.add_argument(
        "--retime",
        action="store_true",
        help="with --fps: F time codes a second, so that added samples are whole frames; the motion keeps its speed",
    )
    parse.add_argument(
        "--scheme", choices=list(SCHEMES), help=f"default: the one the metric was made for, else {DEFAULT_SCHEME}"
    )
    parse.add_argument(
        "--metric",
        metavar="M",
        help="stored, identity, a JSON file, or learn: from every other sample, as far as it is sure to predict the "
        "others better than slerp; default: the stored one where there is one, else the identity",
    )
    parse.add_argument("--alpha", metavar="A", type=positive_number, help="second principal moment, for all joints")
    parse.add_argument("--beta", metavar="B", type=positive_number, help="third principal moment, for all joints")
    parse.add_argument("--invariance", choices=INVARIANCES, help="side of the metric, for all joints")
    parse.add_argument(
        "--joint",
        metavar="STYLE",
        type=parse_style,
        action="append",
        default=[],
        help="for joints whose name matches: 'PATTERN:alpha=4,beta=.5,invariance=right'; repeatable, the last wins",
    )
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--dry-run", action="store_true", help="do all but write OUT")
    parse.add_argument("--report", metavar="FILE", type=Path, help="write what was done as JSON")
    parse.add_argument("-v", "--verbose", action="store_true", help="say more, and warn of doubtful steps")
    return parse


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    parse = parser()
    args = parse.parse_args(argv)
    if args.retime and args.fps is None:
        parse.error("--retime needs --fps")
    if args.out is None and not (args.in_place or args.dry_run):
        parse.error("name the output with -o/--out")
    return run(lambda: upsample(args))


@openusd_errors()
def upsample(args: argparse.Namespace) -> int:
    """Do what the arguments say."""
    messages = Messages(print_warning)
    target = Output.of(args, args.input)
    target.check()
    if args.retime and args.in_place:
        raise ToolError("--retime cannot change a file in place; name another file with --out.")
    with usd_warnings(messages):
        stage = open_stage(args.input)
    target.check_layers(stage)
    with usd_warnings(messages), reading(args.input):
        clips = _animated(args.input, select_animations(args.input, find_animations(stage), args.prim), messages)
        if args.times is not None and args.times.codes is None:
            clips = clips_with_source_codes(clips, messages)
        styles = [Style("*", args.alpha, args.beta, args.invariance), *args.joint]
        if styles[0] == Style("*"):
            del styles[0]
        metrics = effective_metrics(args.input, clips, args.metric, args.scheme, styles, messages)
        _check_schemes(args, clips, metrics)
        targets = [_target_codes(args, clip, messages) for clip in clips]
        results = _resample_all(clips, targets, metrics)
        jobs = [Job(*parts) for parts in zip(clips, targets, metrics, results, strict=True)]
        if not args.dry_run:
            _write(args, target, stage, jobs, messages)
        for job in jobs:
            tell(job, args.verbose, messages)
    report = None if args.report is None else _report(args, target, stage, jobs, messages)
    # What follows reads a file that was changed in place anew, so prims may be gone from the stage.
    _tell_file(args, target, stage, jobs, messages)
    if report is not None:
        write_json(args.report, report)
    return 0


def _animated(path: Path, sources: list[AnimationSource], messages: Messages) -> list[SkelClip]:
    """Read the animations, and keep those that move."""
    clips = [read_clip(source) for source in sources]
    for clip in clips:
        for note in clip.notes:
            messages.warn(note)
    animated = [clip for clip in clips if clip.is_animated]
    if not animated:
        counts = (
            f"{clip.path} has {max((len(channel.codes) for channel in clip.channels.values()), default=0)}"
            for clip in clips
        )
        raise ToolError(
            f"{path} has no skeletal animation with two samples or more to go between: {', '.join(counts)}."
        )
    return animated


def _check_schemes(args: argparse.Namespace, clips: Sequence[SkelClip], metrics: Sequence[EffectiveMetric]) -> None:
    """Refuse options about a metric where the scheme, asked for or stored, has none."""
    # A scheme may be stored with a metric, and then be asked for by its name.
    words = _STYLES if args.scheme is None else ("metric", *_STYLES)
    options = [f"--{word}" for word in words if getattr(args, word)]
    for clip, effective in zip(clips, metrics, strict=True):
        if options and not effective.is_used:
            raise ToolError(
                f"{clip.path}: the scheme {effective.metric.scheme} has no metric; leave out {', '.join(options)}, or "
                f"say --scheme {' or '.join(WITH_METRIC)}."
            )


def _target_codes(args: argparse.Namespace, clip: SkelClip, messages: Messages) -> np.ndarray:
    """Time codes of the output's samples."""
    times = np.zeros(0) if args.times is None else codes_for(clip, args.times)
    n_added = {
        "factor": lambda: len(clip.codes) * (args.factor - 1),
        "fps": lambda: (clip.codes[-1] - clip.codes[0]) / clip.codes_per_second * args.fps,
        "times": lambda: len(times),
    }
    option = next(name for name in n_added if getattr(args, name) is not None)
    size = (len(clip.codes) + n_added[option]()) * max(1, clip.skeleton.n_joints)
    if size > MAX_ROTATIONS:
        raise ToolError(f"--{option} would make {size:.3g} rotations of {clip.path}; ask for fewer.")
    if option == "factor":
        return subdivided(clip, args.factor)
    if option == "fps":
        if args.fps < 0.999 * clip.samples_per_second():
            messages.warn(
                f"{clip.path} has {clip.samples_per_second():g} samples a second, more than --fps {args.fps:g}; "
                "samples are only ever added."
            )
        return at_rate(clip, args.fps)
    first, last = clip.codes[0], clip.codes[-1]
    outside = times[(times < first) | (times > last)]
    if len(outside):
        raise ToolError(f"--times {outside[0]:g} is outside {clip.path}, which goes from {first:g} to {last:g}.")
    return with_codes(clip, times)


def _resample_all(
    clips: Sequence[SkelClip], targets: Sequence[np.ndarray], metrics: Sequence[EffectiveMetric]
) -> list[Resampled]:
    work = [len(codes) * max(1, len(clip.joints)) for clip, codes in zip(clips, targets, strict=True)]
    results = []
    with Progress(sum(work), "Interpolating") as progress:
        for clip, codes, effective, amount in zip(clips, targets, metrics, work, strict=True):

            def advance(share: float, amount: int = amount) -> None:
                progress.advance(share * amount)

            results.append(resample(clip, codes, effective.metric.scheme, effective.metric, advance))
    return results


def _tell_file(
    args: argparse.Namespace, target: Output, stage: Usd.Stage, jobs: Sequence[Job], messages: Messages
) -> None:
    if args.dry_run:
        print("Nothing is written: this is a dry run.")
        return
    old_rate, root = stage.GetTimeCodesPerSecond(), stage.GetRootLayer()
    rate = args.fps if args.retime else old_rate
    codes = np.unique(np.concatenate([job.codes for job in jobs])) * (rate / old_rate)
    authored = root.framesPerSecond if root.HasFramesPerSecond() and not args.retime else None
    print(*filter(None, [output.written(target.path, rate), output.better_rate(codes, rate, authored)]))
    if args.flatten:
        print(f"{standing(target.path, messages)}.")


def _settings(args: argparse.Namespace) -> dict[str, Any]:
    """Arguments that say what was done, as plain values without paths of this machine."""
    settings: dict[str, Any] = {
        "factor": args.factor,
        "fps": args.fps,
        "times": None if args.times is None else args.times.text,
        "retime": args.retime or None,
        "scheme": args.scheme,
        "metric": None if args.metric is None else Path(args.metric).name,
        "alpha": args.alpha,
        "beta": args.beta,
        "invariance": args.invariance,
        "joint": " ".join(map(str, args.joint)) or None,
        "prim": " ".join(args.prim) or None,
    }
    return {name: value for name, value in settings.items() if value is not None}


def _write(args: argparse.Namespace, target: Output, stage: Usd.Stage, jobs: Sequence[Job], messages: Messages) -> None:
    override = target.layer(stage, "usd_tools.upsample", _settings(args), messages, args.fps if args.retime else None)
    for job in jobs:
        metric = job.effective.metric if job.clip.joints else None
        override.write_animation(job.clip.source, job.result.channels, job.clip.missing, metric, messages)
    target.save(override)


def _report(
    args: argparse.Namespace, target: Output, stage: Usd.Stage, jobs: Sequence[Job], messages: Messages
) -> dict[str, Any]:
    """Tell what was done, as plain values."""
    return {
        "tool": "usd_tools.upsample",
        "version": __version__,
        "source": args.input.name,
        "output": None if args.dry_run else target.path.name,
        "settings": _settings(args),
        "time_codes_per_second": args.fps if args.retime else stage.GetTimeCodesPerSecond(),
        "animations": [described(job) for job in jobs],
        "warnings": messages.warnings,
    }


if __name__ == "__main__":
    sys.exit(main())
