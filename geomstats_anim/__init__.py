"""Interpolate, upsample and compress skeletal animation along geodesics of invariant metrics on SO(3)^B.

What plugs into Geomstats, and what learns, is imported on first use: Geomstats alone takes seconds.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from geomstats_anim._version import __version__
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.criteria import quality
from geomstats_anim.geodesics.pose_geodesics import LogResult, LogStatus
from geomstats_anim.interpolation.schemes import SCHEMES, FallbackWarning, interpolate
from geomstats_anim.keyframes.problem import optimal_keyframes, uniform_keyframes
from geomstats_anim.parameters import LearnedMetric, MetricParameters

if TYPE_CHECKING:
    from geomstats_anim.learning import Compressed, compress, learn_metric
    from geomstats_anim.riemannian.pose import PoseMetric, PoseSpace, SO3InvariantMetric

__all__ = [
    "SCHEMES",
    "Animation",
    "Compressed",
    "FallbackWarning",
    "LearnedMetric",
    "LogResult",
    "LogStatus",
    "MetricParameters",
    "PoseMetric",
    "PoseSpace",
    "SO3InvariantMetric",
    "Skeleton",
    "__version__",
    "compress",
    "interpolate",
    "learn_metric",
    "optimal_keyframes",
    "quality",
    "uniform_keyframes",
]

_ON_FIRST_USE = {
    "PoseMetric": "geomstats_anim.riemannian.pose",
    "PoseSpace": "geomstats_anim.riemannian.pose",
    "SO3InvariantMetric": "geomstats_anim.riemannian.pose",
    "Compressed": "geomstats_anim.learning",
    "compress": "geomstats_anim.learning",
    "learn_metric": "geomstats_anim.learning",
}


def __getattr__(name: str) -> Any:
    if name in _ON_FIRST_USE:
        return getattr(import_module(_ON_FIRST_USE[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
