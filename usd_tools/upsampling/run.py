"""The work of `upsample`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import Usd

from usd_tools.console.arguments import SOURCE
from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import ProgressCallback
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import describe_dependencies, open_stage, stage_path
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.skel.frame_rates import rate_like
from usd_tools.skel.output import Output
from usd_tools.skel.rate_advice import between_frames
from usd_tools.skel.resampling import at_rate, subdivided, with_codes
from usd_tools.skel.time_codes import clips_with_source_codes, codes_for
from usd_tools.skel.writer import AnimationLayer
from usd_tools.skel.xforms import cuts_of, find_xform_ops, resample_op
from usd_tools.upsampling.clips import animated_clips, check_schemes, check_size, read_library, with_cuts
from usd_tools.upsampling.contacts import ClipContacts
from usd_tools.upsampling.cycles import Cycles
from usd_tools.upsampling.interpolation import interpolated
from usd_tools.upsampling.metric import choose_metrics
from usd_tools.upsampling.options import CurveOptions, UpsampleOptions
from usd_tools.upsampling.result import UpsampledAnimation, UpsampleResult
from usd_tools.upsampling.summary import UpsampledClip, describe, warnings_of


class Work(NamedTuple):
    """Hold what a verb that leads curves through samples does of its own; the rest is done here.

    Attributes
    ----------
    result : type
        Its result, which names the tool.
    interpolate : callable
        From the path, the stage, the messages and the progress to interpolated animations.
    retime : float or None
        Samples per second that become the output's time codes per second; None keeps those of the source.
    """

    result: type[UpsampleResult]
    interpolate: Callable[[Path, Usd.Stage, Messages, ProgressCallback | None], list[UpsampledClip]]
    retime: float | None = None

    def rate(self, stage: Usd.Stage) -> float:
        """Return the time codes per second of the output, in the digits of the source, so that frames coincide."""
        own = stage.GetTimeCodesPerSecond()
        return own if self.retime is None else rate_like(self.retime, own)


def upsample_file(
    source: Path,
    out: Path | None,
    options: UpsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UpsampleResult:
    """Upsample the animations of a file; see `usd_tools.upsample.upsample`."""
    return work_on_file(source, out, options, _work(options), progress, warn)


def upsample_open_stage(
    stage: Usd.Stage,
    options: UpsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UpsampleResult:
    """Upsample the animations of an open stage; see `usd_tools.upsample.upsample_stage`."""
    return work_on_stage(stage, options, _work(options), progress, warn)


def _work(options: UpsampleOptions) -> Work:
    return Work(
        UpsampleResult,
        lambda path, stage, messages, progress: _upsampled(path, stage, options, messages, progress),
        options.fps if options.retime else None,
    )


@openusd_errors()
def work_on_file(
    source: Path,
    out: Path | None,
    options: CurveOptions,
    work: Work,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UpsampleResult:
    """Interpolate the animations of a file and write the output.

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the file, the options or the output.
    """
    if out is None and not (options.in_place or options.dry_run):
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    if work.retime is not None and options.in_place:
        raise ToolError("--retime cannot change a file in place; name another file with --out.")
    with usd_warnings(messages):
        stage = open_stage(source)
    target.check_layers(stage)
    with usd_warnings(messages), reading(source):
        clips = work.interpolate(source, stage, messages, progress)
        rate = work.rate(stage)
        if not options.dry_run:
            layer = target.layer(
                stage, work.result.tool, options.settings(), messages, None if work.retime is None else rate
            )
            _write(layer, clips, options, messages)
            target.save(layer)
        animations = _described(clips, options, messages, rate / stage.GetTimeCodesPerSecond())
    # A file that was changed in place is read anew below, so prims may be gone from the stage.
    advice, dependencies = "", ""
    if not options.dry_run:
        advice = _advice(stage, clips, rate, work.retime is not None)
        dependencies = f"{describe_dependencies(target.path, messages)}." if options.flatten else ""
    result = work.result(
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
def work_on_stage(
    stage: Usd.Stage,
    options: CurveOptions,
    work: Work,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UpsampleResult:
    """Interpolate the animations of an open stage, and write into the layer of its edit target.

    Raises
    ------
    UsageError
        If it is to be retimed.
    ToolError
        If something is wrong with the stage or the options.
    """
    if work.retime is not None:
        raise UsageError("--retime needs an output file; an open stage keeps its rate")
    messages, path = Messages(warn), stage_path(stage)
    with usd_warnings(messages), reading(path):
        clips = work.interpolate(path, stage, messages, progress)
        animations = _described(clips, options, messages)
        layer = EditTargetLayer(stage)
        if not options.dry_run:
            with layer.editing():
                _write(layer, clips, options, messages)
    return work.result(
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
    clips = animated_clips(path, select_animations(path, find_animations(stage), options.prim), messages)
    if options.times is not None and options.times.text == SOURCE:
        clips = clips_with_source_codes(clips, messages)
    clips = with_cuts(clips, options)
    metrics = choose_metrics(path, clips, options, messages, progress, read_library(options))
    check_schemes(options, clips, metrics)
    cycles = Cycles(clips, messages) if options.loop else None
    whole = cycles.closed if cycles else clips
    targets = [_target_codes(options, clip, messages) for clip in whole]
    contacts = [ClipContacts(clip, options.contact_reach, messages) for clip in whole] if options.contacts else []
    wanted = [each.with_probes(codes) for each, codes in zip(contacts, targets, strict=True)] if contacts else targets
    if cycles is not None:
        targets = [cycles.before_end(k, codes) for k, codes in enumerate(targets)]
        results = cycles.interpolated(wanted if contacts else targets, metrics, progress)
    else:
        results = interpolated(clips, wanted, metrics, progress)
    upsampled = [UpsampledClip(*parts) for parts in zip(clips, targets, metrics, results, strict=True)]
    if contacts:
        upsampled = [each.planted(work) for each, work in zip(contacts, upsampled, strict=True)]
    if options.no_xforms:
        return upsampled
    return [_with_xforms(k, each, cycles, options, messages) for k, each in enumerate(upsampled)]


def _with_xforms(
    k: int, upsampled: UpsampledClip, cycles: Cycles | None, options: UpsampleOptions, messages: Messages
) -> UpsampledClip:
    """Add samples to the transforms that move the character of the clip number k as a whole."""
    found = find_xform_ops(upsampled.clip.source)
    for note in found.notes:
        messages.warn(note)
    clip, codes, scheme = upsampled.clip, upsampled.codes, upsampled.chosen.metric.scheme
    resampled = []
    for op in found.ops:
        cuts = cuts_of(op, clip, options.looks_for_cuts)
        if cycles is None:
            resampled.append(resample_op(op, codes, clip.codes_per_second, scheme, cuts))
        else:
            resampled.append(cycles.resample_op(k, op, codes, scheme, cuts))
    return replace(upsampled, xforms=tuple(zip(found.ops, resampled, strict=True)))


def _target_codes(options: UpsampleOptions, clip: SkelClip, messages: Messages) -> np.ndarray:
    """Return the time codes of the output's samples, on the source's clock."""
    times = np.zeros(0) if options.times is None else codes_for(clip, options.times)
    if options.factor is not None:
        word, n_added = "factor", float(len(clip.codes) * (options.factor - 1))
    elif options.fps is not None:
        word, n_added = "fps", float((clip.codes[-1] - clip.codes[0]) / clip.codes_per_second * options.fps)
    else:
        word, n_added = "times", float(len(times))
    check_size(clip, len(clip.codes) + n_added, word)
    if options.factor is not None:
        return subdivided(clip, options.factor)
    if options.fps is not None:
        if options.fps < 0.9995 * clip.samples_per_second():
            messages.warn(
                f"{clip.path} has {clip.samples_per_second():g} samples per second, more than --fps {options.fps:g}; "
                "upsample only adds samples; usd_tools.resample --fps keeps exactly that rate."
            )
        return at_rate(clip, options.fps)
    first, last = clip.codes[0], clip.codes[-1]
    outside = times[(times < first) | (times > last)]
    if len(outside):
        raise ToolError(f"--times {outside[0]:g} is outside {clip.path}, which runs from {first:g} to {last:g}.")
    return with_codes(clip, times)


def _write(layer: AnimationLayer, clips: Sequence[UpsampledClip], options: CurveOptions, messages: Messages) -> None:
    for each in clips:
        metric = each.metric if each.clip.joints else None
        kept = bool(np.isin(each.clip.codes, each.codes).all())
        layer.write_animation(
            each.clip.source,
            each.result.channels,
            each.clip.missing,
            metric,
            messages,
            keeps_samples=kept,
            euler=options.euler,
        )
        for op, channel in each.xforms:
            layer.write_op(op.attribute, channel)


def _described(
    clips: Sequence[UpsampledClip], options: CurveOptions, messages: Messages, stretch: float = 1.0
) -> tuple[UpsampledAnimation, ...]:
    for each in clips:
        for sentence in warnings_of(each, options.verbose, stretch):
            messages.warn(sentence)
    return tuple(describe(each, stretch) for each in clips)


def _advice(stage: Usd.Stage, clips: Sequence[UpsampledClip], rate: float, retimed: bool) -> str:
    root = stage.GetRootLayer()
    codes = np.unique(np.concatenate([each.codes for each in clips])) * (rate / stage.GetTimeCodesPerSecond())
    authored = root.framesPerSecond if root.HasFramesPerSecond() and not retimed else None
    return between_frames(codes, rate, authored)
