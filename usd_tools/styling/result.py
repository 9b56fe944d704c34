"""Results of `metric`, as metrics and as plain values."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomstats_anim._version import __version__
from usd_tools.console.text import counted

if TYPE_CHECKING:
    from geomstats_anim import LearnedMetric

TOOL = "usd_tools.metric"


@dataclass(frozen=True, eq=False)
class AnimationMetric:
    """The metric of one animation.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation.
    metric : LearnedMetric or None
        None if none is stored.
    problems : tuple of str
        What is wrong with what is stored, a sentence each.
    """

    prim: str
    metric: LearnedMetric | None
    problems: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return plain values, the metric as its JSON has it."""
        metric = None if self.metric is None else json.loads(self.metric.to_json())
        return {"prim": self.prim, "metric": metric, "problems": list(self.problems)}


@dataclass(frozen=True, eq=False)
class MetricResult:
    """Metrics that were shown or written.

    Parameters
    ----------
    source : str
        Name of the file, or of the stage's root layer.
    path : Path or None
        File that was written; None for an open stage, or if nothing was to be written.
    output : str or None
        Its name, or that of the layer that was edited.
    settings : dict
        Options that were asked for, plain values.
    animations : tuple of AnimationMetric
    warnings : tuple of str
    """

    source: str
    path: Path | None
    output: str | None
    settings: dict[str, Any]
    animations: tuple[AnimationMetric, ...]
    warnings: tuple[str, ...]

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        return f"metric of {counted(len(self.animations), 'animation')}"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report` and `--json`."""
        return {
            "tool": TOOL,
            "version": __version__,
            "source": self.source,
            "output": self.output,
            "settings": self.settings,
            "animations": [animation.as_dict() for animation in self.animations],
            "warnings": list(self.warnings),
        }
