"""Interpolation schemes along geodesics of a metric."""

from __future__ import annotations

import warnings
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.geodesics.exponential import Rates
from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.interpolation.curves import Curve, Fallback, Metric, locate, through_keys
from geomstats_anim.interpolation.splines import CoupledSpline, PathSpline, PoseSpline
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
        keys, curve = self.animation, self._curve
        if curve.coupling is not None:
            self._take(CoupledSpline(keys.times, keys.rotations, replace(curve, tension=self._tension)))
        else:
            self._take(PoseSpline(keys.times, keys.rotations, curve.metric, self._tension))

    def _take(self, spline: PoseSpline | CoupledSpline) -> None:
        self._spline, self.geodesics = spline, spline.geodesics
        keys, status = self.animation, spline.geodesics.status
        times, joints = keys.times, keys.skeleton.joints
        self.fallbacks = tuple(
            Fallback(joints[b], float(times[k]), float(times[k + 1]), LogStatus(status[k, b]))
            for k, b in np.argwhere(status != LogStatus.CONVERGED)
        )

    def with_metric(self, metric: Metric | None, effort: Effort = "thorough") -> Self:
        """Take another metric through the same keys; only joints that it changes are solved.

        Parameters
        ----------
        metric : MetricParameters or LearnedMetric
            As when the curve is made.
        effort : str
            "thorough": the curve is the one that is made from this metric. "quick": start from the solutions of the
            present metric, and do not prove that geodesics are the shortest; for what is seen while a value is dragged.
            Optional, default: "thorough".

        Returns
        -------
        curve : Curve
            Of the same scheme; this one stays as it is.
        """
        other = copy(self)
        other.__dict__.pop("_path", None)
        other._curve = curve_parameters(metric, self.animation)
        if self.animation.n_frames < 2:
            return other
        spline = self._spline
        if isinstance(spline, CoupledSpline) or other._curve.coupling is not None:
            other._prepare(metric)  # joints that are coupled are solved together
        else:
            other._take(spline.with_curve(self.animation.rotations, other._curve.metric, other._tension, effort))
        return other

    def differs(self, other: Self) -> tuple[np.ndarray, np.ndarray]:
        """Return which joints turn, and which move, otherwise on another curve through the same keys, shape=[B]."""
        mine, others = self._curve, other._curve
        turns = mine.metric.differs(others.metric) | (self._tension != other._tension)
        if mine.coupling is not None or others.coupling is not None:
            turns |= True
        elif self.animation.n_frames > 1:
            assert isinstance(self._spline, PoseSpline) and isinstance(other._spline, PoseSpline)
            turns |= self._spline.is_quick | other._spline.is_quick
        return turns, self._translation_tension != other._translation_tension

    def rotations(self, times: Array, joints: np.ndarray) -> Array:
        """Evaluate the rotations of some joints only, by their indices, shape=[F, J, 4], at increasing times."""
        keys = self.animation.rotations[:, joints]
        segment, fraction = locate(self.animation.times, times)
        if len(keys) == 1:
            return keys[segment]
        if isinstance(self._spline, CoupledSpline):
            return through_keys(self._spline(segment, fraction)[:, joints], keys, segment, fraction)
        return through_keys(self._spline.at_joints(joints)(segment, fraction), keys, segment, fraction)

    def translations(self, times: Array, joints: np.ndarray) -> Array:
        """Evaluate the translations of some joints only, shape=[F, J, 3]; see `rotations`."""
        keys = self.animation.translations[:, joints]
        segment, fraction = locate(self.animation.times, times)
        if len(keys) == 1:
            return keys[segment]
        path = PathSpline(self.animation.times, keys, self._translation_tension[joints])
        return through_keys(path(segment, fraction), keys, segment, fraction)

    @property
    def _translation_tension(self) -> Array:
        return np.zeros(self.animation.n_joints)

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

    @cached_property
    def _path(self) -> PathSpline:
        return PathSpline(self.animation.times, self.animation.translations, self._translation_tension)

    @property
    def _tension(self) -> Array:
        return self._curve.tension

    @property
    def _translation_tension(self) -> Array:
        return self._curve.translation_tension

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
