"""The work of `pack`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import ProgressCallback
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_unheard, usd_warnings
from usd_tools.files.paths import extension
from usd_tools.files.stages import describe_dependencies, is_binary, open_stage, stage_path
from usd_tools.packing.encode import PackedClip, pack_clip, verified
from usd_tools.packing.options import PackOptions
from usd_tools.packing.result import PACK, PackedAnimation, PackResult
from usd_tools.skel.clip import read_clips
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.output import Output
from usd_tools.skel.packed import StoredStream
from usd_tools.skel.sizes import clip_bytes_numpy, clip_bytes_usdc
from usd_tools.skel.writer import AnimationLayer


@openusd_errors()
def pack_file(
    source: Path,
    out: Path | None,
    options: PackOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> PackResult:
    """Pack the animations of a file; see `usd_tools.pack.pack`."""
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
        sources = select_animations(source, everyone, options.prim)
        target = target.without_source(sources)
        clips = _packed(source, sources, options, messages, progress, not target.copy)
        layer = target.layer(stage, PACK, options.settings(), messages)
        layer.replace_samples([each.clip.source for each in clips], everyone)
        _write(layer, clips, _is_text(target.path, options), messages)
        checked: list[PackedClip] = []

        def verify(beside: Path) -> None:
            with usd_unheard():  # the source has told what is wrong
                checked.extend(verified(open_stage(beside), target.path, clips, options))

        target.save(layer, verify)
        animations = tuple(map(_described, checked))
    result = PackResult(
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
def pack_open_stage(
    stage: Usd.Stage,
    options: PackOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> PackResult:
    """Pack the animations of an open stage; see `usd_tools.pack.pack_stage`."""
    messages, path, layer = Messages(warn), stage_path(stage), EditTargetLayer(stage)
    with usd_warnings(messages), reading(path):
        sources = select_animations(path, find_animations(stage), options.prim)
        clips = _packed(path, sources, options, messages, progress)
        with layer.editing():
            _write(layer, clips, layer.layer.GetFileFormat().formatId == "usda", messages)
            checked = verified(stage, path, clips, options)
    return PackResult(
        path.name,
        None,
        layer.name,
        options.settings(),
        None,
        None,
        tuple(map(_described, checked)),
        tuple(messages.warnings),
    )


def _packed(
    path: Path,
    sources: Sequence[AnimationSource],
    options: PackOptions,
    messages: Messages,
    progress: ProgressCallback | None,
    hides_variants: bool = True,
) -> list[PackedClip]:
    found = []
    for clip in read_clips(sources, messages, hides_variants):
        found.append(pack_clip(clip, options, messages, progress))
    clips = [each for each in found if each is not None]
    if not clips:
        raise ToolError(f"{path} has no skeletal animation with at least two samples.")
    return clips


def _is_text(path: Path, options: PackOptions) -> bool:
    """Return whether a file that is written is text."""
    if extension(path) == ".usd":
        if options.in_place and not options.flatten:
            return not is_binary(path)
        return options.usd_format == "usda"
    return extension(path) == ".usda"


def _write(layer: AnimationLayer, clips: Sequence[PackedClip], as_text: bool, messages: Messages) -> None:
    for each in clips:
        constant = {
            name: channel.default for name, channel in each.frames.clip.channels.items() if name not in each.preview
        }
        layer.write_animation(
            each.clip.source,
            {name: each.preview[name] for name in each.frames.moving},
            {**each.clip.missing, **constant},
            None,
            messages,
            packed=StoredStream(each.stream, as_text),
        )
        for op in each.ops:
            layer.write_op(op.attribute, each.preview[str(op.attribute.GetPath())])


def _described(packed: PackedClip) -> PackedAnimation:
    codes = {code for channel in packed.preview.values() for code in channel.codes.tolist()}
    return PackedAnimation(
        packed.path,
        packed.skeleton_paths,
        len(packed.frames.codes),
        len(packed.clip.joints),
        (*packed.frames.moving, *packed.frames.xforms),
        tuple(name for name in packed.clip.channels if name not in packed.preview),
        tuple(sorted(codes)),
        len(packed.stream),
        clip_bytes_usdc(packed.clip, None, None),
        clip_bytes_numpy(packed.clip, None),
        packed.errors.as_dict(),
    )
