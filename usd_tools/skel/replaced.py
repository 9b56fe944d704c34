"""Find the dense samples that sparse ones replace, wherever composition takes them from."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf

from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import CHANNELS
from usd_tools.skel.find import AnimationSource


def sampled_names(spec: Sdf.PrimSpec) -> list[str]:
    """Return the channels that have samples in a spec of a SkelAnimation."""
    return [
        name
        for name in CHANNELS
        if name in spec.attributes and spec.layer.GetNumTimeSamplesForPath(spec.attributes[name].path)
    ]


def home_of(source: AnimationSource) -> Sdf.Path:
    """Return where in the root layer other samples belong: in the variant that the samples are in, else on the prim.

    Raises
    ------
    ToolError
        If the samples are partly in variants, or in variants of what the prim inherits or references.
    """
    path = source.prim.GetPath()
    found = {spec.path for spec in source.prim.GetPrimStack() if sampled_names(spec)}
    inside = [each for each in found if each.ContainsPrimVariantSelection()]
    if not inside:
        return path
    if len(found) > 1 or inside[0].StripAllVariantSelections() != path:
        raise ToolError(
            f"{path}: its samples are in {', '.join(sorted(map(str, found)))}, so they cannot be replaced without "
            "changing other variants; add --flatten."
        )
    return inside[0]


def replaced_samples(
    source: AnimationSource, selected: Sequence[AnimationSource], everyone: Sequence[AnimationSource]
) -> list[Sdf.Path]:
    """List the attributes, of inherited, specialized and referenced prims, whose samples nobody uses any more.

    Parameters
    ----------
    source : AnimationSource
        That gets samples of its own.
    selected : sequence of AnimationSource
        All that get samples of their own.
    everyone : sequence of AnimationSource
        All of the stage.

    Returns
    -------
    paths : list of Sdf.Path
        On the stage and in its own layers, whose paths are the same.
    """
    others = [other for other in everyone if other not in selected]
    own = {str(prim.GetPath()) for other in everyone for prim in other.prims}
    paths = []
    for spec in source.prim.GetPrimStack():
        if (
            spec.layer not in source.stage.GetLayerStack()
            or str(spec.path) in own
            or spec.path.ContainsPrimVariantSelection()
        ):
            continue
        if not any(spec in other.prim.GetPrimStack() for other in others):
            paths += [spec.attributes[name].path for name in sampled_names(spec)]
    return paths
