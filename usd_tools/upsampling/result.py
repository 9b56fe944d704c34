"""Results of `upsample`, as plain values."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar

from geomstats_anim._version import __version__
from usd_tools.console.text import counted


@dataclass(frozen=True)
class KeptContacts:
    """Points of one animation that stay planted.

    Parameters
    ----------
    joints : tuple of str
        Where they are.
    kept, left : int
        Times that a point is planted between two samples, and times that it is left to lift.
    largest_cm : float
        The longest way by which a point is moved.
    largest_degrees : float
        The largest turn of a joint for it.
    """

    joints: tuple[str, ...] = ()
    kept: int = 0
    left: int = 0
    largest_cm: float = 0.0
    largest_degrees: float = 0.0


@dataclass(frozen=True)
class UpsampledAnimation:
    """Result for one animation.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation.
    skeletons : tuple of str
        Paths of the Skeletons that it drives.
    joints : int
    scheme : str
    metric : str or None
        "stored", "identity", "learned" or the name of a file; None for a scheme without metric.
    metric_summary : str or None
    styles : tuple of str
        Settings by hand that the metric has.
    learned : str
        What learning brought, a sentence; "" if nothing was learned.
    library : dict or None
        For the scheme "learned": file, sha256, and shares: a list of part, joint and share of the library's prediction
        that is used, by part of the body.
    joints_without_metric : tuple of str
        Joints of which the metric has no entry, so that they have the identity.
    samples_before, samples_after : int
    rate_before, rate_after : float
        Usual number of samples per second.
    first_time_code, last_time_code : float
    channels : dict
        Of each attribute: samples_before, samples_after, value_blocks.
    stepped_pairs : int
    cuts : tuple of dict
        Gaps between samples in which the pose is held: start, end (time codes).
    xforms : tuple of dict
        Transform ops that got samples as well: attribute (path), samples_before, samples_after.
    largest_step : dict or None
        joint, start, end (time codes), degrees.
    wide_steps : tuple of dict
        Likewise, the steps of more than 120 degrees.
    fallbacks : tuple of dict
        Segments that are slerped because their geodesic was not found: joint, start, end, status, sentence.
    contacts : KeptContacts or None
        None if they were not asked for.
    """

    prim: str
    skeletons: tuple[str, ...]
    joints: int
    scheme: str
    metric: str | None
    metric_summary: str | None
    styles: tuple[str, ...]
    learned: str
    library: dict[str, Any] | None
    joints_without_metric: tuple[str, ...]
    samples_before: int
    samples_after: int
    rate_before: float
    rate_after: float
    first_time_code: float
    last_time_code: float
    channels: dict[str, dict[str, int]]
    stepped_pairs: int
    cuts: tuple[dict[str, float], ...]
    xforms: tuple[dict[str, Any], ...]
    largest_step: dict[str, Any] | None
    wide_steps: tuple[dict[str, Any], ...]
    fallbacks: tuple[dict[str, Any], ...]
    contacts: KeptContacts | None = None


@dataclass(frozen=True)
class UpsampleResult:
    """Result of `upsample`.

    Parameters
    ----------
    source : str
        Name of the file, or of the stage's root layer.
    path : Path or None
        File that was written; None for a dry run or an open stage.
    output : str or None
        Its name, or that of the layer that was edited.
    settings : dict
        Options that were asked for, plain values.
    time_codes_per_second : float
        Of the output.
    animations : tuple of UpsampledAnimation
    warnings : tuple of str
    advice : str
        Sentence on a better frame rate, "" where there is none.
    dependencies : str
        Sentence on the other files that a flattened output needs, else "".
    """

    tool: ClassVar[str] = "usd_tools.upsample"

    source: str
    path: Path | None
    output: str | None
    settings: dict[str, Any]
    time_codes_per_second: float
    animations: tuple[UpsampledAnimation, ...]
    warnings: tuple[str, ...]
    advice: str = ""
    dependencies: str = ""

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        before = sum(animation.samples_before for animation in self.animations)
        after = sum(animation.samples_after for animation in self.animations)
        several = f" of {counted(len(self.animations), 'animation')}" if len(self.animations) > 1 else ""
        return f"{before} -> {after} samples{several}"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": self.tool,
            "version": __version__,
            "source": self.source,
            "output": self.output,
            "settings": self.settings,
            "time_codes_per_second": self.time_codes_per_second,
            "animations": [asdict(animation) for animation in self.animations],
            "warnings": list(self.warnings),
        }
