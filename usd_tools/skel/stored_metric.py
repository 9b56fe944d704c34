"""The metric that a file stores for an animation, wherever it is."""

from __future__ import annotations

from geomstats_anim import LearnedMetric
from usd_tools.metrics.attributes import read_metric
from usd_tools.metrics.strings import read_strings
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.joint_names import read_names


def stored_metric(source: AnimationSource) -> LearnedMetric | None:
    """Read the metric of an animation: from its attributes, or where these are gone from the JSON beside its Skeletons.

    Parameters
    ----------
    source : AnimationSource

    Returns
    -------
    metric : LearnedMetric or None
        None if there is none.

    Raises
    ------
    ToolError
        If what is stored is no metric.
    """
    metric = read_metric(source.prim)
    return read_strings(source.rig, read_names(source.prim, "joints")) if metric is None else metric
