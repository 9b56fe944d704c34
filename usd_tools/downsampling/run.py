"""The work of `downsample`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import ProgressCallback, SearchProgress
from usd_tools.downsampling.options import DownsampleOptions
from usd_tools.downsampling.reduce import DownsampledClip, downsample_clip, verified
from usd_tools.downsampling.result import TOOL, DownsampledAnimation, DownsampleResult
from usd_tools.downsampling.summary import PICTURES, describe, draw, twist_sentence
from usd_tools.downsampling.thinning import write_sparse
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_unheard, usd_warnings
from usd_tools.files.paths import check_output, same_file
from usd_tools.files.stages import describe_dependencies, open_stage, stage_path
from usd_tools.skel.clip import read_clips
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.output import Output
from usd_tools.skel.writer import AnimationLayer


@openusd_errors()
def downsample_file(
    source: Path,
    out: Path | None,
    options: DownsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> DownsampleResult:
    """Downsample the animations of a file; see `usd_tools.downsample.downsample`."""
    if out is None and not options.in_place:
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    _check_picture(options, target)
    with usd_warnings(messages):
        stage = open_stage(source)
    target.check_layers(stage)
    size_before = source.stat().st_size
    with usd_warnings(messages), reading(source):
        everyone = find_animations(stage)
        sources = select_animations(source, everyone, options.prim)
        target = target.without_source(sources)
        clips = _downsampled(source, sources, options, messages, progress, not target.copy)
        if options.picture is not None and not any(each.clip.joints for each in clips):
            raise ToolError(f"--picture draws the motion of joints, but {source} has blend shapes only; leave it out.")
        layer = target.layer(stage, TOOL, options.settings(), messages)
        layer.replace_samples([each.clip.source for each in clips], everyone)
        _write(layer, clips, messages)
        checked: list[DownsampledClip] = []

        def verify(beside: Path) -> None:
            with usd_unheard():  # the source has told what is wrong
                checked.extend(verified(open_stage(beside), target.path, clips, options))

        target.save(layer, verify)
    animations = _described(checked, options, messages)
    result = DownsampleResult(
        source.name,
        target.path,
        target.path.name,
        options.settings(),
        size_before,
        target.path.stat().st_size,
        animations,
        dependencies=describe_dependencies(target.path, messages),
        warnings=tuple(messages.warnings),
    )
    if options.picture is not None:
        draw(checked, options.picture)
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def downsample_open_stage(
    stage: Usd.Stage,
    options: DownsampleOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> DownsampleResult:
    """Downsample the animations of an open stage; see `usd_tools.downsample.downsample_stage`."""
    messages, path, layer = Messages(warn), stage_path(stage), EditTargetLayer(stage)
    with usd_warnings(messages), reading(path):
        sources = select_animations(path, find_animations(stage), options.prim)
        clips = _downsampled(path, sources, options, messages, progress)
        with layer.editing():
            _write(layer, clips, messages)
            checked = verified(stage, path, clips, options)
    animations = _described(checked, options, messages)
    return DownsampleResult(
        path.name, None, layer.name, options.settings(), None, None, animations, tuple(messages.warnings)
    )


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
    hides_variants: bool = True,
) -> list[DownsampledClip]:
    found = []
    for clip in read_clips(sources, messages, hides_variants):
        found.append(downsample_clip(path, clip, options, messages, SearchProgress(progress, None)))
    clips = [each for each in found if each is not None]
    if not clips:
        raise ToolError(f"{path} has no skeletal animation with at least two samples.")
    return clips


def _write(layer: AnimationLayer, clips: Sequence[DownsampledClip], messages: Messages) -> None:
    for each in clips:
        write_sparse(layer, each.clip, each.sparse, each.metric if each.clip.joints else None, messages)


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
