"""Learning the metric whose geodesics rebuild an animation best from few of its frames, and which frames those are.

Its parts are imported on first use, so that `learning.tune.settings` can be read without them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geomstats_anim.learning.compression import Compressed, compress
    from geomstats_anim.learning.learn import learn_metric

__all__ = ["Compressed", "compress", "learn_metric"]

_PLACES = {"Compressed": "compression", "compress": "compression", "learn_metric": "learn"}


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
