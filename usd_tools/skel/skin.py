"""Read the points of the meshes that a skeleton deforms, as markers that move with its joints."""

from __future__ import annotations

from functools import reduce
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from geomstats_anim.markers import Markers
from usd_tools.skel.clip import SkelClip


class SkinnedMesh(NamedTuple):
    """Mesh, or other points, that a skeleton deforms.

    Attributes
    ----------
    prim : Usd.Prim
    markers : Markers
        Its points.
    """

    prim: Usd.Prim
    markers: Markers


def skin_markers(clip: SkelClip) -> Markers:
    """Mark every point of the meshes bound to a clip's skeleton, as UsdSkel's linear blend skinning moves it.

    Parameters
    ----------
    clip : SkelClip

    Returns
    -------
    markers : Markers
        None where there is no skeleton, or it deforms no mesh.
    """
    parts = [mesh.markers for mesh in skinned_meshes(clip)]
    return reduce(Markers.joined, parts) if parts else Markers.none()


def skinned_meshes(clip: SkelClip) -> list[SkinnedMesh]:
    """Find what is bound to a clip's skeleton and has points.

    Parameters
    ----------
    clip : SkelClip

    Returns
    -------
    meshes : list of SkinnedMesh
        Empty where there is no skeleton, or it deforms nothing.
    """
    if not clip.source.rig:
        return []
    skeleton = clip.source.rig[0]
    root = UsdSkel.Root.Find(skeleton)
    if not root:
        return []
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.TraverseInstanceProxies())
    bindings = cache.ComputeSkelBindings(root, Usd.TraverseInstanceProxies())
    targets = [
        target
        for binding in bindings
        if binding.GetSkeleton().GetPrim() == skeleton
        for target in binding.GetSkinningTargets()
        if target.HasJointInfluences()
    ]
    query = cache.GetSkelQuery(UsdSkel.Skeleton(skeleton))
    bind = np.array(query.GetJointWorldBindTransforms())
    order = list(query.GetJointOrder())
    if not targets or len(bind) != len(order):
        return []
    inverse = dict(zip(order, np.linalg.pinv(bind), strict=True))
    place = {joint: i for i, joint in enumerate(clip.skeleton.joints)}
    found = []
    for target in targets:
        joints = list(target.GetJointOrder() or order)
        if set(joints) <= set(order) and target.GetPrim().IsA(UsdGeom.PointBased):
            columns = np.array([place[joint] for joint in joints])
            inverse_bind = np.array([inverse[joint] for joint in joints])
            found.append(SkinnedMesh(target.GetPrim(), _marked(target, columns, inverse_bind, clip.world_scale)))
    return [mesh for mesh in found if mesh.markers.n_markers]


def _marked(target: UsdSkel.SkinningQuery, columns: np.ndarray, inverse_bind: np.ndarray, scale: float) -> Markers:
    """Mark the points of one mesh, each in the frames of the joints that influence it."""
    points = UsdGeom.PointBased(target.GetPrim()).GetPointsAttr().Get(Usd.TimeCode.EarliestTime())
    n_points = len(points or ())
    influences = target.ComputeVaryingJointInfluences(n_points) if n_points else None
    if not influences:
        return Markers.none()
    joints, weights = (np.array(each).reshape(n_points, -1) for each in influences)
    if joints.min(initial=0) < 0 or joints.max(initial=-1) >= len(columns):
        return Markers.none()
    at_bind = np.concatenate([np.array(points, dtype=np.float64), np.ones((n_points, 1))], axis=-1)
    at_bind = at_bind @ np.array(target.GetGeomBindTransform())
    offsets = np.einsum("pi,pkij->pkj", at_bind, inverse_bind[joints])[..., :3]
    return Markers(columns[joints], offsets * scale, weights)
