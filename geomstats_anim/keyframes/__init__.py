"""Choosing which frames to keep as keys."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geomstats_anim.keyframes.problem import optimal_keyframes, uniform_keyframes

__all__ = ["optimal_keyframes", "uniform_keyframes"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("geomstats_anim.keyframes.problem"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
