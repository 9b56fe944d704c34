"""Summary that `metric` prints: a table of the joints of each metric, and what was written."""

from __future__ import annotations

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim.parameters import CurveParameters
from usd_tools.console.tables import show
from usd_tools.console.text import counted, say, short_names
from usd_tools.metrics.attributes import summary
from usd_tools.styling.result import MetricResult

HEADER = ("joint", "alpha", "beta", "axes, degrees", "side", "tension", "of translations")


def print_metrics(result: MetricResult) -> None:
    """Print a table for each animation, and what is wrong with its metric."""
    for animation in result.animations:
        if animation.metric is None:
            say(f"{animation.prim}: {'the metric cannot be read.' if animation.problems else 'no metric is stored.'}")
        else:
            rows = joint_rows(animation.metric)
            show(f"{animation.prim}: {summary(animation.metric)}", rows, HEADER)
            if len(rows) < len(animation.metric.joints):
                others = counted(len(animation.metric.joints) - len(rows), "other joint" if rows else "joint")
                say(f"{others} as {animation.metric.scheme} has them without a metric.")
        for problem in animation.problems:
            say(problem)


def print_written(result: MetricResult) -> None:
    """Print a line for each animation, and one on what was written."""
    for animation in result.animations:
        assert animation.metric is not None
        say(f"{animation.prim}: {summary(animation.metric)}")
    say(f"Wrote {result.path}.")


def joint_rows(metric: LearnedMetric) -> list[tuple[str, ...]]:
    """Return a row for each joint that has something of its own."""
    names, usual = short_names(metric.joints), CurveParameters.plain(metric.scheme, 1)
    tension, translation_tension = float(usual.tension[0]), float(usual.translation_tension[0])
    parameters = metric.parameters
    rows: list[tuple[str, ...]] = []
    for i, joint in enumerate(metric.joints):
        axes = np.zeros(3) if parameters.axes is None else np.degrees(parameters.axes[i])
        row = (
            f"{parameters.alpha[i]:.4g}",
            f"{parameters.beta[i]:.4g}",
            ", ".join(f"{angle:.3g}" for angle in axes) if axes.any() else "own",
            parameters.invariance[i],
            f"{metric.tension[i]:.4g}",
            f"{metric.translation_tension[i]:.4g}",
        )
        if row != ("1", "1", "own", "left", f"{tension:.4g}", f"{translation_tension:.4g}"):
            rows.append((names[joint], *row))
    return rows
