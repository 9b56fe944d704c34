"""Interpolation along geodesics of a metric, the registry of all schemes, and `interpolate`."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation
from geomstats_anim.geodesics.pose_geodesics import LogStatus, PoseGeodesics
from geomstats_anim.interpolation.curves import (
    Constant,
    Curve,
    Fallback,
    Linear,
    Metric,
    Piecewise,
    RotationSpline,
    Slerp,
    Squad,
)
from geomstats_anim.interpolation.splines import PathSpline, PoseSpline
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array


class FallbackWarning(UserWarning):
    """Some segments are slerped because their geodesic was not found."""


class Geodesic(Piecewise):
    """Shortest geodesics of an invariant metric on SO(3)^B (Kushner, Modi, Miolane, section 4.2).

    A segment whose geodesic is not found is slerped, and named in `fallbacks`.
    """

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        self._curve = curve_parameters(metric, animation)
        super().__init__(animation, metric)

    def _prepare(self, metric: Metric | None) -> None:
        keys = self.animation.rotations
        self._find_fallbacks(PoseGeodesics.between(keys[:-1], keys[1:], self._curve.metric))

    def _find_fallbacks(self, geodesics: PoseGeodesics) -> None:
        self.geodesics = geodesics
        times, joints = self.animation.times, self.animation.skeleton.joints
        self.fallbacks = tuple(
            Fallback(joints[b], float(times[k]), float(times[k + 1]), LogStatus(geodesics.status[k, b]))
            for k, b in np.argwhere(geodesics.status != LogStatus.CONVERGED)
        )

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self.geodesics(segment, fraction)


class GeodesicSpline(Geodesic):
    """Geodesics bent so that velocities meet at the keys, as far as each joint's tension says; see `splines`.

    Translations go along cubic splines with a tension of their own. A metric without tension gets 1, continuous
    velocity.
    """

    def _prepare(self, metric: Metric | None) -> None:
        keys = self.animation
        self._spline = PoseSpline(keys.times, keys.rotations, self._curve.metric, self._curve.tension)
        self._path = PathSpline(keys.times, keys.translations, self._curve.translation_tension)
        self._find_fallbacks(self._spline.geodesics)

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._spline(segment, fraction)

    def _translations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._path(segment, fraction)


def curve_parameters(metric: Metric | None, animation: Animation) -> CurveParameters:
    """Parameters for the joints of an animation, in its order; the tension is 1 where none is given.

    Raises
    ------
    ValueError
        If the metric has no names and another number of joints.
    """
    if metric is None:
        metric = MetricParameters.identity(animation.n_joints)
    if isinstance(metric, LearnedMetric):
        metric, missing = metric.for_joints(animation.skeleton.joints)
        if missing:
            warnings.warn(f"The metric knows nothing of {', '.join(missing)}; the identity is used.", stacklevel=4)
        return metric.curve
    if metric.n_joints != animation.n_joints:
        raise ValueError(f"The metric has {metric.n_joints} joints, but the animation has {animation.n_joints}.")
    return CurveParameters.spline(metric)


SCHEMES: dict[str, type[Curve]] = {
    "constant": Constant,
    "linear": Linear,
    "slerp": Slerp,
    "squad": Squad,
    "rotation-spline": RotationSpline,
    "geodesic": Geodesic,
    "geodesic-spline": GeodesicSpline,
}
"""Every scheme by its name."""


def interpolate(
    animation: Animation, times: ArrayLike, scheme: str = "geodesic", metric: Metric | None = None
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
        Optional, default: "geodesic".
    metric : MetricParameters or LearnedMetric
        A learned metric is matched to the joints by name.
        Optional, default: the bi-invariant metric.

    Returns
    -------
    interpolated : Animation

    Raises
    ------
    ValueError
        If there is no such scheme, or the metric has other joints.

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
    if scheme not in SCHEMES:
        raise ValueError(f"There is no scheme {scheme!r}; the schemes are {', '.join(SCHEMES)}.")
    curve = SCHEMES[scheme](animation, metric)
    if curve.fallbacks:
        warnings.warn(
            f"{len(curve.fallbacks)} segments are slerped. The first: {curve.fallbacks[0]}",
            FallbackWarning,
            stacklevel=2,
        )
    return curve(times)
