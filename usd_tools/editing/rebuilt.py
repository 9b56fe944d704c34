"""Motion rebuilt from keys, at the frames that are shown; an edit changes what depends on it, and no more."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomstats_anim import SCHEMES, Animation
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.interpolation.curves import Curve, Fallback
from geomstats_anim.interpolation.metric_schemes import Geodesic
from geomstats_anim.markers import Markers, joint_matrices, world_errors
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
    animation : Animation
        At the frames.
    matrices : array-like, shape=[F, B, 3, 4]
        Of its joints in the world, see `joint_matrices`.
    """

    motion: EditableMotion
    state: EditState
    curves: tuple[Curve, ...]
    effort: Effort
    animation: Animation
    matrices: Array

    @classmethod
    def of(cls, motion: EditableMotion, state: EditState) -> RebuiltMotion:
        """Rebuild motion from nothing but keys and a metric."""
        scheme = state.metric.scheme
        metric = state.metric if scheme in WITH_METRIC else None
        curves = tuple(
            SCHEMES[scheme](part.animation.at_frames(kept), metric)
            for part, kept in zip(motion.parts, state.keyframes(motion), strict=True)
        )
        animation = _at(motion, curves, motion.held)
        return cls(motion, state, curves, "thorough", animation, joint_matrices(animation))

    def following(self, state: EditState, effort: Effort = "thorough") -> RebuiltMotion:
        """Rebuild motion for another state, and of this motion take what both share."""
        if state is self.state and effort in (self.effort, "quick"):
            return self
        if state.metric.scheme != self.state.metric.scheme or not np.array_equal(state.is_key, self.state.is_key):
            return RebuiltMotion.of(self.motion, state)
        if state.metric.scheme not in WITH_METRIC:
            return self
        curves = tuple(curve.with_metric(state.metric, effort) for curve in self.curves if isinstance(curve, Geodesic))
        animation = _at(self.motion, curves, self.motion.held)
        matrices = joint_matrices(animation)
        return replace(self, state=state, curves=curves, effort=effort, animation=animation, matrices=matrices)

    def at(self, times: Array) -> Animation:
        """Return the motion at any times, seconds, shape=[F]."""
        original = self.motion.original_at(times)
        frame = np.clip(np.searchsorted(self.motion.times, times, side="right") - 1, 0, None)
        values = {name: getattr(self.motion.held, name)[frame] for name in ("rotations", "translations")}
        return _at(self.motion, self.curves, replace(original, **values))

    @property
    def fallbacks(self) -> tuple[Fallback, ...]:
        """Segments that are slerped because their geodesic was not found."""
        return tuple(fallback for curve in self.curves for fallback in curve.fallbacks)

    @cached_property
    def errors(self) -> EditErrors:
        """Distances from the original."""
        frames = self.motion.sampled
        ours, truth = self.animation.at_frames(frames), self.motion.original.at_frames(frames)
        return EditErrors(
            frames,
            np.degrees(quat.distance(truth.rotations, ours.rotations)),
            100.0 * world_errors(ours, truth, Markers.of_ends(truth.skeleton)),
        )


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
