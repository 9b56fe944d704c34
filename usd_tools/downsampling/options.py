"""Options of `downsample`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from geomstats_anim.names import (
    CRITERIA,
    DEFAULT_SCHEME,
    FAMILIES,
    LARGEST,
    MEASURES,
    OWN_SCHEMES,
    SELECTIONS,
    SHELL_RADIUS,
    WEIGHTS_TOLERANCE,
    WITH_METRIC,
)
from usd_tools.console.arguments import TimeCodes, as_time_codes, positive_number, share, whole_number
from usd_tools.console.errors import UsageError
from usd_tools.console.options import OutputOptions, one_of, option


@dataclass(frozen=True, kw_only=True)
class DownsampleOptions(OutputOptions):
    """Options of `downsample`, in the words of its command line; exactly one of the first four is needed.

    The first four are about joints.

    Parameters
    ----------
    rate : float
        Share of the samples to keep, above 0 and below 1.
    keys : int
        Number of samples to keep, of each animation.
    tolerance : float
        Centimetres in the world: the fewest samples are kept with which no measured point is further from its place.
    keep_only : str, TimeCodes or sequence of float
        Time codes of the samples to keep, exactly these and the ends of stretches between cuts.
    weights_tolerance : float
        The fewest samples of blend shape weights are kept with which no weight is further from its value, whatever
        decides about joints.
        Optional, default: 0.01.
    measure : str
        Points that the tolerance is about: "ends", the joints and the ends of their bones; "shell", points around the
        joints too, which twists move; "skin", the points of the meshes that the skeleton deforms too.
        Optional, default: "shell".
    shell : float
        Distance of a shell from the joints, centimetres.
        Optional, default: 3.
    select : str
        "optimal" or "uniform".
        Optional, default: "optimal".
    keep : str, TimeCodes or sequence of float
        Time codes of samples that must stay.
    scheme : str
        Interpolation scheme that rebuilds the rest.
        Optional, default: "geodesic-spline".
    family : str
        "diagonal" or "spd".
        Optional, default: "spd", or "diagonal" with a tolerance.
    kind : str
        Criterion of `rate`, `keys` and `keep_only`: "loc", "rot", "hyb" or "max".
        Optional, default: "hyb".
    contacts : bool
        Store what is planted on the ground, and when, for `upsample --contacts`.
    picture : Path
        Picture of the samples kept, .png, .svg or .pdf.
        Optional, default: none.
    """

    rate: float | None = option(None, share)
    keys: int | None = option(None, whole_number)
    tolerance: float | None = option(None, positive_number)
    keep_only: TimeCodes | None = option(None, as_time_codes)
    weights_tolerance: float = option(WEIGHTS_TOLERANCE, positive_number)
    measure: str | None = option(None, one_of(MEASURES))
    shell: float | None = option(None, positive_number)
    select: str = option(SELECTIONS[0], one_of(SELECTIONS))
    keep: TimeCodes | None = option(None, as_time_codes)
    scheme: str = option(DEFAULT_SCHEME, one_of(OWN_SCHEMES))
    family: str | None = option(None, one_of(FAMILIES))
    kind: str | None = option(None, one_of(CRITERIA))
    contacts: bool = option(False, bool)
    picture: Path | None = option(None, Path, recorded=False)

    def check(self) -> None:
        """Refuse values that do not go together."""
        words = ("rate", "keys", "tolerance", "keep_only")
        given = [f"--{word.replace('_', '-')}" for word in words if getattr(self, word) is not None]
        if len(given) != 1:
            raise UsageError(
                f"name exactly one of --rate, --keys, --tolerance and --keep-only, not {' and '.join(given) or 'none'}"
            )
        if self.keep_only is not None and (self.keep is not None or self.select == "uniform"):
            raise UsageError("--keep-only names all the samples to keep; leave out --keep and --select")
        if self.tolerance is not None and self.kind not in (None, LARGEST):
            raise UsageError(f"--kind {self.kind} needs --rate or --keys; --tolerance always uses the largest distance")
        if self.measure is not None and self.criterion != LARGEST:
            raise UsageError(f"--measure {self.measure} goes with --tolerance or --kind {LARGEST}")
        if self.shell is not None and self.measured != "shell":
            raise UsageError("--shell goes with --tolerance and --measure shell")
        if self.keep is not None and self.select == "uniform":
            raise UsageError("--keep needs --select optimal")
        if self.family is not None and self.scheme not in WITH_METRIC:
            raise UsageError(
                f"--scheme {self.scheme} has no metric, so it has no family; leave out --family {self.family}"
            )

    @property
    def measured(self) -> str:
        """Points that errors are about."""
        return self.measure or ("shell" if self.criterion == LARGEST else "ends")

    @property
    def shell_centimetres(self) -> float:
        """Distance of a shell from the joints."""
        return 100.0 * SHELL_RADIUS if self.shell is None else self.shell

    @property
    def criterion(self) -> str:
        """Kind of quality for comparisons at equal error: "max" for a tolerance."""
        return self.kind or ("hyb" if self.tolerance is None else LARGEST)
