"""Results of `pack` and `unpack`, as plain values."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from geomstats_anim._version import __version__

PACK = "usd_tools.pack"
UNPACK = "usd_tools.unpack"


@dataclass(frozen=True)
class PackedAnimation:
    """Result of `pack` for one animation.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation.
    skeletons : tuple of str
        Paths of the Skeletons that it drives.
    samples, joints : int
    packed : tuple of str
        Attributes that move, and are packed.
    xforms : tuple of str
        Transforms that are packed with them.
    constant : tuple of str
        Attributes that never change, and are one value.
    preview_time_codes : tuple of float
        Samples that stay for viewers.
    bytes_packed : int
        Of the stream.
    bytes_usdc, bytes_numpy : int
        Of the source: as a usdc file of this animation alone, and as the papers count.
    errors : dict
        centimetres and degrees (mean, percentile_99, largest), jitter_centimetres (per frame squared), scales and
        weights (largest differences, or None).
    """

    prim: str
    skeletons: tuple[str, ...]
    samples: int
    joints: int
    packed: tuple[str, ...]
    xforms: tuple[str, ...]
    constant: tuple[str, ...]
    preview_time_codes: tuple[float, ...]
    bytes_packed: int
    bytes_usdc: int
    bytes_numpy: int
    errors: dict[str, Any]


@dataclass(frozen=True)
class UnpackedAnimation:
    """Result of `unpack` for one animation.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation.
    samples, joints : int
    time_codes : tuple of float
        The first and the last.
    """

    prim: str
    samples: int
    joints: int
    time_codes: tuple[float, float]


@dataclass(frozen=True)
class PackResult:
    """Result of `pack`.

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
    animations : tuple of PackedAnimation
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
    animations: tuple[PackedAnimation, ...]
    warnings: tuple[str, ...]
    dependencies: str = ""

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        packed = sum(animation.bytes_packed for animation in self.animations)
        largest = max(animation.errors["centimetres"]["largest"] for animation in self.animations)
        return f"packed into {packed} bytes, largest error {largest:.3g} cm"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return _report(PACK, self)


@dataclass(frozen=True)
class UnpackResult:
    """Result of `unpack`; see `PackResult`.

    Parameters
    ----------
    source : str
    path : Path or None
    output : str
    settings : dict
    file_bytes_before, file_bytes_after : int or None
    animations : tuple of UnpackedAnimation
    warnings : tuple of str
    dependencies : str
    """

    source: str
    path: Path | None
    output: str
    settings: dict[str, Any]
    file_bytes_before: int | None
    file_bytes_after: int | None
    animations: tuple[UnpackedAnimation, ...]
    warnings: tuple[str, ...]
    dependencies: str = ""

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""
        return f"{sum(animation.samples for animation in self.animations)} samples unpacked"

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return _report(UNPACK, self)


def _report(tool: str, result: PackResult | UnpackResult) -> dict[str, Any]:
    return {
        "tool": tool,
        "version": __version__,
        "source": result.source,
        "output": result.output,
        "settings": result.settings,
        "file_bytes_before": result.file_bytes_before,
        "file_bytes_after": result.file_bytes_after,
        "animations": [asdict(animation) for animation in result.animations],
        "warnings": list(result.warnings),
    }
