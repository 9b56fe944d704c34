"""Interpolation schemes that have no metric."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.geodesics.exponential import Rates, bent_rates, logarithm_rates
from geomstats_anim.interpolation.curves import Curve, Metric, times_at
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.names import LEARNABLE, WITH_METRIC
from geomstats_anim.rotations import Array


class _WithoutMetric(Curve):
    """A scheme that has no metric."""

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        # a learned metric may say no more than which scheme to use
        if metric is not None and not (isinstance(metric, LearnedMetric) and metric.scheme not in WITH_METRIC):
            name = type(self).__name__
            raise ValueError(
                f"{name} has no metric; leave it out, or use one of the schemes {' and '.join(LEARNABLE)}."
            )
        super().__init__(animation, metric)

    def _prepare(self, metric: Metric | None) -> None:
        pass


class Constant(_WithoutMetric):
    """Hold every key until the next one."""

    def _linear(self, values: Array, segment: np.ndarray, fraction: Array) -> Array:
        # a fraction of exactly 1 is the last key itself
        return values[np.minimum(segment + (fraction >= 1.0), len(values) - 1)]

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._linear(self.animation.rotations, segment, fraction)

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        still = np.zeros((len(segment), self.animation.n_joints, 3))
        return Rates(still, still)


class Linear(_WithoutMetric):
    """Move quaternion components on straight lines, then normalise them, as many curve editors do."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return quat.normalize(self._linear(self.animation.rotations, segment, fraction))

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        keys, durations = self.animation.rotations, self._durations(segment)
        line = self._linear(keys, segment, fraction)
        slope = (keys[segment + 1] - keys[segment]) / durations
        square = (line**2).sum(axis=-1, keepdims=True)
        # the vector part of conj(line) slope is constant along a straight line
        velocity = 2.0 * quat.multiply(quat.conjugate(line), slope)[..., :3] / square
        return Rates(velocity, -2.0 * velocity * (line * slope).sum(axis=-1, keepdims=True) / square)


class Slerp(_WithoutMetric):
    """Turn at constant angular velocity along the shorter way: what USD shows between samples."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        keys = self.animation.rotations
        return quat.slerp(keys[segment], keys[segment + 1], fraction[:, None])

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        keys = self.animation.rotations
        velocity = quat.difference(keys[segment], keys[segment + 1]) / self._durations(segment)
        return Rates(velocity, np.zeros_like(velocity))


class _OnCubicPaths(_WithoutMetric):
    """A scheme whose translations go along SciPy's cubic spline."""

    def _prepare(self, metric: Metric | None) -> None:
        from scipy.interpolate import CubicSpline

        self._path = CubicSpline(self.animation.times, self.animation.translations)

    def _translations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._path(times_at(self.animation.times, segment, fraction))


class Squad(_OnCubicPaths):
    """Spherical quadrangles through the keys (Shoemake, "Quaternion calculus and fast animation", 1987).

    The inner control points allow for uneven key times as the package numpy-quaternion does.
    """

    def _prepare(self, metric: Metric | None) -> None:
        super()._prepare(metric)
        keys, durations = self.animation.rotations, np.diff(self.animation.times)[:, None, None]
        turns = quat.difference(keys[:-1], keys[1:])
        before, after = turns[:-1], turns[1:]
        ratio = durations[1:] / durations[:-1]
        self._leaving, self._arriving = keys[:-1].copy(), keys[1:].copy()
        self._leaving[1:] = quat.multiply(keys[1:-1], quat.exp(0.25 * (before * ratio - after)))
        self._arriving[:-1] = quat.multiply(keys[1:-1], quat.exp(0.25 * (before - after / ratio)))

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        keys, u = self.animation.rotations, fraction[:, None]
        outer = quat.slerp(keys[segment], keys[segment + 1], u)
        inner = quat.slerp(self._leaving[segment], self._arriving[segment], u)
        return quat.slerp(outer, inner, 2.0 * u * (1.0 - u))

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        keys, u = self.animation.rotations, fraction[:, None, None]
        ends = (keys[segment], keys[segment + 1]), (self._leaving[segment], self._arriving[segment])
        outer, inner = (quat.slerp(*pair, fraction[:, None]) for pair in ends)
        outer_turn, inner_turn = (quat.difference(*pair) for pair in ends)
        gap = quat.difference(outer, inner)
        carried = quat.rotate(quat.exp(-gap), outer_turn)
        between = Rates(inner_turn - carried, quat.cross(inner_turn, carried))
        first, second = logarithm_rates(gap, between)
        # the product rule for the share 2 u (1 - u) of the gap
        share, slope, bend = 2.0 * u * (1.0 - u), 2.0 - 4.0 * u, -4.0
        velocity, acceleration = bent_rates(
            Rates(outer_turn, np.zeros_like(outer_turn)),
            share * gap,
            slope * gap + share * first,
            bend * gap + 2.0 * slope * first + share * second,
        )
        durations = self._durations(segment)
        return Rates(velocity / durations, acceleration / durations**2)


class RotationSpline(_OnCubicPaths):
    """Twice continuously differentiable: SciPy's `RotationSpline`."""

    def _prepare(self, metric: Metric | None) -> None:
        from scipy.spatial.transform import Rotation
        from scipy.spatial.transform import RotationSpline as Spline

        super()._prepare(metric)
        keys, times = self.animation, self.animation.times
        self._splines = [Spline(times, Rotation.from_quat(keys.rotations[:, b])) for b in range(keys.n_joints)]

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        times = times_at(self.animation.times, segment, fraction)
        rotations = np.empty((len(times), self.animation.n_joints, 4))
        for b, spline in enumerate(self._splines):
            rotations[:, b] = spline(times).as_quat()
        return rotations

    def _rates(self, segment: np.ndarray, fraction: Array) -> Rates:
        times = times_at(self.animation.times, segment, fraction)
        rates = np.empty((2, len(times), self.animation.n_joints, 3))
        for b, spline in enumerate(self._splines):
            rates[0, :, b], rates[1, :, b] = spline(times, 1), spline(times, 2)
        return Rates(*rates)
