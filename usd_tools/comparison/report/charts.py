"""Charts: quality against rate, and error against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from usd_tools.comparison.report.scenes import Scene
from usd_tools.comparison.trials import Row
from usd_tools.figures.style import FAINT, INK, look, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 5
"""Clips side by side."""

BASE = "slerp"

_LEGEND_WIDTH = 1.75
"""Inches that the longest name in a legend takes."""

LABELS = {"loc": "$Q_{loc}$ (m²)", "rot": "$Q_{rot}$ (rad)", "hyb": "$Q_{hyb}$"}

Curves = Mapping[str, Mapping[float, float]]
"""Quality by rate, by scheme."""


def curves(rows: Sequence[Row], clip: str, kind: str, unseen: bool) -> dict[str, dict[float, float]]:
    """Pick quality by rate of every scheme for a clip; out of sample, that of what is learned to predict.

    What is learned freely from the first half is under its word with `, fitted` behind.
    """
    found: dict[str, dict[float, float]] = {}
    for row in rows:
        value = getattr(row, f"q_{kind}")
        if row.clip == clip and row.out_of_sample == unseen and value is not None:
            fitted = ", fitted" if unseen and row.purpose == "reconstruct" else ""
            found.setdefault(row.scheme + fitted, {})[row.rate] = value
    return found


def draw_quality(by_clip: Mapping[str, Curves], kind: str) -> Figure:
    """Draw quality against rate: a panel for each clip, and below it the same as a share of slerp's.

    Parameters
    ----------
    by_clip : mapping of str to Curves
    kind : str

    Returns
    -------
    figure : Figure
    """
    from matplotlib.figure import Figure

    words = list(dict.fromkeys(word for by_word in by_clip.values() for word in by_word))
    has_base = BASE in words and len(words) > 1
    n_columns = min(COLUMNS, len(by_clip))
    n_blocks = -(-len(by_clip) // n_columns)
    heights = ([3.0, 1.9] if has_base else [3.0]) * n_blocks
    figure = Figure(figsize=(2.9 * n_columns + 0.8, sum(heights) + 0.75), layout="constrained")
    axes = figure.subplots(len(heights), n_columns, squeeze=False, height_ratios=heights)
    for panel in axes.ravel():
        panel.set_visible(False)
    for i, (clip, by_word) in enumerate(by_clip.items()):
        block, column = divmod(i, n_columns)
        top = axes[block * len(heights) // n_blocks, column]
        _curves(top, by_word)
        _plain_log_axis(top)
        top.set_title(clip, color=INK, size=12, weight="bold")
        if has_base:
            below = axes[block * 2 + 1, column]
            _shares(below, by_word)
            below.set_xlabel("share of frames kept")
            top.set_xticklabels([])
        else:
            top.set_xlabel("share of frames kept")
        if column == 0:
            top.set_ylabel(f"{LABELS[kind]}, lower is better")
            if has_base:
                below.set_ylabel(f"against {BASE}")
    _legend(figure, [_line(word) for word in words])
    return figure


def _legend(figure: Figure, handles: Sequence[Any]) -> None:
    """Put a legend below, in as many rows as it takes."""
    n_columns = max(1, int(figure.get_figwidth() / _LEGEND_WIDTH))
    n_rows = -(-len(handles) // n_columns)
    figure.legend(handles=handles, loc="outside lower center", ncols=-(-len(handles) // n_rows), frameon=False)


def _style(word: str) -> dict[str, Any]:
    scheme, _, fitted = word.partition(", ")
    shown = look(scheme)
    dashes = (0, (1.0, 1.4)) if fitted else (0, (4.5, 1.6)) if shown.dashed or scheme == "linear" else "-"
    return {
        "color": shown.color,
        "marker": shown.marker,
        "ms": 5.5,
        "mec": "white",
        "mew": 0.7,
        "ls": dashes,
        "lw": 1.3 if fitted else 1.9,
        "alpha": 0.65 if fitted else 1.0,
        "zorder": 4 if scheme.startswith("geodesic") else 3,
    }


def _line(word: str) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], label=word, **_style(word))


def _tidy(axes: Axes) -> None:
    axes.set_visible(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(colors=FAINT, labelcolor=INK, which="both", labelsize=9)
    axes.grid(axis="y", color="#ececf1", lw=0.8, zorder=0)
    axes.set_axisbelow(True)


def _rate_axis(axes: Axes, rates: Sequence[float]) -> None:
    axes.set_xscale("log")
    axes.set_xticks(sorted(rates), [f"{rate:g}".removeprefix("0") for rate in sorted(rates)])
    axes.minorticks_off()


def _plain_log_axis(axes: Axes) -> None:
    """Make the vertical axis logarithmic, with figures as one writes them."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_yscale("log")
    low, high = axes.get_ylim()
    wide = high / low > 60.0
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _curves(axes: Axes, by_word: Curves) -> None:
    _tidy(axes)
    for word, by_rate in by_word.items():
        axes.plot(sorted(by_rate), [by_rate[rate] for rate in sorted(by_rate)], **_style(word))
    _rate_axis(axes, sorted({rate for by_rate in by_word.values() for rate in by_rate}))


def _shares(axes: Axes, by_word: Curves) -> None:
    """Draw what each scheme leaves of slerp's error, so that curves that are close can be told apart."""
    from matplotlib.ticker import PercentFormatter

    _tidy(axes)
    base, near = by_word[BASE], [1.0]
    for word, by_rate in by_word.items():
        rates = [rate for rate in sorted(by_rate) if base.get(rate)]
        shares = [by_rate[rate] / base[rate] for rate in rates]
        axes.plot(rates, shares, **_style(word))
        if word != "constant":
            near += shares
    low, high = min(near), min(max(near), 1.5)
    axes.set_ylim(low - 0.06 * (high - low) - 0.01, high + 0.06 * (high - low) + 0.01)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    _rate_axis(axes, sorted({rate for by_rate in by_word.values() for rate in by_rate}))


def draw_errors(scene: Scene) -> Figure:
    """Draw the mean distance of bone ends against time, and which frames are kept.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    figure : Figure
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    axes = figure.subplots()
    _tidy(axes)
    times = scene.times
    starts = np.cumsum([stretch.n_frames for stretch in scene.stretches])[:-1]
    for word, error in scene.errors.items():
        style = {**_style(word), "marker": None, "lw": 1.1 if word == "constant" else 1.8}
        for number, part in enumerate(np.split(np.arange(len(times)), starts)):
            axes.plot(times[part], error[part], label=None if number else word, **style)
    shown = [error for word, error in scene.errors.items() if word != "constant"] or list(scene.errors.values())
    high = 1.12 * max(max(error.max() for error in shown), 1e-6)
    axes.set(xlim=(times[0], times[-1]), ylim=(0.0, high))
    keys = times[scene.is_key]
    axes.plot(keys, np.zeros(len(keys)), "|", color=INK, ms=9, mew=1.4, clip_on=False, zorder=5, label="key")
    at = times[scene.most_different]
    axes.axvline(at, color=FAINT, lw=0.9, ls=(0, (2, 2)), zorder=1)
    axes.set_xlabel("seconds")
    axes.set_ylabel("mean distance of bone ends (cm)")
    title = f"{scene.name}, {percent(scene.rate)} of the frames kept"
    axes.set_title(title, loc="left", size=12, weight="bold", color=INK)
    _legend(figure, axes.get_legend_handles_labels()[0])
    return figure
