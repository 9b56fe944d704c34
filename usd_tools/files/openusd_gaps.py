"""Workarounds for data that OpenUSD's utilities drop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from pxr import Sdf, Usd, UsdUtils


def modify_asset_paths(layer: Sdf.Layer, modified: Callable[[str], str]) -> None:
    """Call `UsdUtils.ModifyAssetPaths`, which forgets the offsets of sublayers whose paths it changes."""
    offsets = list(layer.subLayerOffsets)
    UsdUtils.ModifyAssetPaths(layer, modified)
    for i, offset in enumerate(offsets):
        layer.subLayerOffsets[i] = offset


def flatten_stage(stage: Usd.Stage) -> Sdf.Layer:
    """Call `Usd.Stage.Flatten`, which leaves out targets that are blocked, so that those of ancestors show through."""
    layer = stage.Flatten(addSourceFileComment=False)
    for prim in _all_prims(stage):
        path = prim.GetPath()
        for i, prototype in enumerate(stage.GetPrototypes(), 1):
            path = path.ReplacePrefix(prototype.GetPath(), Sdf.Path(f"/Flattened_Prototype_{i}"))
        for relationship in prim.GetAuthoredRelationships():
            spec = layer.GetRelationshipAtPath(path.AppendProperty(relationship.GetName()))
            if spec and relationship.HasAuthoredTargets() and not relationship.GetTargets():
                spec.targetPathList.ClearEditsAndMakeExplicit()
    return layer


def _all_prims(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    for root in (stage.GetPseudoRoot(), *stage.GetPrototypes()):
        yield from Usd.PrimRange(root, Usd.PrimAllPrimsPredicate)


def lost_by_packing(root: Path) -> str | None:
    """Name a sublayer with an offset that `UsdUtils.CreateNewUsdzPackage` would forget, and the layer it is in."""
    for layer in UsdUtils.ComputeAllDependencies(str(root))[0]:
        for path, offset in zip(layer.subLayerPaths, layer.subLayerOffsets, strict=True):
            if not offset.IsIdentity():
                return f"{path} in {layer.GetDisplayName()}"
    return None


def lost_by_flattening(stage: Usd.Stage) -> list[str]:
    """Name the variant sets that `Usd.Stage.Flatten` leaves out, and what is chosen of each."""
    return [
        f"{name} of {prim.GetPath()} at {prim.GetVariantSet(name).GetVariantSelection() or 'none'}"
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
        if prim.HasVariantSets()
        for name in prim.GetVariantSets().GetNames()
    ]
