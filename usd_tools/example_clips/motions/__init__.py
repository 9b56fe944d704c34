"""The five motions, each described by key poses."""

from __future__ import annotations

from collections.abc import Callable

from usd_tools.example_clips.motions.jumping import jumping
from usd_tools.example_clips.motions.pitching import pitching
from usd_tools.example_clips.motions.punching import punching
from usd_tools.example_clips.motions.rolling import rolling
from usd_tools.example_clips.motions.sitting import sitting
from usd_tools.example_clips.posing import Motion

MOTIONS: dict[str, Callable[[], Motion]] = {
    "pitching": pitching,
    "rolling": rolling,
    "punching": punching,
    "jumping": jumping,
    "sitting": sitting,
}
"""Functions that make a motion, by its name."""
