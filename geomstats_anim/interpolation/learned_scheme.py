"""The scheme `learned`: geodesic-spline, and residuals off it that a library of other clips predicts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.geodesics.exponential import Rates, bent_rates
from geomstats_anim.interpolation.curves import Metric, locate, through_keys
from geomstats_anim.interpolation.metric_schemes import GeodesicSpline
from geomstats_anim.interpolation.residuals import Residual
from geomstats_anim.interpolation.splines import CoupledSpline, PoseSpline
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array


@dataclass(frozen=True)
class PartHelp:
    """Help of a library for a part of the body.

    Parameters
    ----------
    part : str
        "torso", "arm", "leg" or "limb".
    joint : str
        The joint that it starts at.
    share : float
        Share of the predicted residual that is used, in [0, 1]; 0 is the spline.
    """

    part: str
    joint: str
    share: float


@dataclass(frozen=True, eq=False)
class Help:
    """Prediction of a library for a clip.

    Parameters
    ----------
    residual : Residual or None
        What is used of it; None if nothing is, which is the spline.
    parts : tuple of PartHelp
        Empty if the library is for another rig.
    """

    residual: Residual | None
    parts: tuple[PartHelp, ...] = ()

    def at_joints(self, joints: np.ndarray | slice) -> Help:
        """Take some joints, by their indices, of those of the clip."""
        return self if self.residual is None else Help(self.residual.at_joints(joints), self.parts)


class Library(Protocol):
    """Interface of a library that the scheme needs; `learning.library.MotionLibrary` is one."""

    def help(self, keys: Animation, curve: CurveParameters) -> Help:
        """Predict residuals of the spline through keys, as far as they help this clip."""


class Learned(GeodesicSpline):
    """The geodesic-spline S of the clip's own metric and tension, turned by residuals: S(t) Exp(c(t)).

    Keys stay exact, and the curve is as smooth at them as the spline.

    Parameters
    ----------
    animation : Animation
    metric : MetricParameters or LearnedMetric
        Optional, default: None, the bi-invariant metric.
    library : Library or Help
        Or what it does for these keys, where that is known.
        Optional, default: None, the spline itself.

    Attributes
    ----------
    help : Help
        What the library does for this clip, by part of the body.
    """

    def __init__(
        self, animation: Animation, metric: Metric | None = None, library: Library | Help | None = None
    ) -> None:
        self._library = library
        self.help = library if isinstance(library, Help) else Help(None)
        super().__init__(animation, metric)

    def _take(self, spline: PoseSpline | CoupledSpline) -> None:
        if self._library is not None and isinstance(spline, CoupledSpline):
            raise ValueError("A library helps metrics that do not couple joints; leave one of both out.")
        super()._take(spline)
        # while a value is dragged, the residual stays
        is_quick = isinstance(spline, PoseSpline) and spline.is_quick.any()
        if self._library is not None and not isinstance(self._library, Help) and not is_quick:
            self.help = self._library.help(self.animation, self._curve)

    def differs(self, other: Self) -> tuple[np.ndarray, np.ndarray]:
        """Return which joints turn, and which move, otherwise; with another residual, all may turn."""
        turns, moves = super().differs(other)
        return turns | (self.help is not other.help), moves

    def rotations(self, times: Array, joints: np.ndarray) -> Array:
        """Evaluate the rotations of some joints only, by their indices, shape=[F, J, 4], at increasing times."""
        rotations, residual = super().rotations(times, joints), self.help.residual
        if residual is None:
            return rotations
        segment, fraction = locate(self.animation.times, times)
        turned = quat.multiply(rotations, quat.exp(residual.at_joints(joints)(segment, fraction)))
        return through_keys(turned, self.animation.rotations[:, joints], segment, fraction)

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        rotations, residual = super()._rotations(segment, fraction), self.help.residual
        if residual is None:
            return rotations
        return quat.multiply(rotations, quat.exp(residual(segment, fraction)))

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        rates, residual = super()._rates(segment, fraction), self.help.residual
        if residual is None:
            return rates
        durations = self._durations(segment)
        vectors = (residual(segment, fraction, order) / durations**order for order in range(3))
        return bent_rates(rates, *vectors)
