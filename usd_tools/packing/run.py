"""The work of `pack`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import ProgressCallback
from usd_tools.packing.encode import PackedClip, pack_clip, verified
from usd_tools.packing.options import PackOptions
from usd_tools.packing.result import PACK, PackedAnimation, PackResult
from usd_tools.skel.clip import read_clips
from usd_tools.skel.find import AnimationSource, select_animations
from usd_tools.skel.packed import StoredStream
from usd_tools.skel.replacing import Work, replace_in_file, replace_on_stage
from usd_tools.skel.sizes import clip_bytes_numpy, clip_bytes_usdc
from usd_tools.skel.writer import AnimationLayer


def pack_file(
    source: Path,
    out: Path | None,
    options: PackOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> PackResult:
    """Pack the animations of a file; see `usd_tools.pack.pack`."""
    return replace_in_file(source, out, options, _work(options), progress, warn)


def pack_open_stage(
    stage: Usd.Stage,
    options: PackOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> PackResult:
    """Pack the animations of an open stage; see `usd_tools.pack.pack_stage`."""
    return replace_on_stage(stage, options, _work(options), progress, warn)


def _work(options: PackOptions) -> Work[PackedClip]:
    return Work(
        PACK,
        PackResult,
        select=lambda path, everyone: select_animations(path, everyone, options.prim),
        clips=lambda path, sources, messages, progress, hides_variants: _packed(
            path, sources, options, messages, progress, hides_variants
        ),
        source=lambda packed: packed.clip.source,
        write=_write,
        verify=lambda stage, path, clips: verified(stage, path, clips, options),
        describe=lambda clips, _: tuple(map(_described, clips)),
    )


def _packed(
    path: Path,
    sources: Sequence[AnimationSource],
    options: PackOptions,
    messages: Messages,
    progress: ProgressCallback | None,
    hides_variants: bool,
) -> list[PackedClip]:
    found = []
    for clip in read_clips(sources, messages, hides_variants):
        found.append(pack_clip(clip, options, messages, progress))
    clips = [each for each in found if each is not None]
    if not clips:
        raise ToolError(f"{path} has no skeletal animation with at least two samples.")
    return clips


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
        tuple(packed.frames.moving),
        tuple(packed.frames.xforms),
        tuple(name for name in packed.clip.channels if name not in packed.preview),
        tuple(sorted(codes)),
        len(packed.stream),
        clip_bytes_usdc(packed.clip, None, None),
        clip_bytes_numpy(packed.clip, None),
        packed.errors.as_dict(),
    )
