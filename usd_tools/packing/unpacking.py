"""The work of `unpack`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from pxr import Usd

from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import ProgressCallback
from usd_tools.packing.options import UnpackOptions
from usd_tools.packing.result import UNPACK, UnpackedAnimation, UnpackResult
from usd_tools.skel.clip import SkelClip, read_clips
from usd_tools.skel.find import AnimationSource, select_animations
from usd_tools.skel.packed import is_packed
from usd_tools.skel.replacing import Work, replace_in_file, replace_on_stage
from usd_tools.skel.writer import AnimationLayer


class UnpackedClip(NamedTuple):
    """Hold a clip, and what is told of it: prims may be gone when that is asked for."""

    clip: SkelClip
    animation: UnpackedAnimation


def unpack_file(
    source: Path,
    out: Path | None,
    options: UnpackOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> UnpackResult:
    """Unpack the animations of a file; see `usd_tools.unpack.unpack`."""
    return replace_in_file(source, out, options, _work(options), progress, warn)


def unpack_open_stage(stage: Usd.Stage, options: UnpackOptions, warn: Callable[[str], None] | None) -> UnpackResult:
    """Unpack the animations of an open stage; see `usd_tools.unpack.unpack_stage`."""
    return replace_on_stage(stage, options, _work(options), None, warn)


def _work(options: UnpackOptions) -> Work[UnpackedClip]:
    return Work(
        UNPACK,
        UnpackResult,
        select=lambda path, everyone: _packed(path, everyone, options),
        clips=lambda _path, sources, messages, _progress, hides_variants: _unpacked(sources, messages, hides_variants),
        source=lambda unpacked: unpacked.clip.source,
        write=_write,
        describe=lambda clips, _: tuple(each.animation for each in clips),
    )


def _packed(path: Path, everyone: list[AnimationSource], options: UnpackOptions) -> list[AnimationSource]:
    sources = [source for source in select_animations(path, everyone, options.prim) if is_packed(source.prim)]
    if not sources:
        raise ToolError(f"{path} has no packed animation; usd_tools.pack makes files that have.")
    return sources


def _unpacked(sources: Sequence[AnimationSource], messages: Messages, hides_variants: bool) -> list[UnpackedClip]:
    unpacked = []
    for clip in read_clips(sources, messages, hides_variants):
        for note in clip.notes:
            messages.warn(note)
        codes = (float(clip.codes[0]), float(clip.codes[-1]))
        unpacked.append(UnpackedClip(clip, UnpackedAnimation(clip.path, len(clip.codes), len(clip.joints), codes)))
    return unpacked


def _write(layer: AnimationLayer, clips: Sequence[UnpackedClip], _as_text: bool, messages: Messages) -> None:
    for clip, _ in clips:
        sampled = {name: channel for name, channel in clip.channels.items() if len(channel.codes)}
        constant = {name: channel.default for name, channel in clip.channels.items() if name not in sampled}
        layer.write_animation(clip.source, sampled, {**clip.missing, **constant}, None, messages)
