"""The work of `resample`: curves through all samples, read at the whole frames of a rate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Usd

from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import ProgressCallback
from usd_tools.resampling.antialias import before_resampling, filtered_clip, filtered_op
from usd_tools.resampling.frames import at_frames, nearest_share, whole_frames
from usd_tools.resampling.options import ResampleOptions
from usd_tools.resampling.result import ResampleResult
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.skel.resampling import with_codes
from usd_tools.skel.xforms import XformOp, cuts_of, find_xform_ops, resample_op
from usd_tools.upsampling.clips import animated_clips, check_schemes, check_size, read_library, with_cuts
from usd_tools.upsampling.cycles import Cycles
from usd_tools.upsampling.interpolation import interpolated
from usd_tools.upsampling.metric import ChosenMetric, choose_metrics
from usd_tools.upsampling.run import Work, work_on_file, work_on_stage
from usd_tools.upsampling.summary import UpsampledClip


def resample_file(
    source: Path,
    out: Path | None,
    options: ResampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> ResampleResult:
    """Resample the animations of a file; see `usd_tools.resample.resample`."""
    result = work_on_file(source, out, options, _work(options), progress, warn)
    assert isinstance(result, ResampleResult)
    return result


def resample_open_stage(
    stage: Usd.Stage,
    options: ResampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> ResampleResult:
    """Resample the animations of an open stage; see `usd_tools.resample.resample_stage`."""
    result = work_on_stage(stage, options, _work(options), progress, warn)
    assert isinstance(result, ResampleResult)
    return result


def _work(options: ResampleOptions) -> Work:
    return Work(
        ResampleResult,
        lambda path, stage, messages, progress: _resampled(path, stage, options, messages, progress),
        options.fps if options.retime else None,
    )


def _resampled(
    path: Path,
    stage: Usd.Stage,
    options: ResampleOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> list[UpsampledClip]:
    clips = animated_clips(path, select_animations(path, find_animations(stage), options.prim), messages)
    clips = with_cuts(clips, options)
    metrics = choose_metrics(path, clips, options, messages, progress, read_library(options))
    check_schemes(options, clips, metrics)
    cycles = Cycles(clips, messages) if options.loop else None
    sources = clips if cycles is None else cycles.closed
    frames = [_frames(clip, options, messages) for clip in sources]
    targets = [with_codes(clip, codes, nearest_share(codes)) for clip, codes in zip(sources, frames, strict=True)]

    def smooth(clip: SkelClip) -> SkelClip:
        return filtered_clip(clip, before_resampling(_fps(options))) if options.antialias else clip

    if cycles is None:
        results = interpolated([smooth(clip) for clip in clips], targets, metrics, progress)
    else:
        results = cycles.interpolated(targets, metrics, progress, smooth)
        frames = [cycles.before_end(k, codes) for k, codes in enumerate(frames)]
    found = []
    for k, (clip, codes, chosen, dense) in enumerate(zip(clips, frames, metrics, results, strict=True)):
        channels = {name: at_frames(channel, codes) for name, channel in dense.channels.items()}
        xforms = () if options.no_xforms else _xforms(k, clip, cycles, chosen, options, messages)
        found.append(UpsampledClip(clip, codes, chosen, replace(dense, channels=channels), xforms))
    return found


def _fps(options: ResampleOptions) -> float:
    assert options.fps is not None  # which `check` has seen to
    return options.fps


def _frames(clip: SkelClip, options: ResampleOptions, messages: Messages) -> np.ndarray:
    """Return the time codes of the frames of an animation."""
    fps = _fps(options)
    seconds = float(clip.codes[-1] - clip.codes[0]) / clip.codes_per_second
    check_size(clip, len(clip.codes) + seconds * fps, "fps")
    codes = whole_frames(clip.codes[0], clip.codes[-1], fps, clip.codes_per_second)
    if len(codes) < 2:
        raise ToolError(f"{clip.path} is {seconds:.3g} seconds long, too short for two frames at --fps {fps:g}.")
    if options.antialias and clip.samples_per_second() <= fps:
        messages.warn(
            f"{clip.path} has {clip.samples_per_second():g} samples per second, no more than --fps {fps:g}, so there "
            "is nothing for --antialias to filter."
        )
    return codes


def _xforms(
    k: int, clip: SkelClip, cycles: Cycles | None, chosen: ChosenMetric, options: ResampleOptions, messages: Messages
) -> tuple[tuple[XformOp, Channel], ...]:
    """Resample the transforms that move the character as a whole, over all of their own time."""
    found = find_xform_ops(clip.source)
    for note in found.notes:
        messages.warn(note)
    rate, resampled = clip.codes_per_second, []
    for op in found.ops:
        first, last = op.channel.codes[[0, -1]]
        until = max(last, clip.codes[-1] if cycles is None else cycles.closed[k].codes[-1])
        codes = whole_frames(min(first, clip.codes[0]), until, _fps(options), rate)
        cuts = cuts_of(op, clip, options.looks_for_cuts)
        smooth = filtered_op(op, cuts, rate, before_resampling(_fps(options))) if options.antialias else op
        scheme = chosen.metric.scheme
        if cycles is None:
            dense = resample_op(smooth, codes, rate, scheme, cuts)
        else:
            dense = cycles.resample_op(k, smooth, codes, scheme, cuts)
            codes = cycles.before_end(k, codes)
        resampled.append((op, at_frames(dense, codes)))
    return tuple(resampled)
