"""Describe a stage: its skeletons, its skeletal animations, and what may go wrong with them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from geomstats_anim.names import GAP
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.text import counted, short_names
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import open_stage, stage_path
from usd_tools.inspection.result import InspectResult
from usd_tools.metrics import explain as metric_meaning
from usd_tools.metrics.attributes import read_source_codes, summary
from usd_tools.metrics.explain import joint_meanings
from usd_tools.metrics.validation import validate_metric
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.faults import ClipFault, find_clip_faults
from usd_tools.skel.find import AnimationSource, find_animations
from usd_tools.skel.joint_names import names_note, read_names
from usd_tools.skel.loops import find_loop
from usd_tools.skel.packed import packed_bytes
from usd_tools.skel.rotation_checks import (
    count_not_unit,
    count_sign_flips,
    largest_step,
    rotation_steps,
    wide_steps,
)
from usd_tools.skel.skeleton_checks import count_off_bind, range_note, rest_size, size_note
from usd_tools.skel.stored_metric import stored_metric

_WIDE_STEPS = 20
"""Turns that are warned of one by one."""


@openusd_errors()
def inspect_file(path: Path, warn: Callable[[str], None] | None, finds_contacts: bool = False) -> InspectResult:
    """Describe a file; see `usd_tools.inspect.inspect`, and `describe`."""
    messages = Messages(warn)
    with usd_warnings(messages), reading(path):
        result = describe(open_stage(path), path, messages, finds_contacts)
    return replace(result, warnings=tuple(messages.warnings))  # OpenUSD's come last


@openusd_errors()
def inspect_open_stage(stage: Usd.Stage, warn: Callable[[str], None] | None) -> InspectResult:
    """Describe an open stage; see `usd_tools.inspect.inspect_stage`."""
    messages, path = Messages(warn), stage_path(stage)
    with usd_warnings(messages), reading(path):
        result = describe(stage, path, messages)
    return replace(result, warnings=tuple(messages.warnings))


def describe(stage: Usd.Stage, path: Path, messages: Messages, finds_contacts: bool = False) -> InspectResult:
    """Describe what is on a stage.

    Parameters
    ----------
    stage : Usd.Stage
    path : Path
        File that it was opened from.
    messages : Messages
        Told what to beware of.
    finds_contacts : bool
        Whether to find what is planted on the ground, for which compiled code is loaded.
        Optional, default: False.

    Returns
    -------
    result : InspectResult
    """
    root = stage.GetRootLayer()
    sources = find_animations(stage)
    skeletons = tuple(
        _describe_skeleton(prim, sources, messages)
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdSkel.Skeleton)
    )
    animations = tuple(_describe_animation(source, messages, finds_contacts) for source in sources)
    return InspectResult(
        file=path.name,
        layers=tuple(_names_of_layers(stage)),
        default_prim=root.defaultPrim or None,
        up_axis=str(UsdGeom.GetStageUpAxis(stage)),
        meters_per_unit=UsdGeom.GetStageMetersPerUnit(stage),
        time_codes_per_second=stage.GetTimeCodesPerSecond(),
        frames_per_second=stage.GetFramesPerSecond() if root.HasFramesPerSecond() else None,
        start_time_code=stage.GetStartTimeCode() if root.HasStartTimeCode() else None,
        end_time_code=stage.GetEndTimeCode() if root.HasEndTimeCode() else None,
        skeletons=skeletons,
        animations=animations,
        warnings=tuple(messages.warnings),
    )


def _names_of_layers(stage: Usd.Stage) -> list[str]:
    """Name the layers of a stage: its root, then the others by name, for OpenUSD lists them in any order."""
    others = [layer for layer in stage.GetUsedLayers() if layer != stage.GetRootLayer() and not layer.anonymous]
    root = [] if stage.GetRootLayer().anonymous else [stage.GetRootLayer().GetDisplayName()]
    return root + sorted(layer.GetDisplayName() for layer in others)


def _describe_skeleton(prim: Usd.Prim, sources: list[AnimationSource], messages: Messages) -> dict[str, Any]:
    driven_by = next((source.path for source in sources if prim in source.skeletons), None)
    binding = prim.GetRelationship("skel:animationSource")
    if driven_by is None and binding and binding.GetTargets():
        reason = (
            "its target is not an animation on this stage"
            if prim.HasAPI(UsdSkel.BindingAPI)
            else "SkelBindingAPI is not applied, so USD ignores it"
        )
        messages.warn(f"{prim.GetPath()} has skel:animationSource {binding.GetTargets()[0]}, but {reason}.")
    n_joints = _count_joints(prim, messages)
    for note in () if n_joints is None else (names_note(prim), size_note(prim)):
        if note is not None:
            messages.warn(note)
    return {
        "prim": str(prim.GetPath()),
        "joints": n_joints,
        "animation": driven_by,
        "instance": prim.IsInstanceProxy(),
        "size": None if n_joints is None else rest_size(prim),
        "joints_off_bind_pose": None if n_joints is None else count_off_bind(prim),
    }


def _count_joints(skeleton: Usd.Prim, messages: Messages) -> int | None:
    try:
        return len(read_names(skeleton, "joints"))
    except ToolError as error:
        messages.warn(str(error))
        return None


def _describe_animation(source: AnimationSource, messages: Messages, finds_contacts: bool) -> dict[str, Any]:
    described: dict[str, Any] = {
        "prim": source.path,
        "instances": [str(prim.GetPath()) for prim in source.prims[1:]],
        "skeletons": [str(prim.GetPath()) for prim in source.skeletons],
    }
    try:
        clip = read_clip(source, fills_gaps=True)
    except ToolError as error:
        messages.warn(str(error))
        return {**described, "error": str(error)}
    for note in (*clip.notes, *filter(None, [range_note(clip)])):
        messages.warn(note)
    degrees = rotation_steps(clip)
    largest, wide = largest_step(clip, degrees), wide_steps(clip, degrees)
    names = short_names(clip.joints)
    for step in wide[:_WIDE_STEPS]:
        turn = step.in_words(names)
        messages.warn(f"{clip.path}: {turn}; a file cannot store which way a turn beyond 180 degrees went.")
    if len(wide) > _WIDE_STEPS:
        messages.warn(f"{clip.path}: {len(wide) - _WIDE_STEPS} more turns are as wide; --json lists them.")
    rotations = clip.channels.get("rotations")
    found = [*find_clip_faults(clip, degrees), *_find_op_faults(clip)]
    faults = [fault.as_dict(names.get(fault.joint, fault.joint)) for fault in found]
    gaps = [fault for fault in faults if fault["kind"] == GAP]
    if gaps:
        first = min(fault["start"] for fault in gaps)
        messages.warn(
            f"{clip.path} has {counted(len(gaps), 'gap')} from time code {first:g} on, which other commands refuse; "
            "usd_tools.repair fills them in."
        )
    return {
        **described,
        "error": None,
        "joints": len(clip.joints),
        "rig": _rig(clip),
        "still_joints": _count_still(clip),
        "blend_shapes": len(read_names(source.prim, "blendShapes")),
        "meters_per_unit": clip.world_scale,
        "channels": {name: _describe_channel(channel) for name, channel in clip.channels.items()},
        **_describe_times(clip),
        "samples_of_source": _count_source_samples(source, messages),
        "packed_bytes": packed_bytes(source.prim),
        "stepped_pairs": int(clip.steps.sum()),
        "largest_step": None if largest is None else asdict(largest),
        "largest_step_joint": None if largest is None else names[largest.joint],
        "wide_steps": [asdict(step) for step in wide],
        "loop": _describe_loop(clip, names),
        "contacts": _describe_contacts(clip) if finds_contacts else None,
        "faults": faults,
        "sign_flips": 0 if rotations is None else count_sign_flips(rotations),
        "not_unit_quaternions": 0 if rotations is None else count_not_unit(rotations),
        "metric": _describe_metric(source, messages),
    }


def _find_op_faults(clip: SkelClip) -> list[ClipFault]:
    """Find the faults of the transforms that move a character; most have none, and are not waited for."""
    prims = [
        prim
        for skeleton in clip.source.skeletons
        for prim in map(skeleton.GetStage().GetPrimAtPath, skeleton.GetPath().GetPrefixes())
    ]
    if not any(UsdGeom.Xformable(prim).TransformMightBeTimeVarying() for prim in prims if prim.IsA(UsdGeom.Xformable)):
        return []
    from usd_tools.skel.xform_faults import find_op_faults
    from usd_tools.skel.xforms import find_xform_ops

    ops = find_xform_ops(clip.source, fills_gaps=True).ops
    return [fault for op in ops for fault in find_op_faults(op, clip)]


def _rig(clip: SkelClip) -> str:
    """Return what is the same for animations of the same joints, in whatever order: 8 hexadecimal digits."""
    return hashlib.sha256("\n".join(sorted(clip.joints)).encode()).hexdigest()[:8]


def _describe_channel(channel: Channel) -> dict[str, Any]:
    return {
        "samples": len(channel.codes),
        "value_blocks": int(channel.blocked.sum()),
        "held_gaps": int(channel.holds.all(axis=-1).sum()),
        "from": channel.source or None,
    }


def _describe_times(clip: SkelClip) -> dict[str, Any]:
    codes = clip.codes
    if not len(codes):
        return dict.fromkeys(("samples", "codes", "seconds", "samples_per_second", "evenly_spaced"))
    gaps = np.diff(codes)[~clip.steps]
    return {
        "samples": len(codes),
        "codes": [float(codes[0]), float(codes[-1])],
        "seconds": [float(code / clip.codes_per_second) for code in codes[[0, -1]]],
        "samples_per_second": clip.samples_per_second(),
        "evenly_spaced": bool(np.allclose(gaps, gaps[0], rtol=1e-4)),
    }


def _describe_loop(clip: SkelClip, names: Mapping[str, str]) -> dict[str, Any] | None:
    """Describe what is nearly a loop; None for what is none."""
    loop = find_loop(clip)
    if loop is None or not loop.is_near:
        return None
    return {"closed": loop.closed, "misses_degrees": loop.degrees, "joint": loop.joint, "joint_name": names[loop.joint]}


def _describe_contacts(clip: SkelClip) -> dict[str, Any] | None:
    """Describe what is planted on the ground; None where nothing is."""
    from usd_tools.characters.planted import find_clip_contacts

    found = find_clip_contacts(clip)
    joints = sorted({int(joint) for contacts in found for joint in contacts.joints})
    if not joints:
        return None
    seconds = np.array([contacts.times[-1] - contacts.times[0] for contacts in found])
    share = float(np.average([contacts.share for contacts in found], weights=seconds))
    return {"joints": [clip.skeleton.joints[joint] for joint in joints], "share": share}


def _count_source_samples(source: AnimationSource, messages: Messages) -> int | None:
    try:
        codes = read_source_codes(source.prim)
    except ToolError as error:
        messages.warn(str(error))
        return None
    return None if codes is None else len(codes)


def _count_still(clip: SkelClip) -> int:
    """Count the joints that never move, bit for bit."""
    still = np.ones(len(clip.joints), dtype=bool)
    for name in ("rotations", "translations", "scales"):
        if name in clip.channels:
            still &= clip.channels[name].holds.all(axis=0)
    return int(still.sum())


def _describe_metric(source: AnimationSource, messages: Messages) -> dict[str, Any] | None:
    for problem in validate_metric(source.prim):
        messages.warn(problem)
    try:
        metric = stored_metric(source)
    except ToolError as error:
        messages.warn(str(error))
        return {"error": str(error)}
    if metric is None:
        return None
    return {
        "error": None,
        "summary": summary(metric),
        "scheme": metric.scheme,
        "joints": len(metric.joints),
        "quality": metric.quality,
        "provenance": dict(metric.provenance),
        "by_joint": [metric_meaning.as_dict(meaning) for meaning in joint_meanings(metric)],
    }
