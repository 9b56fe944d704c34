"""The metric as strings beside a Skeleton: its JSON and a summary, for programs that drop what animations hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

from pxr import Sdf, Tf, Usd, UsdSkel

from geomstats_anim import LearnedMetric
from usd_tools.console.errors import ToolError
from usd_tools.metrics.attributes import NAMESPACE, summary

METRIC_JSON = f"userProperties:{NAMESPACE}"
"""The metric's JSON. Blender keeps strings of a Skeleton and of its parent, and only drops arrays."""

SUMMARY = f"{METRIC_JSON}Summary"
"""One line for people."""


def carriers(skeleton: Usd.Prim) -> list[Usd.Prim]:
    """Return the prims that may carry the strings of a Skeleton: itself, its parent and its grandparent.

    Blender reads strings of the Skeleton, but writes only those of its parent, and may put a prim between them. An
    ancestor of several Skeletons carries no strings, for nobody knew whose they are.
    """
    found, prim = [skeleton], skeleton
    for _ in range(2):
        prim = prim.GetParent()
        if prim.IsPseudoRoot() or _has_several_skeletons(prim):
            break
        found.append(prim)
    return found


def _has_several_skeletons(prim: Usd.Prim) -> bool:
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    return len(list(islice((each for each in below if each.IsA(UsdSkel.Skeleton)), 2))) > 1


def write_strings(spec: Sdf.PrimSpec, metric: LearnedMetric) -> None:
    """Write the metric's JSON and its summary on a Skeleton or its parent."""
    for name, text in ((METRIC_JSON, metric.to_json(indent=None).strip()), (SUMMARY, summary(metric))):
        attribute = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, Sdf.ValueTypeNames.String)
        attribute.custom = True
        attribute.ClearInfo("timeSamples")  # Blender writes a string as samples
        attribute.default = text


def read_strings(skeletons: Sequence[Usd.Prim], joints: Sequence[str]) -> LearnedMetric | None:
    """Read the metric from the JSON beside Skeletons.

    Parameters
    ----------
    skeletons : sequence of Usd.Prim
    joints : sequence of str, shape=[B]
        Of the animation that the metric is for; joints that another program has renamed are found, see `renamed`.

    Returns
    -------
    metric : LearnedMetric or None
        None if there is none.

    Raises
    ------
    ToolError
        If the JSON is no metric, or two Skeletons have different ones.
    """
    texts: dict[str, Usd.Prim] = {}
    for skeleton in skeletons:
        for prim in carriers(skeleton):
            text = prim.GetAttribute(METRIC_JSON).Get(Usd.TimeCode.EarliestTime())
            if isinstance(text, str) and text.lstrip().startswith("{"):  # the summary was here, in older files
                texts.setdefault(text, prim)
                break
    if not texts:
        return None
    if len(texts) > 1:
        first, other, *_ = (prim.GetPath() for prim in texts.values())
        raise ToolError(f"{first} and {other} have different {METRIC_JSON} for one animation; remove one of them.")
    ((text, prim),) = texts.items()
    try:
        return renamed(LearnedMetric.from_json(text), joints)
    except ValueError as error:
        raise ToolError(f"{prim.GetPath()}: {METRIC_JSON} is invalid: {error}") from error


def renamed(metric: LearnedMetric, joints: Sequence[str]) -> LearnedMetric:
    """Give joints of a metric the names that another program has given them.

    Blender leaves out what is between joints, and exports ":" as "_", which changes paths. A joint
    that is not found by its path is found by the last part of it, as an identifier, if there is only one on each side.

    Parameters
    ----------
    metric : LearnedMetric
    joints : sequence of str, shape=[B]

    Returns
    -------
    metric : LearnedMetric
    """
    known, wanted = set(metric.joints), set(joints)
    lost = _by_identifier([joint for joint in metric.joints if joint not in wanted])
    found = _by_identifier([joint for joint in joints if joint not in known])
    names = {lost[name]: found[name] for name in lost.keys() & found.keys()}
    return replace(metric, joints=tuple(names.get(joint, joint) for joint in metric.joints))


def _by_identifier(joints: Sequence[str]) -> dict[str, str]:
    """Return joints by their own names as identifiers, where these are unique."""
    names = [Tf.MakeValidIdentifier(joint.rsplit("/", 1)[-1]) for joint in joints]
    counts = Counter(names)
    return {name: joint for name, joint in zip(names, joints, strict=True) if counts[name] == 1}
