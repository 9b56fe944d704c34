"""A library: the models of all lengths of segments of one rig, and what they do for a clip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.interpolation.learned_scheme import Help, PartHelp
from geomstats_anim.interpolation.residuals import Residual
from geomstats_anim.interpolation.splines import PoseSpline
from geomstats_anim.learning.library.context import Contexts, contexts_of
from geomstats_anim.learning.library.gap_model import GapModel, nearest_models
from geomstats_anim.learning.library.mirror import Mirror, mirror_of
from geomstats_anim.learning.library.one_thread import one_thread
from geomstats_anim.learning.library.parts import BodyParts, body_parts
from geomstats_anim.learning.library.samples import GAP_RATE
from geomstats_anim.learning.library.self_check import MOST_HIDDEN, HiddenPoses, best_shares, spread
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

MIN_KEYS = 5
"""With fewer, there is no telling whether a prediction helps."""

_SAME_DIRECTION, _SHORT = 0.9, 1e-3
"""Cosine between bones of one rig, and metres that are too short to have a direction."""


@dataclass(frozen=True, eq=False)
class MotionLibrary:
    """Models of one rig.

    Parameters
    ----------
    skeleton : Skeleton
    vertical : array-like, shape=[3]
        Unit vector upwards in the space of the skeleton.
    usual : array-like, shape=[B, 4]
        Mean rotations of the joints over the clips.
    models : tuple of GapModel
        By increasing gap.
    provenance : mapping
        Plain values: what it was learned from.
        Optional, default: empty.
    """

    skeleton: Skeleton
    vertical: Array
    usual: Array
    models: tuple[GapModel, ...]
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def mirror(self) -> Mirror | None:
        """Return how the rig is mirrored; None if names or bones have no sides."""
        return mirror_of(self.skeleton, self.vertical, self.usual)

    @cached_property
    def parts(self) -> BodyParts:
        """Return the parts of the body of the rig."""
        return body_parts(self.skeleton)

    def help(self, keys: Animation, curve: CurveParameters) -> Help:
        """Predict residuals of the spline through keys, as far as they help this clip.

        Parameters
        ----------
        keys : Animation
        curve : CurveParameters
            Of the spline.

        Returns
        -------
        help : Help
            The spline, if there are fewer than 5 keys, or the library is empty or of another rig.
        """
        if not self.models or self.rig_difference(keys.skeleton):
            return Help(None)
        place = {joint: i for i, joint in enumerate(keys.skeleton.joints)}
        order = np.array([place[joint] for joint in self.skeleton.joints], dtype=np.intp)
        with one_thread():
            shares, residual = self._checked(keys.times, keys.rotations.take(order, axis=1), curve.at(order))
        return Help(None if residual is None else residual.at_joints(np.argsort(order)), self._described(shares))

    def _checked(self, times: Array, rotations: Array, curve: CurveParameters) -> tuple[Array, Residual | None]:
        """Return the shares of the parts, and the shared residual of the joints, in the order of the library."""
        shares = np.zeros(len(self.parts.joints))
        if len(times) < MIN_KEYS:
            return shares, None
        images = self._images(rotations)
        shares = self._self_check(times, images, curve)
        if not shares.any():
            return shares, None
        return shares, self._residual(times, images).shared(shares[self.parts.of_joint])

    def rig_difference(self, skeleton: Skeleton) -> str:
        """Return how another rig differs, in words; "" if it is this one."""
        if _is_same(self.skeleton, skeleton):
            return ""
        own, others = set(self.skeleton.joints), set(skeleton.joints)
        if own != others:
            return f"{len(own & others)} of its {len(own)} joints are among the {len(others)} of the clip"
        place = {joint: i for i, joint in enumerate(skeleton.joints)}
        order = np.array([place[joint] for joint in self.skeleton.joints], dtype=np.intp)
        parents = [skeleton.joints[p] if p >= 0 else "" for p in skeleton.parents[order]]
        for i, (joint, parent) in enumerate(zip(self.skeleton.joints, parents, strict=True)):
            if parent != (self.skeleton.joints[p] if (p := self.skeleton.parents[i]) >= 0 else ""):
                return f"joint {joint} has another parent"
        bones = np.setdiff1d(np.arange(len(order)), self.parts.trunk)
        mine, theirs = self.skeleton.rest_translations[bones], skeleton.rest_translations[order][bones]
        lengths = np.linalg.norm(mine, axis=-1) * np.linalg.norm(theirs, axis=-1)
        turned = bones[((mine * theirs).sum(axis=-1) < _SAME_DIRECTION * lengths) & (lengths > _SHORT**2)]
        return f"the bone to joint {self.skeleton.joints[turned[0]]} points elsewhere" if len(turned) else ""

    def _described(self, shares: Array) -> tuple[PartHelp, ...]:
        parts, joints = self.parts, self.skeleton.joints
        return tuple(
            PartHelp(kind, joints[of_part[0]] if len(of_part) else "", float(share))
            for kind, of_part, share in zip(parts.kinds, parts.joints, shares, strict=True)
        )

    def _images(self, rotations: Array) -> Array:
        """Return rotations, and how they are mirrored if the rig is, shape=[images, K, B, 4]."""
        return np.stack([rotations] if self.mirror is None else [rotations, self.mirror.rotations(rotations)])

    def _residual(self, times: Array, images: Array) -> Residual:
        """Predict the segments from each key to the next."""
        gaps, contexts = np.diff(times), contexts_of(times, images, self.parts.trunk, self.vertical)
        return Residual.through_keys(self._mean_sines(gaps, contexts), gaps, contexts.holds[: len(gaps)])

    def _mean_sines(self, gaps: Array, contexts: Contexts) -> Array:
        """Predict segments, given by contexts of one image after the other; the mean over the images."""
        if self.mirror is None:
            return self._sines(gaps, contexts, 1)
        sines = self._sines(np.tile(gaps, 2), contexts, 2)
        return 0.5 * (sines[: len(gaps)] + self.mirror.rotation_vectors(sines[len(gaps) :]))

    def _sines(self, gaps: Array, contexts: Contexts, n_images: int) -> Array:
        """Predict all segments, each by the model of the nearest gap, seconds; 0 where none is near."""
        nearest = nearest_models(self.models, GAP_RATE * gaps)
        used = sorted(set(nearest.tolist()) - {-1})
        if len(used) == 1 and nearest.min() == used[0]:
            return self.models[used[0]].predict(contexts, n_images)
        most = max((self.models[i].n_sines for i in used), default=1)
        sines = np.zeros((len(gaps), most, self.skeleton.n_joints, 3))
        for i in used:
            model, segments = self.models[i], np.flatnonzero(nearest == i)
            sines[segments, : model.n_sines] = model.predict(contexts.at(segments), n_images)
        return sines

    def _self_check(self, times: Array, images: Array, curve: CurveParameters) -> Array:
        """Predict keys between others from every second other, and choose the shares that help most.

        Of few keys both halves are hidden in turn, of more one half, and of many some of it.
        """
        step = 2 if len(times) - 2 > MOST_HIDDEN else 1
        hidden, known, stride = slice(1, len(times) - 1, step), slice(None, None, step), 2 // step
        starts, gaps, truth = times[:-2:step], times[2::step] - times[:-2:step], images[0, hidden]
        fraction, chosen = (times[hidden] - starts) / gaps, spread(len(truth), MOST_HIDDEN)
        contexts = contexts_of(times[known], images[:, known], self.parts.trunk, self.vertical, stride)
        sines, holds = self._sines_near(chosen, stride, gaps, contexts), contexts.holds[: len(truth)]
        splines, residuals = np.empty_like(truth), np.empty_like(truth[..., :3])
        for first in range(stride):
            of_half, keys = slice(first, None, stride), slice(first, None, 2)
            at = np.arange(len(gaps[of_half])), fraction[of_half]
            splines[of_half] = PoseSpline(times[keys], images[0, keys], curve.metric, curve.tension)(*at)
            residuals[of_half] = Residual.through_keys(sines[of_half], gaps[of_half], holds[of_half])(*at)
        poses = HiddenPoses(self.skeleton, self.parts, splines[chosen], residuals[chosen], truth[chosen])
        return best_shares(poses, self._doubts(np.diff(times)))

    def _sines_near(self, chosen: np.ndarray, stride: int, gaps: Array, contexts: Contexts) -> Array:
        """Predict some segments and those that they meet, in place among all; the others stay 0."""
        near = np.unique(np.clip(chosen[:, None] + [-stride, 0, stride], 0, len(gaps) - 1))
        of_images = near + len(gaps) * np.arange(len(contexts.poses) // len(gaps))[:, None]
        found = self._mean_sines(gaps[near], contexts.at(of_images.ravel()))
        sines = np.zeros((len(gaps), *found.shape[1:]))
        sines[near] = found
        return sines

    def _doubts(self, gaps: Array) -> Array:
        """Return the doubts of the models of segments, their mean, shape=[parts, shares, 2]."""
        nearest = nearest_models(self.models, GAP_RATE * gaps)
        used = np.bincount(nearest[nearest >= 0], minlength=len(self.models))
        return np.tensordot(used / max(1, used.sum()), self._all_doubts, (0, 0))

    @cached_property
    def _all_doubts(self) -> Array:
        return np.stack([model.doubts for model in self.models])


def _is_same(first: Skeleton, second: Skeleton) -> bool:
    return (
        first.joints == second.joints
        and np.array_equal(first.parents, second.parents)
        and np.array_equal(first.rest_translations, second.rest_translations)
    )
