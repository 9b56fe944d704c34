"""The work of `repair`, on a file or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Usd

from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.console.text import counted, short_names
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import describe_dependencies, open_stage, stage_path
from usd_tools.repairing.options import RepairOptions
from usd_tools.repairing.rebuild import OpRepair, Repair, repair_clip, repair_op
from usd_tools.repairing.result import TOOL, RepairedAnimation, RepairResult
from usd_tools.resampling.antialias import LowPass, filtered_clip, filtered_op
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip, read_clips
from usd_tools.skel.clip_notes import composition_notes, missing_note
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.faults import ClipFault
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.skel.output import Output
from usd_tools.skel.packed import packed_bytes
from usd_tools.skel.writer import AnimationLayer
from usd_tools.skel.xforms import FoundOps, XformOp, cuts_of, find_xform_ops


@dataclass(frozen=True, eq=False)
class RepairedClip:
    """One animation: its repair, those of transform ops, the samples and ops to write, and what was filtered."""

    repair: Repair
    ops: tuple[OpRepair, ...]
    channels: dict[str, Channel]
    xforms: tuple[XformOp, ...]
    smoothed: tuple[str, ...]

    @property
    def faults(self) -> list[ClipFault]:
        """All that was found."""
        return [*self.repair.faults, *(fault for each in self.ops for fault in each.faults)]

    @property
    def left(self) -> list[ClipFault]:
        """Faults that were not rebuilt."""
        return [*self.repair.left, *(fault for each in self.ops for fault in each.left)]


@openusd_errors()
def repair_file(
    source: Path,
    out: Path | None,
    options: RepairOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> RepairResult:
    """Repair the animations of a file; see `usd_tools.repair.repair`."""
    if out is None and not (options.in_place or options.dry_run):
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    with usd_warnings(messages):
        stage = open_stage(source)
    target.check_layers(stage)
    with usd_warnings(messages), reading(source):
        clips = _repaired(source, stage, options, messages, progress)
        animations = tuple(map(_described, clips))
        if not options.dry_run:
            layer = target.layer(stage, TOOL, options.settings(), messages)
            _write(layer, clips, messages)
            target.save(layer)
    written = not options.dry_run
    result = RepairResult(
        source.name,
        target.path if written else None,
        target.path.name if written else None,
        options.settings(),
        animations,
        tuple(messages.warnings),
        f"{describe_dependencies(target.path, messages)}." if written and options.flatten else "",
    )
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def repair_open_stage(
    stage: Usd.Stage,
    options: RepairOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> RepairResult:
    """Repair the animations of an open stage; see `usd_tools.repair.repair_stage`."""
    messages, path = Messages(warn), stage_path(stage)
    with usd_warnings(messages), reading(path):
        clips = _repaired(path, stage, options, messages, progress)
        animations = tuple(map(_described, clips))
        layer = EditTargetLayer(stage)
        if not options.dry_run:
            with layer.editing():
                _write(layer, clips, messages)
    written = None if options.dry_run else layer.name
    return RepairResult(path.name, None, written, options.settings(), animations, tuple(messages.warnings))


def _repaired(
    path: Path, stage: Usd.Stage, options: RepairOptions, messages: Messages, progress: ProgressCallback | None
) -> list[RepairedClip]:
    clips = read_clips(select_animations(path, find_animations(stage), options.prim), messages, fills_gaps=True)
    bar = Progress(progress, len(clips), "Repairing")
    repaired = []
    for clip in clips:
        repaired.append(_repaired_clip(clip, options, messages))
        for note in _notes(repaired[-1]):
            messages.warn(note)
        bar.advance(1.0)
    return repaired


def _repaired_clip(clip: SkelClip, options: RepairOptions, messages: Messages) -> RepairedClip:
    """Repair a clip and its transforms, filter them if that is asked for, and choose what to write."""
    repair = repair_clip(clip, options.max_gap)
    clip, names = repair.clip, list(repair.changed)
    found = FoundOps((), ()) if options.no_xforms else find_xform_ops(clip.source, fills_gaps=True)
    ops = tuple(repair_op(op, clip, options.max_gap) for op in found.ops)
    xforms = [each.op for each in ops if each.faults]
    channels = dict(clip.channels)
    smoothed: list[str] = []
    if options.smooth is not None:
        for note in found.notes:
            messages.warn(note)
        low_pass = _low_pass(clip, options.smooth)
        channels = dict(filtered_clip(clip, low_pass).channels)
        smoothed = [name for name in channels if not np.array_equal(channels[name].values, clip.channels[name].values)]
        xforms = [filtered_op(each.op, cuts_of(each.op, clip, True), clip.codes_per_second, low_pass) for each in ops]
        names = [name for name in channels if name in names or name in smoothed]
        smoothed += [str(op.attribute.GetPath()) for op in xforms]
    if names and packed_bytes(clip.source.prim) is not None:  # which goes where samples are written
        names = [name for name, channel in channels.items() if len(channel.codes)]
    written = {name: repair.with_gaps(channels[name]) for name in names}
    repaired = RepairedClip(repair, ops, written, tuple(xforms), tuple(smoothed))
    if repaired.left:
        longest = max(each.samples for each in repaired.left)
        messages.warn(
            f"{clip.path}: {counted(len(repaired.left), 'fault')} of up to {longest} samples left as they are; "
            "--max-gap rebuilds longer ones."
        )
    return repaired


def _low_pass(clip: SkelClip, cutoff: float) -> LowPass:
    """Return the filter for `--smooth`, which leaves alone what is too slow for it."""
    rates = [clip.samples_per_second(channel.codes) for channel in clip.channels.values() if channel.is_animated]
    if max(rates, default=np.inf) <= 2.0 * cutoff:
        raise ToolError(
            f"{clip.path} has {max(rates):g} samples per second, so --smooth must be below {max(rates) / 2.0:g} hertz."
        )
    return LowPass(cutoff, 2.0 * cutoff, "--smooth")


def _notes(repaired: RepairedClip) -> list[str]:
    """Return what a user should know; nothing of the rest pose, as it stays, nor of composition that stays."""
    clip = repaired.repair.clip
    untrue = [missing_note(clip, list(clip.missing))] if clip.missing else []
    if not repaired.channels:
        untrue += composition_notes(clip)
    return [note for note in clip.notes if note not in untrue]


def _write(layer: AnimationLayer, clips: Sequence[RepairedClip], messages: Messages) -> None:
    for each in clips:
        if each.channels:
            layer.write_animation(each.repair.clip.source, each.channels, {}, None, messages)
        for op in each.xforms:
            layer.write_op(op.attribute, op.channel)


def _described(repaired: RepairedClip) -> RepairedAnimation:
    clip, left = repaired.repair.clip, set(map(id, repaired.left))
    names = short_names(clip.joints)
    return RepairedAnimation(
        clip.path,
        tuple(str(prim.GetPath()) for prim in clip.source.skeletons),
        len(clip.joints),
        len(clip.codes),
        tuple(
            {**each.as_dict(names.get(each.joint, each.joint)), "repaired": id(each) not in left}
            for each in repaired.faults
        ),
        repaired.smoothed,
    )
