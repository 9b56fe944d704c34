"""Results of `downsample`, as plain values."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from geomstats_anim._version import __version__

TOOL = "usd_tools.downsample"

Statistics = dict[str, float]
"""mean, percentile_99 and largest."""


@dataclass(frozen=True)
class DownsampledAnimation:
    """Result for one animation.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation.
    skeletons : tuple of str
        Paths of the Skeletons that it drives.
    samples, kept_samples : int
    kept_time_codes : tuple of float
    scheme : str
    metric_summary : str
        "" if there are no joints.
    constant : tuple of str
        Attributes that never change, and became one value.
    kept_whole : tuple of str
        Attributes that change and keep all samples.
    weights : dict or None
        Of the weights of blend shapes, if they change: samples, kept_samples, tolerance, and the largest_error that
        `upsample --times source` leaves.
    rebuilt, played : dict
        Errors of what `upsample --times source` rebuilds, and of what viewers show: degrees and centimetres
        (statistics), q_loc, q_rot, q_hyb.
    joints : tuple of dict
        joint, degrees, centimetres (statistics).
    largest_rotation_error : dict
        joint, degrees, time_code.
    bytes_usdc_before, bytes_usdc_after, bytes_numpy_before, bytes_numpy_after : int
    uniform_slerp : dict
        What slerp between equally spaced samples needs to be as good: criterion, samples, bytes_usdc, bytes_numpy.
    """

    prim: str
    skeletons: tuple[str, ...]
    samples: int
    kept_samples: int
    kept_time_codes: tuple[float, ...]
    scheme: str
    metric_summary: str
    constant: tuple[str, ...]
    kept_whole: tuple[str, ...]
    weights: dict[str, Any] | None
    rebuilt: dict[str, Any]
    played: dict[str, Any]
    joints: tuple[dict[str, Any], ...]
    largest_rotation_error: dict[str, Any]
    bytes_usdc_before: int
    bytes_usdc_after: int
    bytes_numpy_before: int
    bytes_numpy_after: int
    uniform_slerp: dict[str, Any]


@dataclass(frozen=True)
class DownsampleResult:
    """Result of `downsample`.

    Parameters
    ----------
    source : str
        Name of the file, or of the stage's root layer.
    path : Path or None
        File that was written; None for an open stage.
    output : str
        Its name, or that of the layer that was edited.
    settings : dict
        Options that were asked for, plain values.
    file_bytes_before, file_bytes_after : int or None
        None for an open stage.
    animations : tuple of DownsampledAnimation
    warnings : tuple of str
    dependencies : str
        Sentence without its dot on the other files that the output needs; "" for an open stage.
    """

    source: str
    path: Path | None
    output: str
    settings: dict[str, Any]
    file_bytes_before: int | None
    file_bytes_after: int | None
    animations: tuple[DownsampledAnimation, ...]
    warnings: tuple[str, ...]
    dependencies: str = ""

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        kept = sum(animation.kept_samples for animation in self.animations)
        samples = sum(animation.samples for animation in self.animations)
        return f"{kept} of {samples} samples kept"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": TOOL,
            "version": __version__,
            "source": self.source,
            "output": self.output,
            "settings": self.settings,
            "file_bytes_before": self.file_bytes_before,
            "file_bytes_after": self.file_bytes_after,
            "animations": [asdict(animation) for animation in self.animations],
            "warnings": list(self.warnings),
        }
