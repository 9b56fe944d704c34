"""Check skeletons and the stage's range for what makes viewers show less than a file holds."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel, Vt

from usd_tools.skel.clip import SkelClip
from usd_tools.skel.joint_names import read_names

SMALLEST, LARGEST = 0.02, 50.0
"""Metres: a skeleton beyond these is more likely in another unit than its stage says."""

_MOVED = 0.05
"""Share of a skeleton's size by which a joint at rest may be from its place in the bind pose."""


def range_note(clip: SkelClip) -> str | None:
    """Return a warning if the stage's range holds none of an animation's samples."""
    stage = clip.source.stage
    if not (stage.HasAuthoredTimeCodeRange() and len(clip.codes)):
        return None
    start, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    if ((clip.codes >= start) & (clip.codes <= end)).any():
        return None
    return (
        f"{clip.path}: the stage's range, {start:g} to {end:g}, misses all samples, which are at {clip.codes[0]:g} to "
        f"{clip.codes[-1]:g}; correct startTimeCode and endTimeCode."
    )


def rest_size(skeleton: Usd.Prim) -> float | None:
    """Return the largest extent of a skeleton's joints at rest in the world, metres; None if it has no rest pose."""
    places = _places(skeleton, at_rest=True)
    if places is None or len(places) < 2:
        return None
    to_world = np.array(UsdGeom.Imageable(skeleton).ComputeLocalToWorldTransform(Usd.TimeCode.EarliestTime()))
    size = float(np.ptp(places @ to_world[:3, :3], axis=0).max())
    return size * UsdGeom.GetStageMetersPerUnit(skeleton.GetStage())


def size_note(skeleton: Usd.Prim) -> str | None:
    """Return a warning if a skeleton is so small or large that its unit is doubtful."""
    size = rest_size(skeleton)
    if size is None or size == 0.0 or SMALLEST <= size <= LARGEST:
        return None
    return f"{skeleton.GetPath()} is {size:.3g} metres large; check metersPerUnit of the stage, and scales."


def count_off_bind(skeleton: Usd.Prim) -> int | None:
    """Count the joints that are elsewhere at rest than in the bind pose; None where one of the poses is missing."""
    rest, bind = _places(skeleton, at_rest=True), _places(skeleton, at_rest=False)
    if rest is None or bind is None:
        return None
    size = max(np.ptp(bind, axis=0).max(initial=0.0), np.ptp(rest, axis=0).max(initial=0.0))
    return int((np.linalg.norm(rest - bind, axis=-1) > _MOVED * size).sum())


def _places(skeleton: Usd.Prim, at_rest: bool) -> np.ndarray | None:
    """Return the places of joints in the skeleton's space, shape=[B, 3], at rest or as bound."""
    n_joints = len(read_names(skeleton, "joints"))
    authored = skeleton.GetAttribute("restTransforms" if at_rest else "bindTransforms").Get()
    if not n_joints or not isinstance(authored, Vt.Matrix4dArray) or len(authored) != n_joints:
        return None
    transforms = authored
    if at_rest:
        query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(skeleton))
        transforms = query.ComputeJointSkelTransforms(Usd.TimeCode.EarliestTime(), True) if query else None
    return np.array(transforms)[:, 3, :3] if transforms else None
