"""The interface of all interpolation schemes: made from keys, then called with times, as in `scipy.interpolate`.

Outside the range of its keys, a curve holds the first or the last one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation, increasing_times
from geomstats_anim.geodesics.pose_geodesics import LogStatus
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

Metric = MetricParameters | LearnedMetric
"""Metrics that a scheme accepts."""


@dataclass(frozen=True)
class Fallback:
    """A segment whose geodesic was not found, and which is slerped instead.

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
        return f"Joint {self.joint!r} from {self.start_time:g} s to {self.end_time:g} s is slerped: {self.status}"


class Curve(ABC):
    """A curve through the frames of an animation, which are its keys.

    A scheme defines its rotations and their rates at shares of the segments between keys, and its translations where
    they are not on straight lines, as scales always are.

    Parameters
    ----------
    animation : Animation
    metric : MetricParameters or LearnedMetric
        A learned metric is matched to the joints by name.
        Optional, default: None, the bi-invariant metric. Schemes without a metric take none.

    Attributes
    ----------
    fallbacks : tuple of Fallback
        Segments that are slerped because their geodesic was not found.

    Raises
    ------
    ValueError
        If there is no key, or a metric is given to a scheme without one.
    """

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        if animation.n_frames < 1:
            raise ValueError("Interpolation needs at least one key, but the animation has none.")
        self.animation = animation
        self.fallbacks: tuple[Fallback, ...] = ()
        if animation.n_frames > 1:
            self._prepare(metric)

    @abstractmethod
    def _prepare(self, metric: Metric | None) -> None:
        """Prepare what does not depend on the times, with at least two keys."""

    @abstractmethod
    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        """Return rotations, shape=[F, B, 4], at shares of segments, which do not decrease."""

    @abstractmethod
    def _rates(self, segment: np.ndarray, fraction: Array) -> tuple[Array, Array]:
        """Return body angular velocity and acceleration, shape=[F, B, 3], in radians per second and its square."""

    def _translations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._linear(self.animation.translations, segment, fraction)

    def _linear(self, values: Array, segment: np.ndarray, fraction: Array) -> Array:
        """Interpolate values, shape=[K, B, 3], linearly; exact at both keys."""
        weight = fraction[:, None, None]
        return (1.0 - weight) * values[segment] + weight * values[segment + 1]

    def _durations(self, segment: np.ndarray) -> Array:
        """Return the durations of segments in seconds, shape=[F, 1, 1]."""
        return np.diff(self.animation.times)[segment, None, None]

    @overload
    def __call__(self, times: ArrayLike, order: None = None) -> Animation: ...

    @overload
    def __call__(self, times: ArrayLike, order: int) -> Array: ...

    def __call__(self, times: ArrayLike, order: int | None = None) -> Animation | Array:
        """Evaluate the curve.

        Parameters
        ----------
        times : array-like, shape=[F]
            Seconds, strictly increasing.
        order : int
            0: rotations. 1: body angular velocity w, with R' = R hat(w), radians per second. 2: body angular
            acceleration w'. At a key, rates are those of the segment after it, at the last key of the segment before;
            outside the keys they are 0.
            Optional, default: None, the animation, with translations and scales.

        Returns
        -------
        values : Animation; or array-like, shape=[F, B, 4] for order 0, shape=[F, B, 3] for orders 1 and 2

        Raises
        ------
        ValueError
            If the times do not increase, or there is no such order.
        """
        if order not in (None, 0, 1, 2):
            raise ValueError(f"The order must be 0, 1 or 2, but it is {order}.")
        keys = self.animation
        times = increasing_times(np.atleast_1d(times))
        segment, fraction = locate(keys.times, times)
        if order in (1, 2):
            rates = np.zeros((len(times), keys.n_joints, 3))
            moving = (times >= keys.times[0]) & (times <= keys.times[-1])
            if keys.n_frames > 1:
                rates[moving] = self._rates(segment[moving], fraction[moving])[order - 1]
            return rates
        animation = self._animation(times, segment, fraction)
        return animation if order is None else animation.rotations

    def _animation(self, times: Array, segment: np.ndarray, fraction: Array) -> Animation:
        keys = self.animation
        if keys.n_frames == 1:
            held = (keys.rotations[segment], keys.translations[segment])
            scales = None if keys.scales is None else keys.scales[segment]
            return Animation(keys.skeleton, times, *held, scales)
        rotations = through_keys(self._rotations(segment, fraction), keys.rotations, segment, fraction)
        translations = through_keys(self._translations(segment, fraction), keys.translations, segment, fraction)
        scales = None if keys.scales is None else self._linear(keys.scales, segment, fraction)
        return Animation(keys.skeleton, times, rotations, translations, scales)


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


def through_keys(values: Array, keys: Array, segment: np.ndarray, fraction: Array) -> Array:
    """Put keys, bit for bit, where values at shares of segments are at them, whatever rounding a scheme has."""
    for at_key, key in ((fraction <= 0.0, segment), (fraction >= 1.0, segment + 1)):
        values[at_key] = keys[key[at_key]]
    return values


def times_at(key_times: Array, segment: np.ndarray, fraction: Array) -> Array:
    """Find the times of shares of segments: the inverse of `locate`."""
    return key_times[segment] + fraction * np.diff(key_times)[segment]
