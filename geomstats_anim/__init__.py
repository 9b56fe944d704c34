"""Interpolate, upsample and compress skeletal animation along geodesics of invariant metrics on SO(3)^B.

Every name is imported on first use, since NumPy, SciPy, Numba and Geomstats each take long to load.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from geomstats_anim._version import __version__

if TYPE_CHECKING:
    from geomstats_anim.animation import Animation, Skeleton
    from geomstats_anim.criteria import quality
    from geomstats_anim.geodesics.pose_geodesics import LogResult, LogStatus
    from geomstats_anim.interpolation.schemes import SCHEMES, FallbackWarning, interpolate
    from geomstats_anim.keyframes.problem import optimal_keyframes, uniform_keyframes
    from geomstats_anim.learned_metric import LearnedMetric
    from geomstats_anim.learning.compression import Compressed, compress
    from geomstats_anim.learning.learn import learn_metric
    from geomstats_anim.learning.library.learn_library import learn_library
    from geomstats_anim.learning.library.motion_library import MotionLibrary
    from geomstats_anim.parameters import MetricParameters
    from geomstats_anim.riemannian.pose import PoseMetric, PoseSpace
    from geomstats_anim.riemannian.so3 import SO3InvariantMetric

__all__ = [
    "SCHEMES",
    "Animation",
    "Compressed",
    "FallbackWarning",
    "LearnedMetric",
    "LogResult",
    "LogStatus",
    "MetricParameters",
    "MotionLibrary",
    "PoseMetric",
    "PoseSpace",
    "SO3InvariantMetric",
    "Skeleton",
    "__version__",
    "compress",
    "interpolate",
    "learn_library",
    "learn_metric",
    "optimal_keyframes",
    "quality",
    "uniform_keyframes",
]

_MODULES = {
    "animation": ("Animation", "Skeleton"),
    "criteria": ("quality",),
    "geodesics.pose_geodesics": ("LogResult", "LogStatus"),
    "interpolation.schemes": ("SCHEMES", "FallbackWarning", "interpolate"),
    "keyframes.problem": ("optimal_keyframes", "uniform_keyframes"),
    "learned_metric": ("LearnedMetric",),
    "learning.compression": ("Compressed", "compress"),
    "learning.learn": ("learn_metric",),
    "learning.library.learn_library": ("learn_library",),
    "learning.library.motion_library": ("MotionLibrary",),
    "parameters": ("MetricParameters",),
    "riemannian.pose": ("PoseMetric", "PoseSpace"),
    "riemannian.so3": ("SO3InvariantMetric",),
}
_MODULE_OF = {name: f"{__name__}.{module}" for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_MODULE_OF[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
