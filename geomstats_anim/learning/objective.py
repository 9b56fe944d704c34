"""What learning minimises: the quality of an animation rebuilt from its keys, and its exact gradient by the curve."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.curves import locate
from geomstats_anim.kinematics import place, pull_back_ends, world_pose
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.quality import joint_weights, kind_shares
from geomstats_anim.rotations import Array
from geomstats_anim.shortest import Effort
from geomstats_anim.splines import PathSpline, PoseSpline

SMOOTHING = 1e-5
"""Angle in radians below which the rotation error is rounded off, since an angle has no derivative at 0."""


@dataclass
class Objective:
    """Quality of an animation rebuilt from its keys, as a function of the metric and the tension.

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
    _last: PoseSpline | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Prepare what does not depend on the metric."""
        animation = self.animation
        keys = animation.at_frames(np.asarray(self.keyframes, dtype=np.intp))
        self._keys = keys
        self._segment, self._fraction = locate(keys.times, animation.times)
        self._shares = kind_shares(self.kind, self.location_weight)
        scored = np.ones(animation.n_frames, dtype=bool) if self.scored is None else self.scored
        self._counts = scored
        by_joint = joint_weights(self.weights, animation.skeleton) / max(1, scored.sum())
        self._weights = scored[:, None] * by_joint
        self._truth = world_pose(animation).ends

    @property
    def n_segments(self) -> int:
        """Number of segments between keys."""
        return self._keys.n_frames - 1

    def only(self, segments: np.ndarray) -> Objective:
        """Score only the frames of some segments."""
        return replace(self, scored=self._counts & np.isin(self._segment, segments), _last=None)

    def without(self, segments: np.ndarray) -> Objective:
        """Score only the frames of the other segments."""
        return replace(self, scored=self._counts & ~np.isin(self._segment, segments), _last=None)

    def rotation_errors_by_joint(self, curve: CurveParameters, effort: Effort = "thorough") -> Array:
        """Weighted mean rotation error of each joint, radians, shape=[B]; its minima are independent."""
        rotations = self._spline(curve, effort)(self._segment, self._fraction)
        return (self._weights * _smooth(quat.distance(self.animation.rotations, rotations))).sum(axis=0)

    def errors_by_joint(self, curve: CurveParameters) -> Array:
        """Rotation error of each joint, and its part of the quality, shape=[2, B]; the parts add up to `value`.

        A rotation error depends on the metric and tension of its own joint, a part on those of the joints above it too.
        """
        rotations = self._spline(curve, "thorough")(self._segment, self._fraction)
        rotation = _smooth(quat.distance(self.animation.rotations, rotations))
        part = self._shares.rotation * rotation
        if self._shares.location:
            translations = self._path(curve)(self._segment, self._fraction)
            miss = place(self.animation.skeleton, rotations, translations).ends - self._truth
            part += self._shares.location * (miss**2).sum(axis=-1)
        return np.stack([(self._weights * errors).sum(axis=0) for errors in (rotation, part)])

    def value(self, curve: CurveParameters) -> float:
        """Quality of what `interpolate` makes of the keys; 0 is perfect."""
        return float(self.errors_by_joint(curve)[1].sum())

    def value_and_gradient(self, curve: CurveParameters) -> tuple[float, Array]:
        """Quality, and its derivative.

        The geodesics are followed from those of the last call, if it had the same sides, which is quick.

        Returns
        -------
        value : float
        gradient : array-like, shape=[B, 7]
            By log alpha, log beta, a rotation vector that turns the axes from the left, and both tensions.
        """
        near = self._last
        if near is not None and near.geodesics.parameters.invariance != curve.metric.invariance:
            near = None
        spline = self._last = self._spline(curve, "quick", near)
        rotations = spline(self._segment, self._fraction)
        skeleton = self.animation.skeleton
        value, by_translation_tension = 0.0, np.zeros(skeleton.n_joints)
        cotangent = np.zeros((*rotations.shape[:2], 3))
        if self._shares.rotation:
            miss = quat.log(quat.multiply(quat.conjugate(self.animation.rotations), rotations))
            angle = np.linalg.norm(miss, axis=-1)
            weights = self._shares.rotation * self._weights
            value += float((_smooth(angle) * weights).sum())
            cotangent += miss * (weights / np.hypot(angle, SMOOTHING))[..., None]
        if self._shares.location:
            path = self._path(curve)
            pose = place(skeleton, rotations, path(self._segment, self._fraction))
            miss = pose.ends - self._truth
            weights = self._shares.location * self._weights
            value += float(((miss**2).sum(axis=-1) * weights).sum())
            by_rotation, by_translation = pull_back_ends(skeleton, pose, 2.0 * weights[..., None] * miss)
            cotangent += by_rotation
            by_translation_tension = path.pull_back(self._segment, self._fraction, by_translation)
        by_metric, by_tension = spline.pull_back(self._segment, self._fraction, rotations, cotangent)
        by_tensions = np.stack([by_tension, by_translation_tension], axis=-1)
        return value, np.concatenate([by_metric, by_tensions], axis=-1)

    def _spline(self, curve: CurveParameters, effort: Effort, near: PoseSpline | None = None) -> PoseSpline:
        keys = self._keys
        return PoseSpline(keys.times, keys.rotations, curve.metric, curve.tension, near, effort)

    def _path(self, curve: CurveParameters) -> PathSpline:
        return PathSpline(self._keys.times, self._keys.translations, curve.translation_tension)


def _smooth(angle: Array) -> Array:
    return np.hypot(angle, SMOOTHING) - SMOOTHING
