"""The five motions, each described by key poses."""

from __future__ import annotations

from collections.abc import Callable

from posing import Motion

from motions.jumping import jumping
from motions.pitching import pitching
from motions.punching import punching
from motions.rolling import rolling
from motions.sitting import sitting

MOTIONS: dict[str, Callable[[], Motion]] = {
    "pitching": pitching,
    "rolling": rolling,
    "punching": punching,
    "jumping": jumping,
    "sitting": sitting,
}
"""Functions that make a motion, by its name."""
