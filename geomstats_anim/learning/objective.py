"""The objective of learning: the quality of an animation rebuilt from its keys, with its exact gradient."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.criteria import joint_weights, kind_shares
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.interpolation.curves import locate
from geomstats_anim.interpolation.splines import CoupledSpline, PathSpline, PoseSpline
from geomstats_anim.kinematics import place, pull_back_ends, world_pose
from geomstats_anim.learning.rotation_cache import RotationMemory
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

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
        self._path = PathSpline(keys.times, keys.translations, np.zeros(keys.n_joints))
        self._memory = RotationMemory()
        # the last geodesics of each side help to find the next
        self._velocities = np.full((2, keys.n_joints, keys.n_frames - 1, 3), np.nan)
        self._truth = world_pose(animation).ends

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrive in another process: arrays out of Ray's store may not be written to."""
        self.__dict__.update(state)
        self._velocities = self._velocities.copy()

    @property
    def skeleton(self) -> Skeleton:
        """Return the skeleton of the animation."""
        return self.animation.skeleton

    @property
    def n_segments(self) -> int:
        """Return the number of segments between keys."""
        return self._keys.n_frames - 1

    def only(self, segments: np.ndarray) -> Objective:
        """Score only the frames of some segments."""
        return replace(self, scored=self._counts & np.isin(self._segment, segments))

    def without(self, segments: np.ndarray) -> Objective:
        """Score only the frames of the other segments."""
        return replace(self, scored=self._counts & ~np.isin(self._segment, segments))

    def rotation_errors_by_joint(self, curve: CurveParameters, joints: np.ndarray | None = None) -> Array:
        """Return the weighted mean rotation error of each joint, radians, shape=[B], each with a minimum of its own.

        With the indices of some joints, shape=[J], the curve and the errors are theirs alone.
        """
        truth, weights = self.animation.rotations, self._weights
        if joints is not None:
            truth, weights = truth[:, joints], weights[:, joints]
        rotations = self._rotations(curve) if joints is None else self._rebuilt(curve, joints)
        return (weights * _smooth(quat.distance(truth, rotations))).sum(axis=0)

    def rotation_errors_and_gradient(self, curve: CurveParameters, joints: np.ndarray) -> tuple[Array, Array]:
        """Return rotation errors as in `rotation_errors_by_joint`, with derivatives by the joint's own parameters.

        Parameters
        ----------
        curve : CurveParameters
            Of these joints only.
        joints : array-like of int, shape=[J]

        Returns
        -------
        errors : array-like, shape=[J]
        gradient : array-like, shape=[J, 7]
            As in `value_and_gradient`.
        """
        spline = self._spline(curve, "quick", joints)
        rotations = spline(self._segment, self._fraction)
        errors, cotangent = _turned_apart(self.animation.rotations[:, joints], rotations, self._weights[:, joints])
        by_metric, by_tension = spline.pull_back(self._segment, self._fraction, rotations, cotangent)
        return errors, np.concatenate([by_metric, by_tension[:, None], np.zeros((len(joints), 1))], axis=1)

    def errors_by_joint(self, curve: CurveParameters) -> Array:
        """Return each joint's rotation error and part of the quality, shape=[2, B]; the parts add up to `value`.

        A rotation error depends on the metric and tension of its own joint, a part on those of the joints above it too.
        """
        rotation, parts = self._errors(curve, _smooth)
        return np.stack([(self._weights * errors).sum(axis=0) for errors in (rotation, parts)])

    def quality(self, curve: CurveParameters) -> float:
        """Return the quality of what `interpolate` makes of the keys, without the smoothing of `value`."""
        return float((self._weights * self._errors(curve, np.abs)[1]).sum())

    def _errors(self, curve: CurveParameters, smooth: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Return the rotation errors, and the parts of the quality, shape=[F, B]."""
        rotations = self._rotations(curve)
        rotation = smooth(quat.distance(self.animation.rotations, rotations))
        part = self._shares.rotation * rotation
        if self._shares.location:
            translations = self._path.tightened(curve.translation_tension)(self._segment, self._fraction)
            miss = place(self.animation.skeleton, rotations, translations).ends - self._truth
            part += self._shares.location * (miss**2).sum(axis=-1)
        return rotation, part

    def value(self, curve: CurveParameters) -> float:
        """Return the quality of what `interpolate` makes of the keys; 0 is perfect."""
        return float(self.errors_by_joint(curve)[1].sum())

    def value_and_gradient(self, curve: CurveParameters) -> tuple[float, Array]:
        """Return the quality, and its derivative.

        Returns
        -------
        value : float
        gradient : array-like, shape=[B, 7] or shape=[B, 7 + 3 r]
            By log alpha, log beta, a rotation vector that turns the axes from the left, the coupling if the curve has
            one, and both tensions.
        """
        spline = self._spline(curve, "quick")
        rotations = spline(self._segment, self._fraction)
        skeleton = self.animation.skeleton
        by_translation_tension = np.zeros(skeleton.n_joints)
        errors, cotangent = _turned_apart(self.animation.rotations, rotations, self._shares.rotation * self._weights)
        value = float(errors.sum())
        if self._shares.location:
            path = self._path.tightened(curve.translation_tension)
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

    def _rotations(self, curve: CurveParameters) -> Array:
        """Return the rotations of a thoroughly searched curve, shape=[F, B, 4]; not to be written to."""
        if curve.coupling is not None:
            return self._rebuilt(curve)
        return self._memory.recall(curve, self._rebuilt)

    def _rebuilt(self, curve: CurveParameters, joints: np.ndarray | None = None) -> Array:
        return self._spline(curve, "thorough", joints)(self._segment, self._fraction)

    def _spline(
        self, curve: CurveParameters, effort: Effort, joints: np.ndarray | None = None
    ) -> PoseSpline | CoupledSpline:
        keys, sides = self._keys, curve.metric.is_right.astype(np.intp)
        joints = np.arange(keys.n_joints) if joints is None else joints
        near = self._velocities[sides, joints].swapaxes(0, 1) if effort == "quick" else None
        spline: PoseSpline | CoupledSpline
        if curve.coupling is not None:
            spline = CoupledSpline(keys.times, keys.rotations[:, joints], curve, near, effort)
        else:
            spline = PoseSpline(keys.times, keys.rotations[:, joints], curve.metric, curve.tension, near, effort)
        self._velocities[sides, joints] = spline.geodesics.velocity.swapaxes(0, 1)
        return spline


def _smooth(angle: Array) -> Array:
    return np.hypot(angle, SMOOTHING) - SMOOTHING


def _turned_apart(truth: Array, rotations: Array, weights: Array) -> tuple[Array, Array]:
    """Sum rotation errors over frames, shape=[B], and derive them by the body variation of the rotations."""
    miss = quat.difference(truth, rotations)
    rounded = np.hypot(np.linalg.norm(miss, axis=-1), SMOOTHING)
    return ((rounded - SMOOTHING) * weights).sum(axis=0), miss * (weights / rounded)[..., None]
