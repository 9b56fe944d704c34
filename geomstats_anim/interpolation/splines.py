r"""Splines through keys: geodesics on SO(3)^B, or straight lines, bent so that their velocities meet at the keys.

Every joint has a tension: at 0 nothing is bent, at 1 velocity is continuous, at 2 acceleration is too; see `tangents`.
The bends of a joint are seen along the principal axes of its metric, after left invariance and the identity as the
initial pose are arranged as in `geodesics`, so a spline shares the symmetries of its metric.
"""

from __future__ import annotations

from copy import copy
from functools import cached_property
from typing import Any

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.coupled_geodesics import CoupledGeodesics
from geomstats_anim.geodesics.exponential import Rates, bent_rates
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.interpolation.tangents import KeyVelocities, hermite
from geomstats_anim.kernels import bending
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array


class _BentGeodesics:
    """Geodesics between key poses, and how they are bent."""

    geodesics: Any
    _durations: Array
    _tension: Array

    @cached_property
    def _ends(self) -> Any:
        return self.geodesics.end_velocities

    @cached_property
    def _velocities(self) -> KeyVelocities | None:
        if not self._tension.any():
            return None
        per_second, ends = 1.0 / self._durations[:, None, None], self._ends
        return KeyVelocities(
            self._durations,
            ends.start * per_second,
            ends.end * per_second,
            self._tension,
            (ends.start_acceleration * per_second**2, ends.end_acceleration * per_second**2),
        )

    def __call__(self, index: np.ndarray, parameter: Array) -> Array:
        """Evaluate poses.

        Parameters
        ----------
        index : array-like of int, shape=[F]
            Segment; must not decrease.
        parameter : array-like, shape=[F]
            Share of its duration, in [0, 1]; must not decrease within one segment.

        Returns
        -------
        rotations : array-like, shape=[F, B, 4]
            Unit quaternions.
        """
        turned = self.geodesics.turns(index, parameter)
        if self._velocities is not None:
            bending.bend(turned, index, np.array(parameter), *self._velocities.bends)
        return np.asarray(self.geodesics.poses(index, turned))

    def rates(self, index: np.ndarray, parameter: Array) -> Rates:
        """Return body angular velocities, radians per second, and accelerations, at shares of segments."""
        turned = self.geodesics.turns(index, parameter)
        rates = Rates(*self.geodesics.turn_rates(index, turned))
        if self._velocities is not None:
            start, end = (bend[index] for bend in self._velocities.bends)
            weights = (hermite(parameter[:, None, None], order) for order in range(3))
            rates = bent_rates(rates, *(first * start + second * end for first, second in weights))
            bending.bend(turned, index, np.array(parameter), *self._velocities.bends)
        poses, per_second = self.geodesics.poses(index, turned), 1.0 / self._durations[index, None, None]
        velocity, acceleration = (self.geodesics.pose_rates(poses, rate) for rate in rates)
        return Rates(velocity * per_second, acceleration * per_second**2)

    def pull_back(self, index: np.ndarray, parameter: Array, rotations: Array, cotangent: Array) -> tuple[Array, Array]:
        """Pull the derivative of a scalar by poses back to one by the metric and the tension, the keys fixed.

        Parameters
        ----------
        index, parameter : array-like, shape=[F]
            As in a call.
        rotations : array-like, shape=[F, B, 4]
            What the call returned.
        cotangent : array-like, shape=[F, B, 3]
            Derivative of the scalar by the body variation of the rotations.

        Returns
        -------
        metric : array-like, shape=[B, 5] or shape=[B, 5 + 3 r]
            By log alpha, log beta, a rotation vector that turns the axes from the left, and the coupling if there is
            one.
        tension : array-like, shape=[B]
        """
        inward = self.geodesics.pull_back_poses(rotations, cotangent)
        n_segments, n_joints = len(self._durations), inward.shape[1]
        if self._velocities is None:
            return self.geodesics.pull_back_turns(index, parameter, inward), np.zeros(n_joints)
        by_start, by_end, by_axes = (np.zeros((n_segments, n_joints, 3)) for _ in range(3))
        bending.unbend(index, np.array(parameter), *self._velocities.bends, inward, by_start, by_end, by_axes)
        start, end, *accelerations, by_tension = self._velocities.pull_back((by_start, by_end))
        per_second = 1.0 / self._durations[:, None, None]
        partial = self._ends.pull_back(
            start * per_second, end * per_second, *(by * per_second**2 for by in accelerations)
        )
        return self.geodesics.pull_back_turns(index, parameter, inward, self._with_axes(partial, by_axes)), by_tension

    def _with_axes(self, partial: Any, by_axes: Array) -> Any:
        """Add the derivative by a turn of the axes that bends are seen along."""
        return partial


class PoseSpline(_BentGeodesics):
    """A curve on SO(3)^B through key poses.

    Parameters
    ----------
    times : array-like, shape=[K]
        Seconds, increasing.
    keys : array-like, shape=[K, B, 4]
        Unit quaternions.
    parameters : MetricParameters
    tension : array-like, shape=[B]
    near : array-like, shape=[K - 1, B, 3]
        Velocities of geodesics of a similar metric, see `PoseGeodesics.between`.
        Optional, default: None.
    effort : str
        "thorough", or "quick", for learning: see `shortest_momenta`.
        Optional, default: "thorough".

    Attributes
    ----------
    geodesics : PoseGeodesics
        Between the keys; the segments that are bent.
    is_quick : array-like of bool, shape=[B]
        Which joints were searched for quickly.
    """

    def __init__(
        self,
        times: Array,
        keys: Array,
        parameters: MetricParameters,
        tension: Array,
        near: Array | None = None,
        effort: Effort = "thorough",
    ) -> None:
        self._durations, self._tension = np.diff(times), tension
        self.is_quick = np.full(keys.shape[1], effort == "quick")
        self.geodesics = PoseGeodesics.between(keys[:-1], keys[1:], parameters, near, effort)

    def at_joints(self, joints: np.ndarray) -> PoseSpline:
        """Take some joints, by their indices, shape=[J]."""
        return self._with(self.geodesics.at_joints(joints), self._tension[joints], self.is_quick[joints])

    def with_curve(self, keys: Array, parameters: MetricParameters, tension: Array, effort: Effort) -> PoseSpline:
        """Take another metric and tension through the same keys; only joints whose metric differs are solved.

        A thorough search starts anew, so that its result does not depend on the metric before, and does what was quick
        so far again. A quick one starts from the solutions of the metric before.
        """
        geodesics, is_changed = self.geodesics, self.geodesics.parameters.differs(parameters)
        if effort == "thorough":
            is_changed = is_changed | self.is_quick
        changed = np.flatnonzero(is_changed)
        if len(changed):
            mine = parameters.at(changed)
            near = None
            if effort == "quick":
                same_side = mine.is_right == geodesics.parameters.is_right[changed]
                near = np.where(same_side[:, None], geodesics.velocity[:, changed], np.nan)
            solved = PoseGeodesics.between(keys[:-1, changed], keys[1:, changed], mine, near, effort)
            geodesics = geodesics.with_joints(changed, solved, parameters)
        is_quick = self.is_quick | is_changed if effort == "quick" else np.zeros_like(is_changed)
        return self._with(geodesics, tension, is_quick)

    def _with(self, geodesics: PoseGeodesics, tension: Array, is_quick: np.ndarray) -> PoseSpline:
        other = copy(self)
        other.geodesics, other._tension, other.is_quick = geodesics, tension, is_quick
        for name in ("_ends", "_velocities"):
            other.__dict__.pop(name, None)
        return other

    def _with_axes(self, partial: Array, by_axes: Array) -> Array:
        partial[..., 5:] += by_axes
        return partial


class CoupledSpline(_BentGeodesics):
    """A curve on SO(3)^B through key poses, with a metric that couples joints; bends are seen in the joints' frames.

    Where nothing is coupled, it is the `PoseSpline`.

    Parameters
    ----------
    times : array-like, shape=[K]
        Seconds, increasing.
    keys : array-like, shape=[K, B, 4]
        Unit quaternions.
    curve : CurveParameters
        With a coupling.
    near : array-like, shape=[K - 1, B, 3]
        Velocities of geodesics of a similar metric; not a number where none is known.
        Optional, default: None.
    effort : str
        "thorough", or "quick", for learning: see `coupled.shoot`.
        Optional, default: "thorough".
    """

    def __init__(
        self,
        times: Array,
        keys: Array,
        curve: CurveParameters,
        near: Array | None = None,
        effort: Effort = "thorough",
    ) -> None:
        assert curve.coupling is not None
        self._durations, self._tension = np.diff(times), curve.tension
        self.geodesics = CoupledGeodesics(keys[:-1], keys[1:], curve.metric, curve.coupling, near, effort)


class PathSpline:
    """A curve through points, of every joint by itself.

    Parameters
    ----------
    times : array-like, shape=[K]
        Seconds, increasing.
    keys : array-like, shape=[K, B, 3]
    tension : array-like, shape=[B]
    """

    def __init__(self, times: Array, keys: Array, tension: Array) -> None:
        self._keys = keys
        durations = np.diff(times)
        slopes = np.diff(keys, axis=0) / durations[:, None, None]
        self._velocities = KeyVelocities(durations, slopes, slopes, tension)

    def tightened(self, tension: Array) -> PathSpline:
        """Take another tension, shape=[B], which is quick."""
        other = copy(self)
        other._velocities = self._velocities.tightened(tension)
        return other

    def __call__(self, index: np.ndarray, parameter: Array) -> Array:
        """Evaluate points at shares of segments, shape=[F, B, 3]; see `PoseSpline`."""
        weight = parameter[:, None, None]
        first, second = (weights[:, None, None] for weights in hermite(parameter))
        start, end = self._velocities.bends
        line = (1.0 - weight) * self._keys[index] + weight * self._keys[index + 1]
        return line + first * start[index] + second * end[index]

    def pull_back(self, index: np.ndarray, parameter: Array, cotangent: Array) -> Array:
        """Pull the derivative of a scalar by points, shape=[F, B, 3], back to one by the tension, shape=[B]."""
        by_start, by_end = (np.zeros((len(self._keys) - 1, *self._keys.shape[1:])) for _ in range(2))
        bending.gather(index, np.array(parameter), quat.plain(cotangent), by_start, by_end)
        return self._velocities.by_tension((by_start, by_end))
