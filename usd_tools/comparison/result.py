"""Result of `compare`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomstats_anim._version import __version__

if TYPE_CHECKING:
    from usd_tools.comparison.distortion import RateDistortion
    from usd_tools.comparison.trials import Row

TOOL = "usd_tools.compare"


@dataclass(frozen=True)
class CompareResult:
    """Result of `compare`.

    Parameters
    ----------
    path : Path
        Folder that was written.
    settings : dict
        Options that were asked for, plain values.
    clips : tuple of dict
        clip, file, sha256, prim, frames, joints, stretches.
    skipped : tuple of dict
        file, reason.
    warnings : tuple of str
    rows : tuple of Row
        Scores of each scheme, rate and clip, in and out of sample.
    rate_distortion : tuple of RateDistortion
        Bytes of each method, tolerance and clip.
    """

    path: Path
    settings: dict[str, Any]
    clips: tuple[dict[str, Any], ...]
    skipped: tuple[dict[str, str], ...]
    warnings: tuple[str, ...]
    rows: tuple[Row, ...]
    rate_distortion: tuple[RateDistortion, ...] = ()

    @property
    def head(self) -> dict[str, Any]:
        """All but the rows, plain values."""
        return {
            "tool": TOOL,
            "version": __version__,
            "settings": self.settings,
            "clips": list(self.clips),
            "skipped": list(self.skipped),
            "warnings": list(self.warnings),
        }

    def as_dict(self) -> dict[str, Any]:
        """Return the content of results.json."""
        found = {"rows": [asdict(row) for row in self.rows]}
        if self.rate_distortion:
            found["rate_distortion"] = [asdict(point) for point in self.rate_distortion]
        return {**self.head, **found}
