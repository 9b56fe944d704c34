"""The work of `unpack`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import ProgressCallback
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import describe_dependencies, open_stage, stage_path
from usd_tools.packing.options import UnpackOptions
from usd_tools.packing.result import UNPACK, UnpackedAnimation, UnpackResult
from usd_tools.skel.clip import SkelClip, read_clips
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.output import Output
from usd_tools.skel.packed import is_packed
from usd_tools.skel.writer import AnimationLayer


@openusd_errors()
def unpack_file(
    source: Path,
    out: Path | None,
    options: UnpackOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UnpackResult:
    """Unpack the animations of a file; see `usd_tools.unpack.unpack`."""
    if out is None and not options.in_place:
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    with usd_warnings(messages):
        stage = open_stage(source)
    target.check_layers(stage)
    size_before = source.stat().st_size
    with usd_warnings(messages), reading(source):
        everyone = find_animations(stage)
        sources = _packed(source, everyone, options)
        target = target.without_source(sources)
        clips = _unpacked(sources, messages, not target.copy)
        layer = target.layer(stage, UNPACK, options.settings(), messages)
        layer.replace_samples([clip.source for clip in clips], everyone)
        animations = _write(layer, clips, messages)
        target.save(layer)
    result = UnpackResult(
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
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def unpack_open_stage(stage: Usd.Stage, options: UnpackOptions, warn: Callable[[str], None] | None) -> UnpackResult:
    """Unpack the animations of an open stage; see `usd_tools.unpack.unpack_stage`."""
    messages, path, layer = Messages(warn), stage_path(stage), EditTargetLayer(stage)
    with usd_warnings(messages), reading(path):
        clips = _unpacked(_packed(path, find_animations(stage), options), messages)
        with layer.editing():
            animations = _write(layer, clips, messages)
    return UnpackResult(
        path.name, None, layer.name, options.settings(), None, None, animations, tuple(messages.warnings)
    )


def _packed(path: Path, everyone: list[AnimationSource], options: UnpackOptions) -> list[AnimationSource]:
    sources = [source for source in select_animations(path, everyone, options.prim) if is_packed(source.prim)]
    if not sources:
        raise ToolError(f"{path} has no packed animation; usd_tools.pack makes files that have.")
    return sources


def _unpacked(sources: Sequence[AnimationSource], messages: Messages, hides_variants: bool = True) -> list[SkelClip]:
    clips = read_clips(sources, messages, hides_variants)
    for clip in clips:
        for note in clip.notes:
            messages.warn(note)
    return clips


def _write(layer: AnimationLayer, clips: Sequence[SkelClip], messages: Messages) -> tuple[UnpackedAnimation, ...]:
    animations = []
    for clip in clips:
        sampled = {name: channel for name, channel in clip.channels.items() if len(channel.codes)}
        constant = {name: channel.default for name, channel in clip.channels.items() if name not in sampled}
        layer.write_animation(clip.source, sampled, {**clip.missing, **constant}, None, messages)
        codes = (float(clip.codes[0]), float(clip.codes[-1]))
        animations.append(UnpackedAnimation(clip.path, len(clip.codes), len(clip.joints), codes))
    return tuple(animations)
