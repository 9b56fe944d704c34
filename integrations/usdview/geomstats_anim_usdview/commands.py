"""Commands of the menu, without windows: upsample into the session, tables of metrics, remove."""

from __future__ import annotations

from typing import Any

from pxr import Sdf, Usd

from usd_tools.console.errors import ToolError
from usd_tools.files.stages import stage_path
from usd_tools.metric import show_metric_stage
from usd_tools.metrics.attributes import summary
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.styling.summary import HEADER, joint_rows
from usd_tools.upsample import UpsampleOptions, UpsampleResult, upsample_stage

_TAG = "geodesic"
"""Name of the layers with our results, and the entry of their customLayerData that says of which animations."""


def upsample(api: Any, **options: Any) -> UpsampleResult | None:
    """Upsample the selected animations from their source, into a sublayer of the session layer.

    Parameters
    ----------
    api : UsdviewApi
        Of it `stage`, `selectedPrims` and `PrintStatus` are used.
    **options
        Of `UpsampleOptions`.

    Returns
    -------
    result : UpsampleResult or None
        None if it was refused: the status line says why, and the session is as it was.
    """
    session = api.stage.GetSessionLayer()
    before, earlier = list(session.subLayerPaths), _results(api.stage)  # held: a layer that nobody holds is gone
    try:
        chosen = _chosen(api)
        for layer in earlier:  # a second time starts from the source as well
            if not chosen.isdisjoint(layer.customLayerData[_TAG]):
                session.subLayerPaths.remove(layer.identifier)
        layer = Sdf.Layer.CreateAnonymous(f"{_TAG}.usda")
        layer.customLayerData = {_TAG: sorted(chosen)}
        session.subLayerPaths.append(layer.identifier)
        with Usd.EditContext(api.stage, api.stage.GetEditTargetForLocalLayer(layer)):
            result = upsample_stage(api.stage, UpsampleOptions(prim=tuple(sorted(chosen)), **options))
    except ToolError as error:
        session.subLayerPaths = before
        api.PrintStatus(str(error))
        return None
    api.PrintStatus(" ".join([f"{result.brief}, in the session layer.", *result.warnings]))
    return result


def metric_tables(api: Any) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
    """Describe the stored metrics of the selected animations: a title, a header and rows for each."""
    try:
        shown = show_metric_stage(api.stage, prim=sorted(_chosen(api))).animations
    except ToolError as error:
        api.PrintStatus(str(error))
        return []
    stored = [each for each in shown if each.metric is not None]
    sentences = [problem for each in shown for problem in each.problems]
    if not stored and not sentences:
        sentences = ["No metric is stored with the selected animations."]
    if sentences:
        api.PrintStatus(" ".join(sentences))
    return [(f"{each.prim}: {summary(each.metric)}", HEADER, joint_rows(each.metric)) for each in stored]


def remove(api: Any) -> None:
    """Take what `upsample` made of the selected animations out of the session."""
    try:
        chosen = _chosen(api)
    except ToolError as error:
        api.PrintStatus(str(error))
        return
    found = [layer for layer in _results(api.stage) if not chosen.isdisjoint(layer.customLayerData[_TAG])]
    for layer in found:
        api.stage.GetSessionLayer().subLayerPaths.remove(layer.identifier)
    api.PrintStatus("Removed." if found else "There is nothing to remove for the selected animations.")


def _chosen(api: Any) -> set[str]:
    """Return the paths of the selected animations; of all where nothing, or the root, is selected."""
    paths = [str(prim.GetPath()) for prim in api.selectedPrims if not prim.IsPseudoRoot()]
    sources = find_animations(api.stage)
    return {source.path for source in select_animations(stage_path(api.stage), sources, paths)}


def _results(stage: Usd.Stage) -> list[Sdf.Layer]:
    layers = map(Sdf.Layer.Find, stage.GetSessionLayer().subLayerPaths)
    return [layer for layer in layers if layer and _TAG in layer.customLayerData]
