"""Skin as OpenUSD moves it."""

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel


def skinned(path, codes):
    """Points of the only mesh in the world, centimetres."""
    stage = Usd.Stage.Open(str(path))
    root = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root))
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(root), Usd.PrimDefaultPredicate)
    (binding,) = cache.ComputeSkelBindings(UsdSkel.Root(root), Usd.PrimDefaultPredicate)
    (target,) = binding.GetSkinningTargets()
    query = cache.GetSkelQuery(binding.GetSkeleton())
    found = []
    for code in map(Usd.TimeCode, codes):
        points = UsdGeom.PointBased(target.GetPrim()).GetPointsAttr().Get()
        assert target.ComputeSkinnedPoints(query.ComputeSkinningTransforms(code), points, code)
        to_world = np.array(binding.GetSkeleton().ComputeLocalToWorldTransform(code))
        found.append(np.array(points) @ to_world[:3, :3] + to_world[3, :3])
    return 100.0 * UsdGeom.GetStageMetersPerUnit(stage) * np.array(found)
