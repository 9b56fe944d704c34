"""Draw the samples that were kept, over the speed of the motion, and the errors of the rebuilt frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geomstats_anim.kinematics import world_pose
from usd_tools.downsampling.reduce import DownsampledClip
from usd_tools.figures.style import FAINT, INK, look
from usd_tools.skel.resampling import animation_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_kept(clips: Sequence[DownsampledClip]) -> Figure:
    """Draw a panel of speed and one of error for each animation.

    Parameters
    ----------
    clips : sequence of DownsampledClip

    Returns
    -------
    figure : Figure
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.4 * len(clips)), layout="constrained")
    panels = figure.subplots(2 * len(clips), 1, squeeze=False, height_ratios=[3.0, 1.6] * len(clips))[:, 0]
    for number, each in enumerate(clips):
        speed_panel, error_panel = panels[2 * number : 2 * number + 2]
        truth = animation_of(each.clip)
        ends = world_pose(truth).ends
        speed = 100.0 * np.linalg.norm(np.gradient(ends, truth.times, axis=0), axis=-1).mean(axis=-1)
        kept = each.kept / each.clip.codes_per_second
        at_kept = np.interp(kept, truth.times, speed)
        color = look(each.metric.scheme).color
        speed_panel.fill_between(truth.times, speed, color=FAINT, alpha=0.25, linewidth=0.0)
        speed_panel.plot(truth.times, speed, color=FAINT, linewidth=1.2)
        speed_panel.vlines(kept, 0.0, at_kept, color=color, linewidth=0.8, alpha=0.6)
        speed_panel.plot(kept, at_kept, "o", color=color, markersize=4.5)
        speed_panel.set_title(
            f"{each.clip.source.prim.GetName()}: {len(kept)} of {truth.n_frames} samples kept",
            color=INK,
            size=11,
            weight="bold",
        )
        speed_panel.set_ylabel("mean speed of\nbone ends (cm/s)")
        speed_panel.tick_params(labelbottom=False)
        names = {"played, as slerp": (each.played, look("slerp").color), "rebuilt": (each.errors, color)}
        for name, (errors, line_color) in names.items():
            error_panel.plot(truth.times, errors.centimetres.max(axis=-1), color=line_color, linewidth=1.3, label=name)
        error_panel.set_ylabel("largest\nerror (cm)")
        error_panel.set_xlabel("seconds")
        error_panel.legend(frameon=False, ncols=2, loc="upper right", fontsize=9)
        for panel in (speed_panel, error_panel):
            panel.set_ylim(bottom=0.0)
            panel.margins(x=0.01)
            panel.spines[["top", "right"]].set_visible(False)
    return figure
