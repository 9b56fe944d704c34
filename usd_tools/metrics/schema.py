"""The applied schema of metrics, GeodesicMetricAPI: no code, but types and words for programs that show attributes."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from pxr import Plug, Sdf

SCHEMA = "GeodesicMetricAPI"

SCHEMA_FOLDER = Path(__file__).parent / "geodesic_metric_api"
"""Folder that belongs on PXR_PLUGINPATH_NAME, so that other programs know the schema."""


@cache
def register_schema() -> None:
    """Have OpenUSD know the schema. It reads schemas once, when the first stage is opened; later this does nothing."""
    Plug.Registry().RegisterPlugins(str(SCHEMA_FOLDER))


def apply_schema(spec: Sdf.PrimSpec) -> None:
    """Apply the schema to a SkelAnimation, beside those that are applied."""
    applied = spec.GetInfo("apiSchemas") if spec.HasInfo("apiSchemas") else Sdf.TokenListOp()
    if SCHEMA in applied.ApplyOperations([]):
        return
    if applied.isExplicit:
        applied.explicitItems = [*applied.explicitItems, SCHEMA]
    else:
        applied.deletedItems = [name for name in applied.deletedItems if name != SCHEMA]
        applied.prependedItems = [*applied.prependedItems, SCHEMA]
    spec.SetInfo("apiSchemas", applied)
