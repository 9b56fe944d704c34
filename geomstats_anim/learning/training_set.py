"""Animations of one rig, with the frames of each that are kept, to learn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.criteria import quality
from geomstats_anim.interpolation.schemes import SCHEMES
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.learning.objective import Objective
from geomstats_anim.learning.settings import LearnSettings


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """Animations of one rig and their keys, from which a metric is learned.

    Parameters
    ----------
    animations : sequence of Animation
        The truth, of the same joints.
    keyframes : sequence of array-like of int, shape=[K]
        Frames of each that are kept, the first and the last included.

    Raises
    ------
    ValueError
        If the joints differ, keys do not increase from the first frame to the last, every frame is a key, or no joint
        turns.
    """

    animations: tuple[Animation, ...]
    keyframes: tuple[np.ndarray, ...]

    def __post_init__(self) -> None:
        """Check the animations and their keys."""
        if not self.animations or len(self.animations) != len(self.keyframes):
            raise ValueError(
                f"There are {len(self.animations)} animations and keys for {len(self.keyframes)}; "
                "one set for each is needed."
            )
        for number, (clip, kept) in enumerate(self._pairs()):
            if clip.skeleton.joints != self.joints:
                raise ValueError(f"Animation {number} has other joints than the first.")
            if len(kept) < 2 or kept[0] != 0 or kept[-1] != clip.n_frames - 1 or (np.diff(kept) <= 0).any():
                raise ValueError(
                    f"The keys of animation {number} must increase from frame 0 to frame {clip.n_frames - 1}."
                )
        if all(len(kept) == clip.n_frames for clip, kept in self._pairs()):
            raise ValueError("Every frame is a key, so there is nothing to rebuild; keep fewer keys.")
        if not any(turns(clip) for clip in self.animations):
            raise ValueError("No joint turns, so there is nothing to learn.")

    @classmethod
    def of(cls, animation: Animation | Sequence[Animation], keyframes: ArrayLike | Sequence[ArrayLike]) -> TrainingSet:
        """Take the arguments of `learn_metric`: one animation and its keys, or as many of both."""
        if isinstance(animation, Animation):
            return cls((animation,), (_frames(cast(ArrayLike, keyframes)),))
        return cls(tuple(animation), tuple(_frames(kept) for kept in cast(Sequence[ArrayLike], keyframes)))

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the names of the joints."""
        return self.animations[0].skeleton.joints

    @property
    def n_segments(self) -> int:
        """Return the number of segments between keys, in all."""
        return sum(len(kept) - 1 for kept in self.keyframes)

    def objectives(self, settings: LearnSettings) -> list[Objective]:
        """Make the objective of each animation."""
        return [
            Objective(clip, kept, settings.kind, settings.weights, settings.location_weight)
            for clip, kept in self._pairs()
        ]

    def score(self, scheme: str, metric: LearnedMetric | None, settings: LearnSettings) -> float:
        """Rebuild all animations, and return the mean quality over all frames."""
        total = 0.0
        for clip, kept in self._pairs():
            rebuilt = SCHEMES[scheme](clip.at_frames(kept), metric)(clip.times)
            value = quality(rebuilt, clip, settings.kind, settings.weights, settings.location_weight)
            total += clip.n_frames * value
        return total / sum(clip.n_frames for clip in self.animations)

    def _pairs(self) -> list[tuple[Animation, np.ndarray]]:
        return list(zip(self.animations, self.keyframes, strict=True))


def turns(animation: Animation) -> bool:
    """Return whether any joint turns."""
    return bool((quat.distance(animation.rotations, animation.rotations[:1]) >= STILL).any())


def _frames(keyframes: ArrayLike) -> np.ndarray:
    """Take indices, and refuse what is not whole."""
    frames = np.asarray(keyframes)
    if frames.size and not np.equal(frames, np.round(frames)).all():
        raise ValueError(f"keyframes must be whole numbers, but one is {frames[frames != np.round(frames)][0]}.")
    return frames.astype(np.intp)
