"""Pictures of skeletons: schemes over the original, and what was learned over the rest pose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim.parameters import MAX_TENSION
from usd_tools.comparison.report.scenes import Scene, flattened
from usd_tools.comparison.trials import turning
from usd_tools.figures.style import FAINT, INK, TRUTH, look, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 4
"""Panels side by side."""

_LEFT, _RIGHT, _STILL = "#1d9a8a", "#f07f1b", "#dcdce4"


def draw_overlay(scene: Scene) -> Figure:
    """Draw every scheme over the original in the frame in which they differ most, one panel each.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    figure : Figure
    """
    from matplotlib.figure import Figure

    frame = scene.most_different
    truth = scene.points()[frame]
    poses = {word: scene.points(word)[frame] for word in scene.rebuilt}
    plane = flattened(np.stack([truth, *poses.values()]))
    flat = {word: pose @ plane for word, pose in poses.items()}
    original, drawn = truth @ plane, scene.bones.drawn
    near = [pose[drawn] for word, pose in flat.items() if word != "constant" or len(flat) == 1]
    low, high = _box([original[drawn], *near])

    n_columns = min(COLUMNS, len(flat) + 1)
    n_rows = -(-(len(flat) + 1) // n_columns)
    width, height = _panel_size(low, high, 3.0)
    height += 0.35
    figure = Figure(figsize=(width * n_columns, height * n_rows + 0.45), layout="constrained")
    axes = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
    for panel in axes:
        panel.set_axis_off()
    _stage(axes[0], low, high)
    _bones(axes[0], scene, original, TRUTH, 7.0)
    axes[0].set_title("original", size=11, weight="bold", color=FAINT)
    for panel, (word, pose) in zip(axes[1:], flat.items(), strict=False):
        _stage(panel, low, high)
        _bones(panel, scene, original, TRUTH, 7.0)
        panel.add_collection(_segments(np.stack([original, pose], axis=1)[drawn], FAINT, 0.8, zorder=2))
        _bones(panel, scene, pose, look(word).color, 2.6, joints=True)
        error = scene.errors[word][frame]
        panel.set_title(f"{word}   {error:.1f} cm", size=11, weight="bold", color=look(word).color)
    figure.suptitle(
        f"{scene.name}, frame {frame} of {len(scene.times)}, {percent(scene.rate)} of the frames kept",
        size=12,
        weight="bold",
        color=INK,
    )
    return figure


def draw_metrics(scene: Scene) -> Figure | None:
    """Draw what was learned over the rest pose: a row for each metric; None where nothing was learned.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    figure : Figure or None
    """
    from matplotlib.figure import Figure

    learned = {word: metric for word, metric in scene.metrics.items() if metric is not None}
    if not learned:
        return None
    joints = scene.compared.take.skeleton.joints
    metrics = {word: metric.for_joints(joints)[0] for word, metric in learned.items()}
    logs = [np.log2(values) for m in metrics.values() for values in (m.parameters.alpha, m.parameters.beta)]
    bound = max(1.0, float(np.max(np.abs(logs))))
    bends = any(metric.tension.any() or metric.translation_tension.any() for metric in metrics.values())
    points = scene.rest_points
    flat = points @ flattened(points)
    low, high = _box([flat[scene.bones.drawn]])
    n_columns = 4 if bends else 3
    width, height = _panel_size(low, high, 2.6)
    width = max(width, 1.9)
    figure = Figure(figsize=(width * n_columns + 0.4, (height + 0.1) * len(metrics) + 1.5), layout="constrained")
    axes = figure.subplots(len(metrics), n_columns, squeeze=False)
    turns, slides = turning(scene.stretches), _sliding(scene)
    for row, (word, metric) in zip(axes, metrics.items(), strict=True):
        for panel, values in zip(row, _values(metric, bound, bends), strict=True):
            _stage(panel, low, high)
            colors = [color if moving else _STILL for color, moving in zip(values, turns, strict=True)]
            _coloured_bones(panel, scene, flat, colors)
        if metric.translation_tension[slides].any():
            x, y = flat[np.flatnonzero(slides)].T
            row[3].scatter(x, y, c=_tension_colors(metric.translation_tension[slides]), s=110, edgecolors=INK, zorder=4)
        row[0].text(-0.02, 0.5, word, rotation=90, ha="right", va="center", weight="bold", color=look(word).color,
                    transform=row[0].transAxes, size=11)  # fmt: skip
    _legends(figure, axes, bound, bends)
    figure.suptitle(
        f"{scene.name}: learned with {percent(scene.rate)} of the frames kept", size=12, weight="bold", color=INK
    )
    return figure


def _values(metric: LearnedMetric, bound: float, bends: bool) -> list[list[Any]]:
    """Colours of all joints, panel by panel."""
    from matplotlib import colormaps

    parameters = metric.parameters
    panels: list[list[Any]] = [
        list(colormaps["coolwarm"](0.5 + 0.5 * np.log2(values) / bound))
        for values in (parameters.alpha, parameters.beta)
    ]
    panels.append([_RIGHT if side == "right" else _LEFT for side in parameters.invariance])
    if bends:
        panels.append(_tension_colors(metric.tension) if metric.tension.any() else [_STILL] * len(metric.joints))
    return panels


def _tension_colors(tension: np.ndarray) -> list[Any]:
    from matplotlib import colormaps

    return list(colormaps["viridis_r"](tension / MAX_TENSION))


def _sliding(scene: Scene) -> np.ndarray:
    """Return which joints move in their parents, shape=[B]; noise of the file's precision is no motion."""
    places = np.concatenate([stretch.translations for stretch in scene.stretches])
    size = np.abs(scene.compared.take.skeleton.bone_ends).max(initial=1e-3)
    return (np.ptp(places, axis=0) > 1e-4 * size).any(axis=-1)


def _legends(figure: Figure, axes: np.ndarray, bound: float, bends: bool) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.lines import Line2D

    scales = [("coolwarm", -bound, bound, axes[:, :2])]
    if bends:
        scales.append(("viridis_r", 0.0, MAX_TENSION, axes[:, 3:]))
    for name, low, high, panels in scales:
        mappable = ScalarMappable(Normalize(low, high), colormaps[name])
        aspect = 14.0 * panels.shape[1]
        bar = figure.colorbar(mappable, ax=list(panels.ravel()), location="bottom", shrink=0.8, aspect=aspect, pad=0.02)
        bar.outline.set_visible(False)
        bar.ax.tick_params(labelsize=9, colors=FAINT, labelcolor=INK)
    for panel, title in zip(axes[0], (r"$\log_2\,\alpha$", r"$\log_2\,\beta$", "side", "tension"), strict=False):
        panel.set_title(title, size=11, color=INK)
    dots = {"left": _LEFT, "right": _RIGHT, "does not turn": _STILL}
    handles = [Line2D([], [], color=color, lw=4.0, label=name) for name, color in dots.items()]
    axes[-1, 2].legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=1, frameon=False)


def _panel_size(low: np.ndarray, high: np.ndarray, longest: float) -> tuple[float, float]:
    """Width and height in inches of a panel that a skeleton fills."""
    size = high - low
    width, height = longest * size / size.max()
    return max(float(width), 0.7 * longest), max(float(height), 0.5 * longest)


def _box(points: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return corners around points, with a margin; around the origin if there are none."""
    every = np.concatenate(points)
    if not len(every):  # no bone has a length
        every = np.zeros((1, 2))
    low, high = every.min(axis=0), every.max(axis=0)
    margin = 0.06 * max(float((high - low).max()), 1e-3)
    return low - margin, high + margin


def _stage(axes: Axes, low: np.ndarray, high: np.ndarray) -> None:
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal", anchor="N")
    axes.set_axis_off()


def _segments(segments: np.ndarray, color: Any, width: float, zorder: float) -> Any:
    from matplotlib.collections import LineCollection

    return LineCollection(list(segments), colors=color, linewidths=width, capstyle="round", zorder=zorder)


def _bones(axes: Axes, scene: Scene, points: np.ndarray, color: str, width: float, joints: bool = False) -> None:
    axes.add_collection(_segments(points[scene.bones.lines], color, width, zorder=3 if joints else 1))
    if joints:
        drawn = scene.bones.drawn
        origins = points[drawn[drawn < scene.compared.take.skeleton.n_joints]]
        axes.plot(*origins.T, "o", color=color, mec="white", mew=0.6, ms=4.2, zorder=4)


def _coloured_bones(axes: Axes, scene: Scene, points: np.ndarray, colors: list[Any]) -> None:
    axes.add_collection(_segments(points[scene.bones.lines], FAINT, 6.6, zorder=1))
    axes.add_collection(_segments(points[scene.bones.lines], [colors[b] for b in scene.bones.owners], 5.4, zorder=2))
    joints = scene.bones.drawn[scene.bones.drawn < len(colors)]
    x, y = points[joints].T
    axes.scatter(x, y, c=[colors[joint] for joint in joints], s=34, edgecolors=FAINT, linewidths=0.6, zorder=3)
