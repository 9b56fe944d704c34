"""The work of `upsample`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Usd

from geomstats_anim.names import WITH_METRIC
from usd_tools.console.arguments import SOURCE
from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import describe_dependencies, open_stage, stage_path
from usd_tools.skel.clip import SkelClip, read_clips
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.frame_rates import rate_like
from usd_tools.skel.output import Output
from usd_tools.skel.rate_advice import between_frames
from usd_tools.skel.resampling import at_rate, resample, subdivided, with_codes, without_cuts
from usd_tools.skel.time_codes import clips_with_source_codes, codes_for
from usd_tools.skel.writer import AnimationLayer
from usd_tools.skel.xforms import find_xform_ops, resample_op, usd_values
from usd_tools.upsampling.metric import ChosenMetric, choose_metrics
from usd_tools.upsampling.options import UpsampleOptions
from usd_tools.upsampling.result import TOOL, UpsampledAnimation, UpsampleResult
from usd_tools.upsampling.summary import UpsampledClip, describe, warnings_of

MAX_ROTATIONS = 1 << 27
"""More than these are taken for a slip of the finger: 2 GiB of quaternions."""

_STYLES = ("alpha", "beta", "invariance", "tension", "translation_tension", "joint")


@openusd_errors()
def upsample_file(
    source: Path,
    out: Path | None,
    options: UpsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UpsampleResult:
    """Upsample the animations of a file; see `usd_tools.upsample.upsample`."""
    if out is None and not (options.in_place or options.dry_run):
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    if options.retime and options.in_place:
        raise ToolError("--retime cannot change a file in place; name another file with --out.")
    with usd_warnings(messages):
        stage = open_stage(source)
    target.check_layers(stage)
    with usd_warnings(messages), reading(source):
        clips = _upsampled(source, stage, options, messages, progress)
        if not options.dry_run:
            layer = target.layer(
                stage, TOOL, options.settings(), messages, _rate(stage, options) if options.retime else None
            )
            _write(layer, clips, messages)
            target.save(layer)
        stretch = _rate(stage, options) / stage.GetTimeCodesPerSecond()
        animations = _described(clips, options, messages, stretch)
    # A file that was changed in place is read anew below, so prims may be gone from the stage.
    rate = _rate(stage, options)
    advice, dependencies = "", ""
    if not options.dry_run:
        advice = _advice(stage, clips, rate, options.retime)
        dependencies = f"{describe_dependencies(target.path, messages)}." if options.flatten else ""
    result = UpsampleResult(
        source.name,
        None if options.dry_run else target.path,
        None if options.dry_run else target.path.name,
        options.settings(),
        rate,
        animations,
        tuple(messages.warnings),
        advice,
        dependencies,
    )
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def upsample_open_stage(
    stage: Usd.Stage,
    options: UpsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UpsampleResult:
    """Upsample the animations of an open stage; see `usd_tools.upsample.upsample_stage`."""
    if options.retime:
        raise UsageError("--retime needs an output file; an open stage keeps its rate")
    messages, path = Messages(warn), stage_path(stage)
    with usd_warnings(messages), reading(path):
        clips = _upsampled(path, stage, options, messages, progress)
        animations = _described(clips, options, messages)
        layer = EditTargetLayer(stage)
        if not options.dry_run:
            with layer.editing():
                _write(layer, clips, messages)
    return UpsampleResult(
        path.name,
        None,
        None if options.dry_run else layer.name,
        options.settings(),
        stage.GetTimeCodesPerSecond(),
        animations,
        tuple(messages.warnings),
    )


def _upsampled(
    path: Path,
    stage: Usd.Stage,
    options: UpsampleOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> list[UpsampledClip]:
    clips = _animated(path, select_animations(path, find_animations(stage), options.prim), messages)
    if options.times is not None and options.times.text == SOURCE:
        clips = clips_with_source_codes(clips, messages)
    clips = _with_cuts(clips, options)
    metrics = choose_metrics(path, clips, options, messages, progress)
    _check_schemes(options, clips, metrics)
    targets = [_target_codes(options, clip, messages) for clip in clips]
    work = [len(codes) * max(1, len(clip.joints)) for clip, codes in zip(clips, targets, strict=True)]
    bar = Progress(progress, sum(work), "Interpolating")
    results = []
    for clip, codes, chosen, amount in zip(clips, targets, metrics, work, strict=True):

        def advance(share: float, amount: int = amount) -> None:
            bar.advance(share * amount)

        results.append(resample(clip, codes, chosen.metric.scheme, chosen.metric, advance))
    upsampled = [UpsampledClip(*parts) for parts in zip(clips, targets, metrics, results, strict=True)]
    return upsampled if options.no_xforms else [_with_xforms(each, options, messages) for each in upsampled]


def _with_xforms(upsampled: UpsampledClip, options: UpsampleOptions, messages: Messages) -> UpsampledClip:
    """Add samples to the transforms that move the character as a whole."""
    found = find_xform_ops(upsampled.clip.source)
    for note in found.notes:
        messages.warn(note)
    scheme, look_for_cuts = upsampled.chosen.metric.scheme, options.cut is None and not options.no_cuts
    resampled = [resample_op(op, upsampled.clip, upsampled.codes, scheme, look_for_cuts) for op in found.ops]
    return replace(upsampled, xforms=tuple(zip(found.ops, resampled, strict=True)))


def _animated(path: Path, sources: list[AnimationSource], messages: Messages) -> list[SkelClip]:
    """Read the animations, and keep those that move."""
    clips = read_clips(sources, messages)
    for clip in clips:
        for note in clip.notes:
            messages.warn(note)
    animated = [clip for clip in clips if clip.is_animated]
    if not animated:
        counts = (
            f"{clip.path} has {max((len(channel.codes) for channel in clip.channels.values()), default=0)}"
            for clip in clips
        )
        raise ToolError(f"{path} has no skeletal animation with at least two samples: {', '.join(counts)}.")
    return animated


def _with_cuts(clips: Sequence[SkelClip], options: UpsampleOptions) -> list[SkelClip]:
    """Take the cuts that are asked for, if any are."""
    if options.no_cuts:
        return [without_cuts(clip) for clip in clips]
    if options.cut is None or options.cut.codes is None:
        return list(clips)
    wanted = np.unique(options.cut.codes)
    inside = [wanted[(wanted > clip.codes[0]) & (wanted <= clip.codes[-1])] for clip in clips]
    outside = np.setdiff1d(wanted, np.concatenate(inside))
    if len(outside):
        ranges = ", ".join(f"{clip.path} from {clip.codes[0]:g} to {clip.codes[-1]:g}" for clip in clips)
        raise ToolError(f"--cut {outside[0]:g} is between no two samples; there is {ranges}.")
    after = [np.searchsorted(clip.codes, codes) for clip, codes in zip(clips, inside, strict=True)]
    return [
        replace(clip, given_cuts=np.stack([clip.codes[end - 1], clip.codes[end]], axis=-1))
        for clip, end in zip(clips, after, strict=True)
    ]


def _check_schemes(options: UpsampleOptions, clips: Sequence[SkelClip], metrics: Sequence[ChosenMetric]) -> None:
    """Refuse options about a metric where the scheme, asked for or stored, has none."""
    # A scheme may be stored with a metric, and then be asked for by its name.
    words = _STYLES if options.scheme is None else ("metric", *_STYLES)
    given = [f"--{word.replace('_', '-')}" for word in words if getattr(options, word) not in (None, ())]
    for clip, chosen in zip(clips, metrics, strict=True):
        if given and not chosen.is_used:
            raise ToolError(
                f"{clip.path}: the scheme {chosen.metric.scheme} has no metric; leave out {', '.join(given)}, or use "
                f"--scheme {' or '.join(WITH_METRIC)}."
            )
        if chosen.metric.scheme == "geodesic" and any(style.has_tension for style in options.styles):
            raise ToolError(
                f"{clip.path}: the scheme geodesic has no tension; leave out tensions, or use --scheme geodesic-spline."
            )


def _target_codes(options: UpsampleOptions, clip: SkelClip, messages: Messages) -> np.ndarray:
    """Return the time codes of the output's samples, on the source's clock."""
    times = np.zeros(0) if options.times is None else codes_for(clip, options.times)
    if options.factor is not None:
        word, n_added = "factor", float(len(clip.codes) * (options.factor - 1))
    elif options.fps is not None:
        word, n_added = "fps", float((clip.codes[-1] - clip.codes[0]) / clip.codes_per_second * options.fps)
    else:
        word, n_added = "times", float(len(times))
    size = (len(clip.codes) + n_added) * max(1, clip.skeleton.n_joints)
    if size > MAX_ROTATIONS:
        raise ToolError(f"--{word} would create {size:.3g} rotations for {clip.path}; ask for fewer.")
    if options.factor is not None:
        return subdivided(clip, options.factor)
    if options.fps is not None:
        if options.fps < 0.9995 * clip.samples_per_second():
            messages.warn(
                f"{clip.path} has {clip.samples_per_second():g} samples per second, more than --fps {options.fps:g}; "
                "upsample only adds samples."
            )
        return at_rate(clip, options.fps)
    first, last = clip.codes[0], clip.codes[-1]
    outside = times[(times < first) | (times > last)]
    if len(outside):
        raise ToolError(f"--times {outside[0]:g} is outside {clip.path}, which runs from {first:g} to {last:g}.")
    return with_codes(clip, times)


def _write(layer: AnimationLayer, clips: Sequence[UpsampledClip], messages: Messages) -> None:
    for each in clips:
        metric = each.chosen.metric if each.clip.joints else None
        layer.write_animation(each.clip.source, each.result.channels, each.clip.missing, metric, messages)
        for op, channel in each.xforms:
            layer.write_values(op.attribute, channel, usd_values(op, channel.values[:, 0]))


def _described(
    clips: Sequence[UpsampledClip], options: UpsampleOptions, messages: Messages, stretch: float = 1.0
) -> tuple[UpsampledAnimation, ...]:
    for each in clips:
        for sentence in warnings_of(each, options.verbose, stretch):
            messages.warn(sentence)
    return tuple(describe(each, stretch) for each in clips)


def _rate(stage: Usd.Stage, options: UpsampleOptions) -> float:
    """Return the time codes per second of the output; retimed, in the digits of the source, so that frames coincide."""
    own = stage.GetTimeCodesPerSecond()
    return rate_like(options.fps, own) if options.retime and options.fps is not None else own


def _advice(stage: Usd.Stage, clips: Sequence[UpsampledClip], rate: float, retimed: bool) -> str:
    root = stage.GetRootLayer()
    codes = np.unique(np.concatenate([each.codes for each in clips])) * (rate / stage.GetTimeCodesPerSecond())
    authored = root.framesPerSecond if root.HasFramesPerSecond() and not retimed else None
    return between_frames(codes, rate, authored)
