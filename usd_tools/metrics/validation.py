"""Check stored metrics: a list of sentences, and a validator for UsdValidation."""

from __future__ import annotations

from functools import cache

from pxr import Usd

from geomstats_anim.names import SCHEME_NAMES
from usd_tools.console.errors import ToolError
from usd_tools.console.text import counted, short_names
from usd_tools.metrics.attributes import NAMESPACE, metric_faults, read_metric

VALIDATOR = "geomstatsAnim:GeodesicMetric"
"""Name for UsdValidation."""


def validate_metric(prim: Usd.Prim) -> list[str]:
    """Check the metric of a SkelAnimation.

    Parameters
    ----------
    prim : Usd.Prim

    Returns
    -------
    problems : list of str
        A sentence each: missing attributes, wrong types and lengths, values that make no metric, an unknown scheme,
        joints that only the metric or only the animation has. Empty if all is well, or there is no metric.
    """
    faults = metric_faults(prim)
    if faults:
        return faults
    try:
        metric = read_metric(prim)
    except ToolError as error:
        return [str(error)]
    if metric is None:
        return []
    path, problems = prim.GetPath(), []
    if metric.scheme not in SCHEME_NAMES:
        problems.append(f"{path}: {NAMESPACE}:scheme {metric.scheme!r} does not exist; use {', '.join(SCHEME_NAMES)}.")
    joints = tuple(prim.GetAttribute("joints").Get() or ())
    names = short_names(list(dict.fromkeys((*joints, *metric.joints))))
    sides = (("animation", joints, "metric", metric.joints), ("metric", metric.joints, "animation", joints))
    for owner, own, other, known in sides:
        lost = [joint for joint in own if joint not in set(known)]
        if lost:
            more = f" and {counted(len(lost) - 1, 'other joint')}" if len(lost) > 1 else ""
            problems.append(f"{path}: the {owner} has {names[lost[0]]}{more}, but the {other} does not.")
    return problems


@cache
def register_validator() -> bool:
    """Have UsdValidation run `validate_metric` on every SkelAnimation, under the name `VALIDATOR`.

    Returns
    -------
    registered : bool
        False where OpenUSD takes no validators from Python, before 26.5.
    """
    from pxr import UsdValidation

    registry = UsdValidation.ValidationRegistry()
    if not hasattr(registry, "RegisterPrimValidator"):
        return False

    def errors(prim: Usd.Prim, *_: object) -> list[object]:
        site = [UsdValidation.ValidationErrorSite(prim.GetStage(), prim.GetPath())]
        kind = UsdValidation.ValidationErrorType.Error
        return [UsdValidation.ValidationError("GeodesicMetric", kind, site, text) for text in validate_metric(prim)]

    metadata = UsdValidation.ValidatorMetadata(
        name=VALIDATOR, doc="Stored metrics are whole and fit their animation.", schemaTypes=["UsdSkelAnimation"]
    )
    registry.RegisterPrimValidator(metadata, errors)
    return True
