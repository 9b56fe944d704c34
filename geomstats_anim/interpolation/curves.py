"""Interpolation schemes without a metric, and what all schemes share.

Like `scipy.interpolate` objects, a scheme is made from its keys and then called with times. Outside the range of its
keys it holds the first or the last one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import scipy.interpolate
import scipy.spatial.transform
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, increasing_times
from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

Metric = MetricParameters | LearnedMetric
"""What a scheme accepts as its metric."""


@dataclass(frozen=True)
class Fallback:
    """A segment whose geodesic was not found, and which is therefore slerped.

    Parameters
    ----------
    joint : str
    start_time, end_time : float
        Seconds, of the keys at its ends.
    status : LogStatus
        Why it was not found.
    """

    joint: str
    start_time: float
    end_time: float
    status: LogStatus

    def __str__(self) -> str:
        """Name the segment and the reason in one sentence."""
        return (
            f"Joint {self.joint!r} from {self.start_time:g} s to {self.end_time:g} s is slerped: {self.status.sentence}"
        )


class Curve(Protocol):
    """What every scheme can do."""

    fallbacks: tuple[Fallback, ...]

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None: ...

    def __call__(self, times: ArrayLike) -> Animation:
        """Evaluate at times, shape=[F], in seconds, strictly increasing."""
        ...


def locate(key_times: Array, times: Array) -> tuple[np.ndarray, Array]:
    """Find the segment between keys that each time lies in, and how far along it is.

    Parameters
    ----------
    key_times, times : array-like, shape=[K], shape=[F]
        Seconds, increasing.

    Returns
    -------
    segment : array-like of int, shape=[F]
        Index of the key before; times outside the keys belong to the nearest segment.
    fraction : array-like, shape=[F]
        In [0, 1].
    """
    if len(key_times) == 1:
        return np.zeros(len(times), dtype=np.intp), np.zeros(len(times))
    segment = np.clip(np.searchsorted(key_times, times, side="right") - 1, 0, len(key_times) - 2)
    return segment, np.clip((times - key_times[segment]) / np.diff(key_times)[segment], 0.0, 1.0)


def times_at(key_times: Array, segment: np.ndarray, fraction: Array) -> Array:
    """Find the times of shares of segments: the inverse of `locate`."""
    return key_times[segment] + fraction * np.diff(key_times)[segment]


class Piecewise:
    """A scheme that looks at a segment between two keys at a time; translations and scales go along straight lines."""

    fallbacks: tuple[Fallback, ...] = ()

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        if animation.n_frames < 1:
            raise ValueError("Interpolation needs at least one key, but the animation has none.")
        self.animation = animation
        if animation.n_frames > 1:
            self._prepare(metric)

    def _prepare(self, metric: Metric | None) -> None:
        """Do what is done once, with two keys at least."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        raise NotImplementedError

    def _translations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._linear(self.animation.translations, segment, fraction)

    def _linear(self, values: Array, segment: np.ndarray, fraction: Array) -> Array:
        """Interpolate values, shape=[K, B, 3], linearly; exact at both keys."""
        weight = fraction[:, None, None]
        return (1.0 - weight) * values[segment] + weight * values[segment + 1]

    def __call__(self, times: ArrayLike) -> Animation:
        """Evaluate at times, shape=[F], in seconds, strictly increasing."""
        keys = self.animation
        times = increasing_times(np.atleast_1d(times))
        segment, fraction = locate(keys.times, times)
        if keys.n_frames == 1:
            held = (keys.rotations[segment], keys.translations[segment])
            scales = None if keys.scales is None else keys.scales[segment]
            return Animation(keys.skeleton, times, *held, scales)
        rotations, translations = self._rotations(segment, fraction), self._translations(segment, fraction)
        # keys are kept bit for bit, whatever rounding a scheme has
        for at_key, key in ((fraction <= 0.0, segment), (fraction >= 1.0, segment + 1)):
            rotations[at_key] = keys.rotations[key[at_key]]
            translations[at_key] = keys.translations[key[at_key]]
        scales = None if keys.scales is None else self._linear(keys.scales, segment, fraction)
        return replace(keys, times=times, rotations=rotations, translations=translations, scales=scales)


class Constant(Piecewise):
    """Every key is held until the next one."""

    def _linear(self, values: Array, segment: np.ndarray, fraction: Array) -> Array:
        # A fraction of exactly 1 is the last key itself.
        return values[np.minimum(segment + (fraction >= 1.0), len(values) - 1)]

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._linear(self.animation.rotations, segment, fraction)


class Linear(Piecewise):
    """Quaternion components on straight lines, then normalised: what many curve editors do."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return quat.normalize(self._linear(self.animation.rotations, segment, fraction))


class Slerp(Piecewise):
    """Constant angular velocity along the shorter way: what USD shows between samples."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        keys = self.animation.rotations
        return quat.slerp(keys[segment], keys[segment + 1], fraction[:, None])


class _OnCubicPaths(Piecewise):
    """A scheme whose translations go along scipy's cubic spline."""

    def _prepare(self, metric: Metric | None) -> None:
        self._path = scipy.interpolate.CubicSpline(self.animation.times, self.animation.translations)

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


class RotationSpline(_OnCubicPaths):
    """Twice continuously differentiable: scipy's `RotationSpline`."""

    def _prepare(self, metric: Metric | None) -> None:
        super()._prepare(metric)
        keys, times = self.animation, self.animation.times
        by_joint = (scipy.spatial.transform.Rotation.from_quat(keys.rotations[:, b]) for b in range(keys.n_joints))
        self._splines = [scipy.spatial.transform.RotationSpline(times, rotations) for rotations in by_joint]

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        times = times_at(self.animation.times, segment, fraction)
        rotations = np.empty((len(times), self.animation.n_joints, 4))
        for b, spline in enumerate(self._splines):
            rotations[:, b] = spline(times).as_quat()
        return rotations
