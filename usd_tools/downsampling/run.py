"""The work of `downsample`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import ProgressCallback, SearchProgress
from usd_tools.downsampling.options import DownsampleOptions
from usd_tools.downsampling.reduce import DownsampledClip, downsample_clip, verified
from usd_tools.downsampling.result import TOOL, DownsampledAnimation, DownsampleResult
from usd_tools.downsampling.summary import PICTURES, describe, draw, twist_sentence
from usd_tools.downsampling.thinning import write_sparse
from usd_tools.files.paths import check_output, same_file
from usd_tools.skel.clip import read_clips
from usd_tools.skel.find import AnimationSource, select_animations
from usd_tools.skel.output import Output
from usd_tools.skel.replacing import Work, replace_in_file, replace_on_stage
from usd_tools.skel.writer import AnimationLayer


def downsample_file(
    source: Path,
    out: Path | None,
    options: DownsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> DownsampleResult:
    """Downsample the animations of a file; see `usd_tools.downsample.downsample`."""
    work = _work(options)._replace(
        check=lambda target: _check_picture(options, target), finish=lambda clips: _draw(options, clips)
    )
    return replace_in_file(source, out, options, work, progress, warn)


def downsample_open_stage(
    stage: Usd.Stage,
    options: DownsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> DownsampleResult:
    """Downsample the animations of an open stage; see `usd_tools.downsample.downsample_stage`."""
    options = replace(options, picture=None)
    return replace_on_stage(stage, options, _work(options), progress, warn)


def _work(options: DownsampleOptions) -> Work[DownsampledClip]:
    return Work(
        TOOL,
        DownsampleResult,
        select=lambda path, everyone: select_animations(path, everyone, options.prim),
        clips=lambda path, sources, messages, progress, hides_variants: _downsampled(
            path, sources, options, messages, progress, hides_variants
        ),
        source=lambda downsampled: downsampled.clip.source,
        write=_write,
        verify=lambda stage, path, clips: verified(stage, path, clips, options),
        describe=lambda clips, messages: _described(clips, options, messages),
    )


def _draw(options: DownsampleOptions, clips: Sequence[DownsampledClip]) -> None:
    if options.picture is not None:
        draw(clips, options.picture)


def _check_picture(options: DownsampleOptions, target: Output) -> None:
    picture = options.picture
    if picture is None:
        return
    if picture.suffix not in PICTURES:
        raise ToolError(f"--picture {picture}: the name must end in {', '.join(PICTURES)}.")
    check_output(picture, "--picture")
    others = [path for path in (target.source, target.path, options.report) if path is not None]
    if same_file(picture, others) or picture.resolve() in [other.resolve() for other in others]:
        raise ToolError(f"--picture {picture} is the input or another output; choose another name.")


def _downsampled(
    path: Path,
    sources: Sequence[AnimationSource],
    options: DownsampleOptions,
    messages: Messages,
    progress: ProgressCallback | None,
    hides_variants: bool,
) -> list[DownsampledClip]:
    found = []
    for clip in read_clips(sources, messages, hides_variants):
        found.append(downsample_clip(path, clip, options, messages, SearchProgress(progress, None)))
    clips = [each for each in found if each is not None]
    if not clips:
        raise ToolError(f"{path} has no skeletal animation with at least two samples.")
    if options.picture is not None and not any(each.clip.joints for each in clips):
        raise ToolError(f"--picture draws the motion of joints, but {path} has blend shapes only; leave it out.")
    return clips


def _write(layer: AnimationLayer, clips: Sequence[DownsampledClip], _as_text: bool, messages: Messages) -> None:
    for each in clips:
        write_sparse(layer, each.clip, each.sparse, each.metric if each.clip.joints else None, messages, each.contacts)


def _described(
    clips: Sequence[DownsampledClip], options: DownsampleOptions, messages: Messages
) -> tuple[DownsampledAnimation, ...]:
    animations = tuple(describe(each, options.weights_tolerance) for each in clips)
    for animation in animations:
        if options.tolerance is None or options.measured != "ends":
            continue
        sentence = twist_sentence(animation, options.tolerance)
        if sentence is not None:
            messages.warn(sentence)
    return animations
