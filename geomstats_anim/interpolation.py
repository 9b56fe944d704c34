"""Interpolation schemes: one small class a scheme, one registry, and `interpolate`.

Like `scipy.interpolate` objects, a scheme is made from its keys and then called with times. Outside the range of its
keys it holds the first or the last one.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, increasing_times
from geomstats_anim.geodesics import LogStatus, PoseGeodesics
from geomstats_anim.parameters import LearnedMetric, MetricParameters
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


class FallbackWarning(UserWarning):
    """Some segments are slerped because their geodesic was not found."""


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


class _Piecewise:
    """Linear interpolation of vectors, which most schemes share."""

    fallbacks: tuple[Fallback, ...] = ()

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        if animation.n_frames < 1:
            raise ValueError("Interpolation needs at least one key, but the animation has none.")
        self.animation = animation

    def _linear(self, values: Array, segment: np.ndarray, fraction: Array) -> Array:
        """Interpolate values, shape=[K, B, 3], linearly; exact at both keys."""
        if len(values) == 1:
            return values[segment]
        weight = fraction[:, None, None]
        return (1.0 - weight) * values[segment] + weight * values[segment + 1]

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        raise NotImplementedError

    def __call__(self, times: ArrayLike) -> Animation:
        """Evaluate at times, shape=[F], in seconds, strictly increasing."""
        keys = self.animation
        times = increasing_times(np.atleast_1d(times))
        segment, fraction = locate(keys.times, times)
        rotations = keys.rotations[segment] if keys.n_frames == 1 else self._rotations(segment, fraction)
        # keys are kept bit for bit, whatever rounding a scheme has
        rotations[fraction <= 0.0] = keys.rotations[segment[fraction <= 0.0]]
        rotations[fraction >= 1.0] = keys.rotations[segment[fraction >= 1.0] + 1]
        return replace(
            keys,
            times=times,
            rotations=rotations,
            translations=self._linear(keys.translations, segment, fraction),
            scales=None if keys.scales is None else self._linear(keys.scales, segment, fraction),
        )


class Constant(_Piecewise):
    """Every key is held until the next one."""

    def _linear(self, values: Array, segment: np.ndarray, fraction: Array) -> Array:
        # A fraction of exactly 1 is the last key itself.
        return values[np.minimum(segment + (fraction >= 1.0), len(values) - 1)]

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self._linear(self.animation.rotations, segment, fraction)


class Linear(_Piecewise):
    """Quaternion components on straight lines, then normalised: what many curve editors do."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return quat.normalize(self._linear(self.animation.rotations, segment, fraction))


class Slerp(_Piecewise):
    """Constant angular velocity along the shorter way: what USD shows between samples."""

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        keys = self.animation.rotations
        return quat.slerp(keys[segment], keys[segment + 1], fraction[:, None])


class Geodesic(_Piecewise):
    """Shortest geodesics of an invariant metric on SO(3)^B (Kushner, Modi, Miolane, section 4.2).

    A segment whose geodesic is not found is slerped, and named in `fallbacks`.
    """

    def __init__(self, animation: Animation, metric: Metric | None = None) -> None:
        super().__init__(animation, metric)
        keys = animation.rotations
        self.geodesics = PoseGeodesics.between(keys[:-1], keys[1:], _parameters(metric, animation))
        times, joints = animation.times, animation.skeleton.joints
        self.fallbacks = tuple(
            Fallback(joints[b], float(times[k]), float(times[k + 1]), LogStatus(self.geodesics.status[k, b]))
            for k, b in np.argwhere(self.geodesics.status != LogStatus.CONVERGED)
        )

    def _rotations(self, segment: np.ndarray, fraction: Array) -> Array:
        return self.geodesics(segment, fraction)


def _parameters(metric: Metric | None, animation: Animation) -> MetricParameters:
    """Parameters for the joints of an animation, in its order."""
    if metric is None:
        return MetricParameters.identity(animation.n_joints)
    if isinstance(metric, LearnedMetric):
        metric, missing = metric.for_joints(animation.skeleton.joints)
        if missing:
            warnings.warn(f"The metric knows nothing of {', '.join(missing)}; the identity is used.", stacklevel=4)
        return metric.parameters
    if metric.n_joints != animation.n_joints:
        raise ValueError(f"The metric has {metric.n_joints} joints, but the animation has {animation.n_joints}.")
    return metric


SCHEMES: dict[str, type[Curve]] = {
    "constant": Constant,
    "linear": Linear,
    "slerp": Slerp,
    "geodesic": Geodesic,
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
