"""Results of `learn`, as plain values and metrics."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomstats_anim._version import __version__

if TYPE_CHECKING:
    from geomstats_anim import LearnedMetric

TOOL = "usd_tools.learn"


@dataclass(frozen=True)
class Skipped:
    """A file or an animation that is not learned from, and why."""

    file: str
    reason: str


@dataclass(frozen=True, eq=False)
class MetricReport:
    """One metric that was learned.

    Parameters
    ----------
    metric : LearnedMetric
    clips : tuple of str
        Names of the clips that it was learned from.
    summary : str
        The metric in one line.
    scheme : str
    quality : str
        "loc", "rot" or "hyb".
    animations : tuple of dict
        Of each clip: file, sha256, prim, frames, stretches (parted at value blocks, steps and cuts).
    scores : tuple of dict
        what, in_sample, score, slerp_score, plain_score (what upsample does without a metric), gain (share of the
        better of these two), verdict.
    conclusion : str
        What the metric is good for, a sentence or two.
    joints : tuple of dict
        joint, alpha, beta, axes (rotation vector or null), invariance, tension, translation_tension, and in degrees,
        null for a joint that does not turn, error, slerp_error, gain (in-sample).
    slerped_segments : int
        Segments of single joints whose geodesic was not found.
    provenance : dict
        What is stored with the metric.
    skating : dict
        Of "learned", "plain" (the spline) and "slerp": skate_cm_per_second and floating_cm of the points that are
        planted on the ground in the clips (in-sample). Empty where nothing is planted.
    """

    metric: LearnedMetric
    clips: tuple[str, ...]
    summary: str
    scheme: str
    quality: str
    animations: tuple[dict[str, Any], ...]
    scores: tuple[dict[str, Any], ...]
    conclusion: str
    joints: tuple[dict[str, Any], ...]
    slerped_segments: int
    provenance: dict[str, Any]
    skating: dict[str, dict[str, float]]

    def as_dict(self) -> dict[str, Any]:
        """Return all but the metric itself, as plain values."""
        values = {name: value for name, value in vars(self).items() if name not in ("metric", "clips")}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


@dataclass(frozen=True)
class LibraryReport:
    """A library that was learned.

    Parameters
    ----------
    clips : tuple of str
        Names of the clips that it was learned from.
    frames : int
        In all clips.
    parts : tuple of dict
        Parts of the body: part ("torso", "arm", "leg", "limb") and its joints.
    gaps : tuple of float
        Seconds between keys that it was learned for.
    bytes : int
        Size of the file.
    sha256 : str
        Of the file.
    """

    clips: tuple[str, ...]
    frames: int
    parts: tuple[dict[str, Any], ...]
    gaps: tuple[float, ...]
    bytes: int
    sha256: str


@dataclass(frozen=True, eq=False)
class LearnResult:
    """Result of `learn`.

    Parameters
    ----------
    path : Path or None
        File that was written; None for an open stage.
    output : str
        Its name, or that of the layer that was edited.
    settings : dict
        Options that were asked for, plain values.
    metrics : tuple of MetricReport
        One for each animation of a USD file or stage; one for all in a JSON file.
    skipped : tuple of Skipped
    warnings : tuple of str
    library : LibraryReport or None
        Instead of metrics.
    """

    path: Path | None
    output: str
    settings: dict[str, Any]
    metrics: tuple[MetricReport, ...]
    skipped: tuple[Skipped, ...]
    warnings: tuple[str, ...]
    library: LibraryReport | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": TOOL,
            "version": __version__,
            "output": self.output,
            "settings": self.settings,
            "metrics": [each.as_dict() for each in self.metrics],
            **({} if self.library is None else {"library": asdict(self.library)}),
            "skipped": [asdict(each) for each in self.skipped],
            "warnings": list(self.warnings),
        }
