"""The work of `from_bvh`, into a file or onto an open stage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from pxr import Usd

from geomstats_anim import Skeleton
from geomstats_anim.rotations import IDENTITY
from usd_tools.bvh.options import FromBvhOptions
from usd_tools.bvh.reader import Bvh, read_bvh
from usd_tools.bvh.result import TOOL, FromBvhResult
from usd_tools.bvh.stored_channels import store_channels
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors
from usd_tools.files.paths import check_usd_output, same_file
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.joint_names import joint_paths, unique
from usd_tools.skel.new_file import SKELETON, Character, Units, add_character, new_stage
from usd_tools.skel.output import check_report
from usd_tools.skel.writer import made_by, save_layer


@openusd_errors()
def from_bvh_file(
    source: Path,
    out: Path,
    options: FromBvhOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> FromBvhResult:
    """Convert a BVH file to a USD file; see `usd_tools.from_bvh.from_bvh`."""
    check_usd_output(out, options.usd_format)
    check_report(options.report, source, out)
    if same_file(out, [source]):
        raise ToolError(f"--out {out} is the input itself; choose another name.")
    messages, steps = Messages(warn), Progress(progress, 3, "Reading")
    character, channels = _read_character(source, options, messages)
    steps.advance(1, "Converting")
    stage = new_stage(character)
    store_channels(stage.GetPrimAtPath(SKELETON), channels)
    layer = stage.GetRootLayer()
    layer.customLayerData = made_by(TOOL, {"source": source.name} | options.settings())
    steps.advance(1, "Writing")
    save_layer(layer, out, options.usd_format)
    steps.advance(1)
    result = _result(source, out, stage.GetDefaultPrim(), character, messages)
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def from_bvh_open_stage(
    source: Path,
    stage: Usd.Stage,
    options: FromBvhOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> FromBvhResult:
    """Add the character of a BVH file to an open stage; see `usd_tools.from_bvh.from_bvh_stage`."""
    messages, steps = Messages(warn), Progress(progress, 2, "Reading")
    layer = EditTargetLayer(stage)
    character, channels = _read_character(source, options, messages)
    steps.advance(1, "Converting")
    with layer.editing():
        root = add_character(stage, character, layer)
        store_channels(stage.GetPrimAtPath(root.GetPath().AppendChild(SKELETON.name)), channels)
    steps.advance(1)
    return _result(source, None, root, character, messages)


def _read_character(
    source: Path, options: FromBvhOptions, messages: Messages
) -> tuple[Character, tuple[tuple[str, ...], ...]]:
    """Read a character, and the channels of each of its joints."""
    bvh = read_bvh(source, options.fps, messages.warn)
    first = 1 if options.skip_first else 0
    if len(bvh.rotations) == first:
        raise ToolError(f"{source} has one frame, and --skip-first leaves it out; call it without --skip-first.")
    character = Character(
        _skeleton(bvh),
        unique(bvh.names),
        bvh.rotations[first:],
        bvh.translations[first:],
        Units(options.scale, options.up, bvh.rate),
    )
    return character, bvh.channels


def _skeleton(bvh: Bvh) -> Skeleton:
    return Skeleton(
        tuple(joint_paths(bvh.names, bvh.parents.tolist())),
        bvh.parents,
        bvh.offsets,
        np.tile(IDENTITY, (len(bvh.names), 1)),
        bvh.bone_ends,
    )


def _result(source: Path, path: Path | None, root: Usd.Prim, character: Character, messages: Messages) -> FromBvhResult:
    return FromBvhResult(
        source.name,
        path,
        str(root.GetPath()),
        character.skeleton.n_joints,
        len(character.rotations),
        character.units.frames_per_second,
        character.height_metres(),
        tuple(messages.warnings),
    )
