"""What learning minimises: the quality of an animation rebuilt from its keys, and its exact gradient by the metric."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.geodesics import PoseGeodesics
from geomstats_anim.interpolation import locate
from geomstats_anim.kinematics import place, torques, world_pose
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.quality import joint_weights, kind_shares
from geomstats_anim.rotations import Array
from geomstats_anim.shortest import Effort

SMOOTHING = 1e-5
"""Angle in radians below which the rotation error is rounded off, since an angle has no derivative at 0."""


@dataclass
class Objective:
    """Quality of an animation rebuilt from its keys by geodesics, as a function of the metric.

    Parameters
    ----------
    animation : Animation
        The truth.
    keyframes : array-like of int, shape=[K]
        Frames that are kept; frames outside them hold the nearest key.
    kind : str
        "loc", "rot" or "hyb".
    weights : None, "depth" or array-like, shape=[B]
    location_weight : float
    scored : array-like of bool, shape=[F]
        Frames that count.
        Optional, default: all.
    """

    animation: Animation
    keyframes: ArrayLike
    kind: str = "hyb"
    weights: str | ArrayLike | None = None
    location_weight: float = 0.5
    scored: np.ndarray | None = None
    _last: PoseGeodesics | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Prepare what does not depend on the metric."""
        animation = self.animation
        keys = animation.at_frames(np.asarray(self.keyframes, dtype=np.intp))
        self._keys = keys.rotations
        self._segment, self._fraction = locate(keys.times, animation.times)
        self._shares = kind_shares(self.kind, self.location_weight)
        scored = np.ones(animation.n_frames, dtype=bool) if self.scored is None else self.scored
        self._counts = scored
        by_joint = joint_weights(self.weights, animation.skeleton) / max(1, scored.sum())
        self._weights = scored[:, None] * by_joint
        start, end = keys.translations[self._segment], keys.translations[self._segment + 1]
        self._translations = start + self._fraction[:, None, None] * (end - start)
        self._truth = world_pose(animation).ends

    @property
    def n_segments(self) -> int:
        """Number of segments between keys."""
        return len(self._keys) - 1

    def only(self, segments: np.ndarray) -> Objective:
        """Score only the frames of some segments."""
        return replace(self, scored=self._counts & np.isin(self._segment, segments), _last=None)

    def without(self, segments: np.ndarray) -> Objective:
        """Score only the frames of the other segments."""
        return replace(self, scored=self._counts & ~np.isin(self._segment, segments), _last=None)

    def rotation_errors_by_joint(self, parameters: MetricParameters, effort: Effort = "thorough") -> Array:
        """Weighted mean rotation error of each joint, radians, shape=[B]; its minima are independent."""
        rotations = self._rebuild(parameters, effort)
        return (self._weights * _smooth(quat.distance(self.animation.rotations, rotations))).sum(axis=0)

    def errors_by_joint(self, parameters: MetricParameters) -> Array:
        """Rotation error of each joint, and its part of the quality, shape=[2, B]; the parts add up to `value`.

        A rotation error depends on the metric of its own joint, a part on that of the joints above it too.
        """
        rotations = self._rebuild(parameters, "thorough")
        rotation = _smooth(quat.distance(self.animation.rotations, rotations))
        part = self._shares.rotation * rotation
        if self._shares.location:
            miss = place(self.animation.skeleton, rotations, self._translations).ends - self._truth
            part += self._shares.location * (miss**2).sum(axis=-1)
        return np.stack([(self._weights * errors).sum(axis=0) for errors in (rotation, part)])

    def value(self, parameters: MetricParameters) -> float:
        """Quality with the geodesics that `interpolate` finds; 0 is perfect."""
        return float(self.errors_by_joint(parameters)[1].sum())

    def value_and_gradient(self, parameters: MetricParameters) -> tuple[float, Array]:
        """Quality, and its derivative by the metric.

        The geodesics are followed from those of the last call, if it had the same sides, which is quick.

        Returns
        -------
        value : float
        gradient : array-like, shape=[B, 5]
            By log alpha, log beta, and a rotation vector that turns the axes from the left.
        """
        near = self._last
        if near is not None and near.parameters.invariance != parameters.invariance:
            near = None
        geodesics = PoseGeodesics.between(self._keys[:-1], self._keys[1:], parameters, near, "quick")
        self._last = geodesics
        rotations = geodesics(self._segment, self._fraction)
        skeleton = self.animation.skeleton
        value = 0.0
        cotangent = np.zeros((*rotations.shape[:2], 3))
        if self._shares.rotation:
            miss = quat.log(quat.multiply(quat.conjugate(self.animation.rotations), rotations))
            angle = np.linalg.norm(miss, axis=-1)
            weights = self._shares.rotation * self._weights
            value += float((_smooth(angle) * weights).sum())
            cotangent += miss * (weights / np.hypot(angle, SMOOTHING))[..., None]
        if self._shares.location:
            pose = place(skeleton, rotations, self._translations)
            miss = pose.ends - self._truth
            weights = self._shares.location * self._weights
            value += float(((miss**2).sum(axis=-1) * weights).sum())
            cotangent += torques(skeleton, pose, 2.0 * weights[..., None] * miss)
        return value, geodesics.pull_back(self._segment, self._fraction, rotations, cotangent)

    def _rebuild(self, parameters: MetricParameters, effort: Effort) -> Array:
        geodesics = PoseGeodesics.between(self._keys[:-1], self._keys[1:], parameters, effort=effort)
        return geodesics(self._segment, self._fraction)


def _smooth(angle: Array) -> Array:
    return np.hypot(angle, SMOOTHING) - SMOOTHING
