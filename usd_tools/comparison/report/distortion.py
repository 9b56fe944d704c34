"""Chart of bytes against largest error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from usd_tools.comparison.acl import ACL
from usd_tools.comparison.distortion import METHODS, RateDistortion
from usd_tools.figures.style import INK

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = 5
"""Clips side by side."""

_MARKS = (("#d1495b", "o"), ("#00798c", "s"), ("#edae49", "^"), ("#8d96a3", "v"), ("#3d3d3d", "D"))

_LOOKS = dict(zip((*METHODS, ACL), _MARKS, strict=True))
"""Colour and marker of each method."""


def draw_rate_distortion(points: Sequence[RateDistortion]) -> Figure:
    """Draw bytes against largest error, a panel for each clip, both axes logarithmic.

    Parameters
    ----------
    points : sequence of RateDistortion

    Returns
    -------
    figure : Figure
    """
    from matplotlib.figure import Figure

    clips = list(dict.fromkeys(point.clip for point in points))
    n_columns = min(COLUMNS, len(clips))
    n_rows = -(-len(clips) // n_columns)
    figure = Figure(figsize=(2.9 * n_columns + 0.8, 3.0 * n_rows + 0.75), layout="constrained")
    axes = figure.subplots(n_rows, n_columns, squeeze=False, sharey=True)
    for panel in axes.ravel()[len(clips) :]:
        panel.set_visible(False)
    for clip, panel in zip(clips, axes.ravel(), strict=False):
        for method, (color, marker) in _LOOKS.items():
            # keys that stay whole are exact and ACL is not run: the tolerance is shown, for the axis is logarithmic
            curve = sorted(
                (point.largest_cm or point.tolerance_cm, point.bytes)
                for point in points
                if (point.clip, point.method) == (clip, method) and point.bytes is not None
            )
            panel.loglog(*zip(*curve, strict=True), color=color, marker=marker, label=method) if curve else None
        panel.set_title(clip, color=INK, size=12, weight="bold")
        ticks = sorted({point.tolerance_cm for point in points})
        panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        panel.set_xticks([], minor=True)
        panel.set_xlabel("largest error (cm)")
        panel.grid(True, which="major", alpha=0.25)
    axes[0, 0].set_ylabel("bytes of motion")
    labelled = {
        label: handle
        for panel in axes.ravel()
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    labels, handles = list(labelled), list(labelled.values())
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 2 * n_columns), frameon=False)
    return figure
