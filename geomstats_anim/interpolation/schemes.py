"""All interpolation schemes by name, and `interpolate`."""

from __future__ import annotations

import warnings

from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation
from geomstats_anim.interpolation.curves import Curve, Metric
from geomstats_anim.interpolation.learned_scheme import Help, Learned, Library
from geomstats_anim.interpolation.metric_schemes import Geodesic, GeodesicSpline
from geomstats_anim.interpolation.plain_schemes import Constant, Linear, RotationSpline, Slerp, Squad
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.names import DEFAULT_SCHEME, LEARNED


class FallbackWarning(UserWarning):
    """Some segments are slerped because their geodesic was not found."""


SCHEMES: dict[str, type[Curve]] = {
    "constant": Constant,
    "linear": Linear,
    "slerp": Slerp,
    "squad": Squad,
    "rotation-spline": RotationSpline,
    "geodesic": Geodesic,
    "geodesic-spline": GeodesicSpline,
    "learned": Learned,
}
"""Every scheme by its name."""


def make_curve(
    animation: Animation, scheme: str, metric: Metric | None = None, library: Library | Help | None = None
) -> Curve:
    """Make the curve of a scheme; see `interpolate`."""
    if library is None:
        return SCHEMES[scheme](animation, metric)
    if scheme != LEARNED:
        raise ValueError(f"The scheme {scheme} has no library; leave it out, or use the scheme {LEARNED}.")
    return Learned(animation, metric, library)


def interpolate(
    animation: Animation,
    times: ArrayLike,
    scheme: str | None = None,
    metric: Metric | None = None,
    library: Library | None = None,
) -> Animation:
    """Interpolate an animation.

    Parameters
    ----------
    animation : Animation
        Its frames are the keys.
    times : array-like, shape=[F]
        Seconds, strictly increasing.
    scheme : str
        A name in `SCHEMES`.
        Optional, default: the scheme that a learned metric was made for, else "geodesic-spline".
    metric : MetricParameters or LearnedMetric
        A learned metric is matched to the joints by name.
        Optional, default: the bi-invariant metric.
    library : Library
        For the scheme "learned"; see `learn_library`.
        Optional, default: none, with which that scheme is "geodesic-spline".

    Returns
    -------
    interpolated : Animation

    Raises
    ------
    ValueError
        If there is no such scheme, the metric has other joints, or the scheme has no metric or no library.

    Warns
    -----
    FallbackWarning
        If segments are slerped because their geodesic was not found. `SCHEMES["geodesic"](animation, metric)` names
        all of them in its `fallbacks`.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import Animation, MetricParameters, Skeleton, interpolate
    >>> skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]])
    >>> keys = Animation(skeleton, [0.0, 1.0], [[[0, 0, 0, 1]], [[0.6, 0, 0, 0.8]]], np.zeros((2, 1, 3)))
    >>> interpolate(keys, [0.5], metric=MetricParameters([2.0], [0.5])).rotations.round(4)
    array([[[0.3162, 0.    , 0.    , 0.9487]]])
    """
    if scheme is None:
        scheme = metric.scheme if isinstance(metric, LearnedMetric) else DEFAULT_SCHEME
    if scheme not in SCHEMES:
        raise ValueError(f"There is no scheme {scheme!r}; the schemes are {', '.join(SCHEMES)}.")
    curve = make_curve(animation, scheme, metric, library)
    if curve.fallbacks:
        warnings.warn(
            f"{len(curve.fallbacks)} segments are slerped. The first: {curve.fallbacks[0]}",
            FallbackWarning,
            stacklevel=2,
        )
    return curve(times)
