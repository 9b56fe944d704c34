"""Read the skeleton that an animation drives: rest pose, bone ends, and its scale in the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdSkel, Vt

from geomstats_anim import Skeleton
from geomstats_anim.animation import default_bone_ends
from geomstats_anim.names import repeated_name
from geomstats_anim.rotations import IDENTITY, normalize
from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import Channel
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.joint_names import read_names

_ROUNDING = 1e-6
"""Scales nearer to 1 than this are 1: what single precision leaves of a rotation's matrix."""

BONE_ENDS = "geomstatsAnim:boneEnds"
"""Custom double3[] of a Skeleton: the end of each joint's bone in its own frame, in the file's unit."""


@dataclass(frozen=True, eq=False)
class BoundSkeleton:
    """A skeleton as an animation drives it.

    Parameters
    ----------
    source : AnimationSource
        Its largest skeleton first.
    skeleton : Skeleton
        All joints of that skeleton, then those that only the animation has, parents first; metres.
    rest_scales : array-like, shape=[B, 3]
        Of its joints in their rest pose.
    columns : array-like of int, shape=[N]
        Where each joint of the animation is in it.
    has_rest : bool
        Whether every joint of the animation has an authored rest pose.
    world_scale : float
        Metres per unit of the file.
    notes : tuple of str
        Sentences about what a user should know.
    """

    source: AnimationSource
    skeleton: Skeleton
    rest_scales: np.ndarray
    columns: np.ndarray
    has_rest: bool
    world_scale: float
    notes: tuple[str, ...]


def read_skeleton(source: AnimationSource, joints: tuple[str, ...], channels: Mapping[str, Channel]) -> BoundSkeleton:
    """Read the skeleton that an animation drives.

    Parameters
    ----------
    source : AnimationSource
    joints : tuple of str, shape=[N]
        Of the animation.
    channels : mapping of str to Channel
        Joints without a rest pose rest where these begin.

    Returns
    -------
    bound : BoundSkeleton

    Raises
    ------
    ToolError
        If it names a joint twice, or its numbers cannot be used.
    """
    notes = []
    codes = np.unique(np.concatenate([[], *(channel.codes for channel in channels.values())]))
    if len(source.rig) > 1:
        source, alike = _largest_first(source, codes)
        if not alike:
            largest = source.rig[0].GetPath()
            notes.append(
                f"{source.path} drives skeletons of different sizes; lengths are measured on the largest, {largest}."
            )
    units = UsdGeom.GetStageMetersPerUnit(source.stage)
    scale = (_world_scale(source.rig[0], codes) if source.rig else 1.0) * units
    if not (np.isfinite(scale) and scale > 0.0):
        notes.append(f"{source.path}: {scale:g} metres is not a usable unit; using one metre per unit.")
        scale = 1.0
    try:
        skeleton, rest_scales, columns, has_rest = _skeleton_in_metres(source, joints, channels, scale)
    except ValueError as error:
        raise ToolError(f"{source.path} has a skeleton that cannot be used: {error}") from error
    return BoundSkeleton(source, skeleton, rest_scales, columns, has_rest, scale, tuple(notes))


def metres_per_unit(stage: Usd.Stage) -> float:
    """Return the length of a stage's unit; one metre where what it says is no length."""
    units = UsdGeom.GetStageMetersPerUnit(stage)
    return units if np.isfinite(units) and units > 0.0 else 1.0


def world_matrices(skeleton: Usd.Prim, codes: np.ndarray) -> np.ndarray:
    """Read the matrices from a skeleton's space to the world, in units of the file.

    Parameters
    ----------
    skeleton : Usd.Prim
    codes : array-like, shape=[K]
        Time codes.

    Returns
    -------
    matrices : array-like, shape=[K, 4, 4]
        For rows, as USD has them: a point p is at p m. Where nothing moves the skeleton, one matrix is repeated.
    """
    prims = [skeleton.GetStage().GetPrimAtPath(path) for path in skeleton.GetPath().GetPrefixes()]
    is_moved = any(
        UsdGeom.Xformable(prim).TransformMightBeTimeVarying() for prim in prims if prim.IsA(UsdGeom.Xformable)
    )
    cache, matrices = UsdGeom.XformCache(), []
    for code in codes if is_moved else codes[:1]:
        cache.SetTime(Usd.TimeCode(code))
        matrices.append(np.array(cache.GetLocalToWorldTransform(skeleton)))
    return np.broadcast_to(np.reshape(matrices, (-1, 4, 4)), (len(codes), 4, 4))


def _world_scale(skeleton: Usd.Prim, codes: np.ndarray) -> float:
    """Return the scale of a skeleton in the world: its geometric mean where the animation begins.

    A skeleton that is flat or nothing there is measured where it is largest.
    """
    first = codes[:1] if len(codes) else np.array([Usd.TimeCode.EarliestTime().GetValue()])
    beginning = world_matrices(skeleton, first)[0, :3, :3]
    if not np.isfinite(beginning).all():
        return np.nan
    volume = abs(float(np.linalg.det(beginning)))
    if volume > 0.0:
        return float(np.cbrt(volume))
    linear = world_matrices(skeleton, codes if len(codes) else first)[:, :3, :3]
    if not np.isfinite(linear).all():
        return np.nan
    sizes = np.cbrt(np.abs(np.linalg.det(linear)))
    return float(sizes.max() or np.linalg.norm(linear, 2, axis=(-2, -1)).max())


def _largest_first(source: AnimationSource, codes: np.ndarray) -> tuple[AnimationSource, bool]:
    """Put the skeleton with the longest bones first, as errors are largest in it; and return whether all are alike."""
    scales = np.array([_world_scale(skeleton, codes) for skeleton in source.rig])
    rests = [_rest_pose(UsdSkel.Skeleton(prim), len(read_names(prim, "joints"))) for prim in source.rig]
    bones = [np.nan if rest is None else np.linalg.norm(rest[0], axis=-1).sum() for rest in rests]
    sizes = np.nan_to_num(scales * (np.ones(len(rests)) if np.isnan(bones).any() else bones), posinf=0.0)
    largest = source.rig[int(np.argmax(sizes > 0.999 * sizes.max()))]
    rig = (largest, *(prim for prim in source.rig if prim != largest))
    source = replace(source, skeletons=rig) if source.skeletons else replace(source, ignored=rig)
    return source, bool(np.allclose(sizes, sizes[0], rtol=1e-3, atol=0.0))


def _skeleton_in_metres(
    source: AnimationSource, joints: tuple[str, ...], channels: Mapping[str, Channel], scale: float
) -> tuple[Skeleton, np.ndarray, np.ndarray, bool]:
    """Return a skeleton, its rest scales, the place of each animated joint, and whether all have a rest pose."""
    bound = UsdSkel.Skeleton(source.rig[0]) if source.rig else None
    own = read_names(source.rig[0], "joints") if bound else ()
    twice = repeated_name(own)
    if twice is not None:
        raise ToolError(f"{source.rig[0].GetPath()} names joint {twice} twice; repair the file.")
    among_own = set(own)
    names = own + tuple(joint for joint in joints if joint not in among_own)
    parents = np.array(UsdSkel.Topology(names).GetParentIndices() if names else [], dtype=np.intp)
    place = {name: i for i, name in enumerate(names)}
    columns = np.array([place[joint] for joint in joints], dtype=np.intp)

    translations, rotations = _first_pose(channels, columns, len(names))
    scales = np.ones((len(names), 3))
    rest = _rest_pose(bound, len(own)) if own else None
    if rest is not None:
        translations[: len(own)], rotations[: len(own)], scales[: len(own)] = rest

    order = _parents_first(parents)
    rank = np.argsort(order)
    parents = np.where(parents[order] >= 0, rank[parents[order]], -1) if len(names) else parents
    lengths = _bone_lengths(bound, len(own)) if len(own) else []
    translations = translations[order] * scale
    bone_lengths = [lengths[i] * scale if i < len(lengths) else None for i in order]
    bone_ends = default_bone_ends(parents, translations, bone_lengths)
    authored = _bone_ends(bound, len(own)) if own else None
    if authored is not None:
        bone_ends[rank[: len(own)]] = authored * scale
    skeleton = Skeleton(tuple(names[i] for i in order), parents, translations, rotations[order], bone_ends)
    return skeleton, scales[order], rank[columns], rest is not None and set(joints) <= among_own


def _first_pose(channels: Mapping[str, Channel], columns: np.ndarray, n_joints: int) -> tuple[np.ndarray, np.ndarray]:
    """Return translations and rotations where the animation begins: the rest of joints that have no rest pose."""
    translations, rotations = np.zeros((n_joints, 3)), np.tile(IDENTITY, (n_joints, 1))
    if "translations" in channels:
        translations[columns] = channels["translations"].default
    if "rotations" in channels:
        default = channels["rotations"].default.astype(np.float64)
        norm = np.linalg.norm(default, axis=-1, keepdims=True)
        rotations[columns] = np.where(norm > 0.0, default / np.where(norm > 0.0, norm, 1.0), IDENTITY)
    return translations, rotations


def _parents_first(parents: np.ndarray) -> np.ndarray:
    """Order joints so that parents come before their children, and otherwise as given."""
    order: list[int] = []
    placed: set[int] = set()
    for joint in range(len(parents)):
        chain = []
        while joint >= 0 and joint not in placed:
            chain.append(joint)
            placed.add(joint)
            joint = int(parents[joint])
        order.extend(reversed(chain))
    return np.array(order, dtype=np.intp)


def _rest_pose(skeleton: UsdSkel.Skeleton, n_joints: int) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Read rest translations (file's unit), rotations and scales; None where they are not authored or singular."""
    transforms = skeleton.GetRestTransformsAttr().Get()
    if not isinstance(transforms, Vt.Matrix4dArray) or len(transforms) != n_joints:
        return None
    try:
        translations, rotations, _ = UsdSkel.DecomposeTransforms(transforms)
    except Tf.ErrorException:
        return None
    if not np.isfinite(np.array(translations)).all():
        return None
    # not the scales of OpenUSD, which have three digits: its matrices are for rows, each an axis
    linear = np.array(transforms)[:, :3, :3]
    scales = np.linalg.norm(linear, axis=-1) * np.sign(np.linalg.det(linear))[:, None]
    scales = np.where(np.abs(scales - 1.0) < _ROUNDING, 1.0, scales)
    return np.array(translations, dtype=np.float64), normalize(np.array(rotations, dtype=np.float64)), scales


def _bone_lengths(skeleton: UsdSkel.Skeleton, n_joints: int) -> list[float]:
    """Read the bone lengths that Blender writes, in the file's unit; empty where there are none."""
    primvar = UsdGeom.PrimvarsAPI(skeleton).GetPrimvar("blender:bone_lengths")
    lengths = primvar.Get() if primvar else None
    return list(lengths) if isinstance(lengths, Vt.FloatArray | Vt.DoubleArray) and len(lengths) == n_joints else []


def _bone_ends(skeleton: UsdSkel.Skeleton, n_joints: int) -> np.ndarray | None:
    """Read the ends of the joints' bones, in the file's unit; None where they are not authored."""
    attribute = skeleton.GetPrim().GetAttribute(BONE_ENDS)
    value = attribute.Get() if attribute else None
    if value is None:
        return None
    if not isinstance(value, Vt.Vec3dArray) or len(value) != n_joints or not np.isfinite(np.array(value)).all():
        raise ToolError(
            f"{skeleton.GetPath()}: {BONE_ENDS} must be a double3[] of {n_joints} finite vectors, one per joint; "
            "correct or remove it."
        )
    return np.array(value)
