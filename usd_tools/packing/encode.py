"""One animation packed, its errors measured on what will be read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Usd

from geomstats_anim.codec import ExtraChannel, pack
from geomstats_anim.markers import Markers
from geomstats_anim.rotations import Array
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.packing.errors import Errors
from usd_tools.packing.frames import Frames
from usd_tools.packing.options import PackOptions
from usd_tools.packing.transforms import Transforms, ops_to_pack
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.packed import WEIGHTS, PackedMotion
from usd_tools.skel.skin import skin_markers
from usd_tools.skel.unpacked import unpacked_channels
from usd_tools.skel.xforms import XformOp

_ROUNDING = 1e-2
"""Share of a tolerance that is left to the rounding of what is read, at most."""

_ROUNDING_METRES = 2e-6

_SCALES = 1e-3
"""Tolerance of scales, about what half precision rounds."""

_ATTEMPTS = 6


@dataclass(frozen=True, eq=False)
class PackedClip:
    """An animation, packed.

    Parameters
    ----------
    clip : SkelClip
        The source.
    frames : Frames
        What is packed.
    ops : sequence of XformOp
        Transforms among it.
    preview : dict of str to Channel
        Samples of the packed attributes and transforms that stay for viewers.
    stream : bytes
    markers : Markers
        What the tolerance is about.
    errors : Errors
    path : str
        Path of the SkelAnimation.
    skeleton_paths : tuple of str
        Paths of the Skeletons that it drives; prims are gone when what is written changes the composition.
    """

    clip: SkelClip
    frames: Frames
    ops: Sequence[XformOp]
    preview: dict[str, Channel]
    stream: bytes
    markers: Markers
    errors: Errors
    path: str
    skeleton_paths: tuple[str, ...]


def pack_clip(
    clip: SkelClip, options: PackOptions, messages: Messages, progress: ProgressCallback | None
) -> PackedClip | None:
    """Pack an animation.

    Parameters
    ----------
    clip : SkelClip
    options : PackOptions
    messages : Messages
        Told what a user should know.
    progress : callable or None

    Returns
    -------
    packed : PackedClip or None
        None if there is no motion.

    Raises
    ------
    ToolError
        If the options do not fit the animation.
    """
    for note in clip.notes:
        messages.warn(note)
    if not clip.is_animated:
        return None
    if clip.joints and not clip.source.rig:
        raise ToolError(
            f"{clip.path} has no skeleton, so --tolerance cannot be measured; bind it to its skeleton, and pack then."
        )
    ops = [] if options.no_xforms else ops_to_pack(clip, messages)
    frames = Frames.of(clip, ops)
    transforms = Transforms(frames, ops)
    preview = frames.preview(options.preview)
    markers, skin = _markers(clip, frames, options)
    margin = min(_ROUNDING_METRES, _ROUNDING * options.metres)
    tolerance, scales = options.metres - margin, _SCALES
    for _ in range(_ATTEMPTS):
        moved = transforms.channels(transforms.share * tolerance, markers)
        joints = (1.0 - transforms.share) * tolerance
        stream = _packed(frames, options, joints, scales, skin, moved, progress)
        channels, columns = _read_back(frames, preview, stream)
        errors = Errors.of(frames, channels, markers, transforms.placements(columns) if ops else None)
        over = _over(errors, options)
        if over <= 1.0:
            skeletons = tuple(str(prim.GetPath()) for prim in clip.source.skeletons)
            return PackedClip(clip, frames, ops, preview, stream, markers, errors, clip.path, skeletons)
        tolerance, scales = tolerance * (1.0 - 1e-4) / over, 0.5 * scales
    raise ToolError(
        f"{clip.path} cannot be packed within {options.tolerance:g} cm, but within {100.0 * errors.largest:.3g} cm; "
        "use a larger --tolerance."
    )


def _markers(clip: SkelClip, frames: Frames, options: PackOptions) -> tuple[Markers, Markers | None]:
    """Return all that is measured, and the skin among it."""
    shell = Markers.of_shell(frames.animation, options.shell_metres)
    if options.measure != "skin" or not clip.joints:
        return shell, None
    skin = skin_markers(clip)
    if not skin.n_markers:
        raise ToolError(f"{clip.path} moves no skinned mesh, so --measure skin cannot be used; use --measure shell.")
    return shell.joined(skin), skin


def _packed(
    frames: Frames,
    options: PackOptions,
    tolerance: float,
    scales: float,
    skin: Markers | None,
    moved: Mapping[str, ExtraChannel],
    progress: ProgressCallback | None,
) -> bytes:
    # times are time codes, which come back bit for bit
    animation, weights = replace(frames.animation, times=frames.codes), frames.weights_of(frames.moving)
    channels = dict(moved)
    if weights is not None:
        rounding = float(np.finfo(np.float32).eps * np.abs(weights).max(initial=0.0))
        channels[WEIGHTS] = ExtraChannel(weights, max(options.weights_tolerance - rounding, rounding))
    bar = Progress(progress, animation.n_frames, "Packing")
    done = 0

    def watch(frames_done: int, _: int) -> None:
        nonlocal done
        bar.advance(frames_done - done)
        done = frames_done

    try:
        return pack(
            animation,
            tolerance,
            shell=options.shell_metres,
            markers=skin,
            scale_tolerance=scales,
            channels=channels,
            effort=options.effort,
            segment=None if options.segment is None else options.segment * frames.clip.codes_per_second,
            cuts=frames.cuts,
            progress=watch,
        )
    except ValueError as error:
        raise ToolError(f"{frames.clip.path} cannot be packed with these options: {error}") from error


def _read_back(
    frames: Frames, preview: Mapping[str, Channel], stream: bytes
) -> tuple[dict[str, Channel], dict[str, Array]]:
    """Return the channels that a reader will find, and the columns of transforms."""
    shown = {name: preview[name] for name in frames.moving}
    in_file = replace(frames.clip, channels={**frames.clip.channels, **shown})
    return unpacked_channels(in_file, PackedMotion(stream, frames.codes, True))


def _over(errors: Errors, options: PackOptions) -> float:
    """Return the largest error over its tolerance."""
    weights = 0.0 if errors.weights is None else errors.weights / options.weights_tolerance
    return max(errors.largest / options.metres, weights)


def verified(stage: Usd.Stage, path: Path, clips: Sequence[PackedClip], options: PackOptions) -> list[PackedClip]:
    """Read what was written, and measure what comes out of it.

    Parameters
    ----------
    stage : Usd.Stage
        That shows what was written.
    path : Path
        How to name it.
    clips : sequence of PackedClip
    options : PackOptions

    Returns
    -------
    checked : list of PackedClip
        With the errors that were measured.

    Raises
    ------
    ToolError
        If one of the tolerances is exceeded.
    """
    sources = find_animations(stage)
    checked = []
    for each in clips:
        paths = set(each.skeleton_paths) or {each.path}
        source = next(
            source for source in sources if paths & {source.path, *(str(s.GetPath()) for s in source.skeletons)}
        )
        read = read_clip(source)
        placements = read.placements(each.frames.codes) if each.ops else None
        errors = Errors.of(each.frames, read.channels, each.markers, placements)
        if _over(errors, options) > 1.0:
            raise ToolError(
                f"{path}: {each.path} is unpacked only to within {100.0 * errors.largest:g} cm and weights to within "
                f"{errors.weights or 0.0:g}, but --tolerance is {options.tolerance:g} cm and --weights-tolerance "
                f"{options.weights_tolerance:g}; please report this."
            )
        checked.append(replace(each, errors=errors))
    return checked
