"""Edit the in-betweens of a clip: a session of small edits, without a user interface."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from usd_tools.editing.session import EditSession

__all__ = ["EditSession"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("usd_tools.editing.session"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
