"""Interpolation schemes along geodesics of a metric."""

from __future__ import annotations

import warnings

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.interpolation.curves import Curve, Fallback, Metric
from geomstats_anim.interpolation.exponential import Rates
from geomstats_anim.interpolation.splines import PathSpline, PoseSpline
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array


class Geodesic(Curve):
    """Shortest geodesics of an invariant metric on SO(3)^B (Kushner, Modi, Miolane, section 4.2).

    A segment whose geodesic is not found is slerped, and named in `fallbacks`.
    """

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        self._curve = curve_parameters(metric, animation)
        super().__init__(animation, metric)

    def _prepare(self, metric: Metric | None) -> None:
        keys = self.animation
        self._spline = PoseSpline(keys.times, keys.rotations, self._curve.metric, self._tension)
        self.geodesics = self._spline.geodesics
        times, joints, status = keys.times, keys.skeleton.joints, self.geodesics.status
        self.fallbacks = tuple(
            Fallback(joints[b], float(times[k]), float(times[k + 1]), LogStatus(status[k, b]))
            for k, b in np.argwhere(status != LogStatus.CONVERGED)
        )

    @property
    def _tension(self) -> Array:
        return np.zeros(self.animation.n_joints)

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._spline(segment, fraction)

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        return self._spline.rates(segment, fraction)


class GeodesicSpline(Geodesic):
    """Geodesics bent so that velocities meet at the keys, as far as each joint's tension says; see `splines`.

    Translations go along cubic splines with a tension of their own. A metric without tension gets 1, continuous
    velocity.
    """

    def _prepare(self, metric: Metric | None) -> None:
        super()._prepare(metric)
        keys = self.animation
        self._path = PathSpline(keys.times, keys.translations, self._curve.translation_tension)

    @property
    def _tension(self) -> Array:
        return self._curve.tension

    def _translations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._path(segment, fraction)


def curve_parameters(metric: Metric | None, animation: Animation) -> CurveParameters:
    """Return the parameters for the joints of an animation, in its order; the tension is 1 where none is given.

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
            warnings.warn(f"The metric has no entry for {', '.join(missing)}; using the identity.", stacklevel=4)
        return metric.curve
    if metric.n_joints != animation.n_joints:
        raise ValueError(f"The metric has {metric.n_joints} joints, but the animation has {animation.n_joints}.")
    return CurveParameters.spline(metric)
