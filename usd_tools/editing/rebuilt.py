"""Motion rebuilt from keys, at the frames that are shown; an edit changes what depends on it, and no more."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomstats_anim import Animation
from geomstats_anim import rotations as quat
from geomstats_anim.animation import descendants
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.interpolation.curves import Curve, Fallback
from geomstats_anim.interpolation.metric_schemes import Geodesic
from geomstats_anim.interpolation.schemes import make_curve
from geomstats_anim.markers import distances_between, place_some
from geomstats_anim.names import WITH_METRIC
from geomstats_anim.rotations import Array
from usd_tools.editing.motion import EditableMotion
from usd_tools.editing.state import EditState


@dataclass(frozen=True, eq=False)
class EditErrors:
    """Distances of rebuilt motion from the original, by frame and joint.

    Parameters
    ----------
    frames : array-like of int, shape=[N]
        Frames at which the clip has a sample.
    degrees : array-like, shape=[N, B]
        Angles between local rotations.
    centimetres : array-like, shape=[N, B]
        Distances of bone ends in the world.
    """

    frames: np.ndarray
    degrees: Array
    centimetres: Array


_ARRAYS = ("rotations", "translations", "matrices", "degrees", "centimetres")
"""Parts that an edit changes."""


@dataclass(frozen=True, eq=False)
class RebuiltMotion:
    """Motion rebuilt from keys.

    Parameters
    ----------
    motion : EditableMotion
    state : EditState
        Keys and metric that it is rebuilt from.
    curves : tuple of Curve
        Through the keys of each stretch.
    effort : str
        How geodesics were searched for: "thorough", or "quick" for what is seen while a value is dragged.
    rotations, translations : array-like, shape=[F, B, 4], shape=[F, B, 3]
        At the frames.
    matrices : array-like, shape=[F, B, 3, 4]
        Of joints in the world, see `joint_matrices`.
    degrees, centimetres : array-like, shape=[F, B]
        Distances from the original at all frames, see `EditErrors`.
    """

    motion: EditableMotion
    state: EditState
    curves: tuple[Curve, ...]
    effort: Effort
    rotations: Array
    translations: Array
    matrices: Array
    degrees: Array
    centimetres: Array

    @classmethod
    def of(cls, motion: EditableMotion, state: EditState) -> RebuiltMotion:
        """Rebuild motion from nothing but keys and a metric."""
        scheme = state.metric.scheme
        metric = state.metric if scheme in WITH_METRIC else None
        curves = tuple(
            make_curve(part.animation.at_frames(kept), scheme, metric, state.library(motion))
            for part, kept in zip(motion.parts, state.keyframes(motion), strict=True)
        )
        shown = _at(motion, curves, motion.held)
        shape = (len(motion.codes), motion.skeleton.n_joints)
        new = cls(
            motion,
            state,
            curves,
            "thorough",
            np.array(shown.rotations),
            np.array(shown.translations),
            np.empty((*shape, 3, 4)),
            np.zeros(shape),
            np.zeros(shape),
        )
        new._place(np.arange(shape[1]), np.arange(shape[1]))
        return new

    def following(self, state: EditState, effort: Effort = "thorough") -> RebuiltMotion:
        """Rebuild motion for another state, and of this motion take what both share.

        A preview gives its arrays to the next motion, and is of no use then: copying them takes longest in long clips.
        """
        if state is self.state and effort in (self.effort, "quick"):
            return self
        if state.metric.scheme != self.state.metric.scheme or not np.array_equal(state.is_key, self.state.is_key):
            return RebuiltMotion.of(self.motion, state)
        if state.metric.scheme not in WITH_METRIC:
            return self
        new = replace(
            self,
            state=state,
            effort=effort,
            curves=tuple(curve.with_metric(state.metric, effort) for curve in self._geodesics),
            **{name: getattr(self, name) if self.effort == "quick" else getattr(self, name).copy() for name in _ARRAYS},
        )
        turned, moved = new._take_changes(self)
        new._place(turned, np.union1d(turned, moved))
        return new

    def at(self, times: Array) -> Animation:
        """Return the motion at any times, seconds, shape=[F]."""
        original = self.motion.original_at(times)
        frame = np.clip(np.searchsorted(self.motion.times, times, side="right") - 1, 0, None)
        values = {name: getattr(self.motion.held, name)[frame] for name in ("rotations", "translations")}
        return _at(self.motion, self.curves, replace(original, **values))

    @cached_property
    def animation(self) -> Animation:
        """Return the motion at the frames."""
        return replace(self.motion.original, rotations=self.rotations, translations=self.translations)

    @property
    def errors(self) -> EditErrors:
        """Distances from the original, where the clip has samples."""
        frames = self.motion.sampled
        if len(frames) == len(self.degrees):
            return EditErrors(frames, self.degrees, self.centimetres)
        return EditErrors(frames, self.degrees[frames], self.centimetres[frames])

    @property
    def fallbacks(self) -> tuple[Fallback, ...]:
        """Segments that are slerped because their geodesic was not found."""
        return tuple(fallback for curve in self.curves for fallback in curve.fallbacks)

    @property
    def _geodesics(self) -> tuple[Geodesic, ...]:
        return tuple(curve for curve in self.curves if isinstance(curve, Geodesic))

    def _take_changes(self, before: RebuiltMotion) -> tuple[np.ndarray, np.ndarray]:
        """Write the values of joints whose curves differ from those before, and return which turn and which move."""
        turned, moved = np.zeros((2, self.motion.skeleton.n_joints), dtype=bool)
        for part, curve, old in zip(self.motion.parts, self._geodesics, before._geodesics, strict=True):
            turns, moves = curve.differs(old)
            times = self.motion.times[part.frames]
            if turns.any():
                joints = np.flatnonzero(turns)
                self.rotations[part.frames, joints] = curve.rotations(times, joints)
            if moves.any():
                joints = np.flatnonzero(moves)
                self.translations[part.frames, joints] = curve.translations(times, joints)
            turned, moved = turned | turns, moved | moves
        return np.flatnonzero(turned), np.flatnonzero(moved)

    def _place(self, turned: np.ndarray, changed: np.ndarray) -> None:
        """Write the matrices and errors of joints that have changed, and of all below them."""
        motion, truth = self.motion, self.motion.original
        below = descendants(truth.skeleton, changed)
        place_some(truth, self.rotations, self.translations, below, self.matrices)
        angles = quat.distance(truth.rotations[:, turned], self.rotations[:, turned])
        self.degrees[:, turned] = np.degrees(angles)
        distances = distances_between(self.matrices, motion.matrices, motion.ends.chosen(below))
        self.centimetres[:, below] = 100.0 * distances[:, below]


def _at(motion: EditableMotion, curves: tuple[Curve, ...], base: Animation) -> Animation:
    """Put the curves' values over an animation that holds what is shown elsewhere."""
    rotations, translations = np.array(base.rotations), np.array(base.translations)
    for part, curve in zip(motion.parts, curves, strict=True):
        first, last = part.animation.times[[0, -1]]
        start, stop = np.searchsorted(base.times, first), np.searchsorted(base.times, last, side="right")
        if stop > start:
            dense = curve(base.times[start:stop])
            rotations[start:stop], translations[start:stop] = dense.rotations, dense.translations
    return replace(base, rotations=rotations, translations=translations)
