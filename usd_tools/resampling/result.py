"""Result of `resample`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from usd_tools.upsampling.result import UpsampleResult


@dataclass(frozen=True)
class ResampleResult(UpsampleResult):
    """Result of `resample`, with the same fields as that of `upsample`."""

    tool: ClassVar[str] = "usd_tools.resample"
