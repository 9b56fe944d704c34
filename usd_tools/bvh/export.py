"""The work of `to_bvh`: from the animation of a stage to what a BVH file holds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, Vt

from geomstats_anim import Animation
from geomstats_anim import rotations as quat
from usd_tools.bvh.result import ToBvhResult
from usd_tools.bvh.stored_channels import read_channels
from usd_tools.bvh.to_options import ToBvhOptions
from usd_tools.bvh.writer import BvhMotion, write_bvh
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.files.atomic import write_json, written_beside
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.paths import check_output, extension, same_file
from usd_tools.files.stages import open_stage, stage_path
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.skel.joint_names import unique
from usd_tools.skel.output import check_report
from usd_tools.skel.resampling import animation_of

EVEN = 1e-2
"""Share of a frame by which samples may be off."""

RIGID = 1e-4
"""Largest distance of a placement in the world from a turn and one scale."""

_Y_FROM_Z = np.array([-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
"""The turn that takes z, where it points up, to y."""


@openusd_errors()
def to_bvh_file(
    source: Path,
    out: Path,
    options: ToBvhOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> ToBvhResult:
    """Convert the animation of a file; see `usd_tools.to_bvh.to_bvh`."""
    if extension(out) != ".bvh":
        raise ToolError(f"--out {out}: the name must end in .bvh.")
    check_output(out, "--out")
    if same_file(out, [source]):
        raise ToolError(f"--out {out} is the input itself; choose another name.")
    check_report(options.report, source, out)
    messages = Messages(warn)
    with usd_warnings(messages), reading(source):
        stage = open_stage(source)
        result = _convert(source, stage, out, options, messages, progress)
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def to_bvh_from_stage(
    stage: Usd.Stage,
    out: Path,
    options: ToBvhOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> ToBvhResult:
    """Convert the animation of an open stage; see `usd_tools.to_bvh.to_bvh_stage`."""
    check_output(out, "--out")
    messages, path = Messages(warn), stage_path(stage)
    with usd_warnings(messages), reading(path):
        return _convert(path, stage, out, options, messages, progress)


def _convert(
    source: Path,
    stage: Usd.Stage,
    out: Path,
    options: ToBvhOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> ToBvhResult:
    steps = Progress(progress, 2, "Reading")
    sources = select_animations(source, find_animations(stage), options.prim)
    if len(sources) > 1:
        paths = ", ".join(each.path for each in sources[:3])
        raise ToolError(f"{source} has {len(sources)} animations, such as {paths}; choose one with --prim.")
    clip = read_clip(sources[0])
    for note in clip.notes:
        messages.warn(note)
    if not clip.joints or not clip.is_animated:
        raise ToolError(f"{clip.path} has no joints with at least two samples; BVH holds nothing else.")
    motion = _motion(clip, options, messages)
    steps.advance(1, "Writing")
    with written_beside(out) as beside:
        write_bvh(beside, motion, read_channels(clip))
    steps.advance(1)
    return ToBvhResult(
        source.name,
        out,
        clip.path,
        len(motion.names),
        len(motion.rotations),
        motion.rate,
        _unit(clip, options),
        tuple(messages.warnings),
    )


def _unit(clip: SkelClip, options: ToBvhOptions) -> float:
    """Return the metres per unit of the BVH file."""
    return clip.world_scale if options.scale is None else options.scale


def _motion(clip: SkelClip, options: ToBvhOptions, messages: Messages) -> BvhMotion:
    animation = animation_of(clip)
    rate = _steady_rate(clip, animation)
    if animation.scales is not None and not np.allclose(animation.scales, 1.0, rtol=0.0, atol=1e-3):
        messages.warn(f"{clip.path} scales joints, which BVH cannot hold; the scales are left out.")
    skeleton, unit = animation.skeleton, _unit(clip, options)
    turn, move = _placements(clip, animation.times * clip.codes_per_second, options)
    turned = quat.multiply(turn[:1], _rest_turns(animation))
    parents, roots = skeleton.parents, skeleton.parents < 0
    above = np.where(roots[:, None], quat.IDENTITY, turned[parents])
    # A BVH rests where nothing is turned: so each joint's own frame is replaced by one that is as the world at rest.
    rotations = quat.multiply(quat.multiply(above, animation.rotations), quat.conjugate(turned))
    translations = quat.rotate(above, animation.translations) / unit
    offsets = quat.rotate(above, skeleton.rest_translations) / unit
    ends = quat.rotate(turned, skeleton.bone_ends) / unit
    offsets[roots] = quat.rotate(turn[:1], offsets[roots])
    translations[:, roots] = quat.rotate(turn[:, None], translations[:, roots]) + move[:, None] / unit
    rotations[:, roots] = quat.multiply(turn[:, None], rotations[:, roots])
    return BvhMotion(_names(clip), parents, offsets, ends, rotations, translations, rate)


def _steady_rate(clip: SkelClip, animation: Animation) -> float:
    """Return the frames per second, or refuse samples that are not evenly spaced."""
    gaps = np.diff(animation.times)
    usual = float(np.median(gaps))
    if np.abs(animation.times - animation.times[0] - usual * np.arange(animation.n_frames)).max() > EVEN * usual:
        raise ToolError(
            f"{clip.path} is not evenly sampled, as BVH needs it; run usd_tools.resample --fps {1.0 / usual:g} first."
        )
    return float((animation.n_frames - 1) / (animation.times[-1] - animation.times[0]))


def _rest_turns(animation: Animation) -> np.ndarray:
    """Return the rotations of the joints at rest, relative to the skeleton, shape=[B, 4]."""
    turned = np.array(animation.skeleton.rest_rotations)
    for joint, parent in enumerate(animation.skeleton.parents):
        if parent >= 0:
            turned[joint] = quat.multiply(turned[parent], turned[joint])
    return turned


def _placements(clip: SkelClip, codes: np.ndarray, options: ToBvhOptions) -> tuple[np.ndarray, np.ndarray]:
    """Return the turns, shape=[F, 4], and the moves in metres, shape=[F, 3], from the skeleton's space to the BVH's."""
    stage = clip.source.stage
    turn, move = np.tile(quat.IDENTITY, (len(codes), 1)), np.zeros((len(codes), 3))
    if clip.source.rig:
        matrices = clip.world_matrices(codes)
        sizes = np.cbrt(np.linalg.det(matrices[:, :3, :3]))
        linear = matrices[:, :3, :3].swapaxes(1, 2) / np.where(sizes > 0.0, sizes, 1.0)[:, None, None]
        is_rigid = sizes.min() > 0.0 and np.abs(linear @ linear.swapaxes(1, 2) - np.eye(3)).max() <= RIGID
        if not is_rigid or np.ptp(sizes) > RIGID * sizes.max():
            raise ToolError(
                f"{clip.path}: {clip.source.rig[0].GetPath()} is mirrored, sheared or scaled unevenly in the world, "
                "which BVH cannot hold; remove that from the transforms above it."
            )
        turn = quat.normalize(quat.from_matrix(linear))
        move = matrices[:, 3, :3] * (clip.world_scale / sizes[:, None])
    if options.up == "Y" and UsdGeom.GetStageUpAxis(stage) == "Z":
        turn, move = quat.multiply(_Y_FROM_Z, turn), quat.rotate(_Y_FROM_Z, move)
    return turn, move


def _names(clip: SkelClip) -> list[str]:
    """Return the names of the joints, each once and in one word: those to show to people, else the ends of paths."""
    names = [joint.rsplit("/", 1)[-1] for joint in clip.skeleton.joints]
    shown = clip.source.rig[0].GetAttribute("jointNames").Get() if clip.source.rig else None
    own = clip.source.rig[0].GetAttribute("joints").Get() if shown else None
    if isinstance(shown, Vt.TokenArray) and own is not None and len(shown) == len(own):
        by_joint = dict(zip(own, shown, strict=True))
        names = [by_joint.get(joint) or name for joint, name in zip(clip.skeleton.joints, names, strict=True)]
    return unique(["_".join(name.split()) or "joint" for name in names])
