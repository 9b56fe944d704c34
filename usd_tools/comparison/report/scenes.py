"""Clips as points and bones to draw: in the world, z up, whatever the file says is up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geomstats_anim import Animation, LearnedMetric
from geomstats_anim.interpolation.learned_scheme import Help
from geomstats_anim.kinematics import place, world_pose
from geomstats_anim.markers import Markers, world_errors
from usd_tools.characters.bones import Bones
from usd_tools.characters.placement import upright
from usd_tools.comparison.options import SchemeChoice
from usd_tools.comparison.results import ComparedClip
from usd_tools.comparison.trials import Rebuilt, TrialResult, rebuild


@dataclass(frozen=True, eq=False)
class Scene:
    """A clip, and what each scheme makes of it at one rate.

    Parameters
    ----------
    compared : ComparedClip
    rate : float
    choices : tuple of SchemeChoice
    metrics : mapping of str to LearnedMetric or None
        By the words of the choices that did not fail.
    helps : mapping of str to sequence of Help or None
        What a library did for the stretches, by the same words.
    """

    compared: ComparedClip
    rate: float
    choices: tuple[SchemeChoice, ...]
    metrics: Mapping[str, LearnedMetric | None]
    helps: Mapping[str, Sequence[Help] | None]

    @property
    def name(self) -> str:
        """Name of the clip."""
        return self.compared.name

    @property
    def stretches(self) -> tuple[Animation, ...]:
        """The original."""
        return self.compared.take.stretches

    @property
    def original(self) -> Animation:
        """The original, its stretches one after the other."""
        return joined(self.stretches)

    @cached_property
    def rebuilt(self) -> dict[str, Rebuilt]:
        """Rebuilt stretches, by the words of the schemes."""
        return {
            choice.word: rebuild(
                self.stretches, self.rate, choice.scheme, self.metrics[choice.word], self.helps[choice.word]
            )
            for choice in self.choices
            if choice.word in self.metrics
        }

    @cached_property
    def times(self) -> np.ndarray:
        """Seconds of all frames, shape=[F]."""
        return np.concatenate([stretch.times for stretch in self.stretches])

    @cached_property
    def is_key(self) -> np.ndarray:
        """Mask of the frames that are kept, shape=[F]."""
        any_of = next(iter(self.rebuilt.values()))
        parts = [np.isin(np.arange(s.n_frames), keys) for s, keys in zip(self.stretches, any_of.keys, strict=True)]
        return np.concatenate(parts)

    @cached_property
    def errors(self) -> dict[str, np.ndarray]:
        """Mean distance of bone ends in centimetres in each frame, shape=[F], by the words of schemes."""
        return {
            word: np.concatenate(
                [
                    100.0 * world_errors(new, truth, Markers.of_ends(truth.skeleton)).mean(axis=1)
                    for new, truth in zip(rebuilt.stretches, self.stretches, strict=True)
                ]
            )
            for word, rebuilt in self.rebuilt.items()
        }

    @cached_property
    def bones(self) -> Bones:
        """Lines between points."""
        return Bones.of(self.compared.take.skeleton)

    @cached_property
    def _turn(self) -> np.ndarray:
        return upright(self.compared.clip)

    def points(self, word: str | None = None) -> np.ndarray:
        """Points in metres of the original, or of what a scheme makes of it, shape=[F, P, 3]."""
        parts = self.stretches if word is None else self.rebuilt[word].stretches
        found = []
        for part in parts:
            pose = world_pose(part)
            found.append(np.concatenate([pose.origins, pose.ends[:, self.bones.leaves]], axis=1))
        return np.concatenate(found) @ self._turn

    @cached_property
    def rest_points(self) -> np.ndarray:
        """Points of the rest pose, shape=[P, 3]."""
        skeleton = self.compared.take.skeleton
        pose = place(skeleton, skeleton.rest_rotations[None], skeleton.rest_translations[None])
        return np.concatenate([pose.origins[0], pose.ends[0, self.bones.leaves]]) @ self._turn

    @property
    def most_different(self) -> int:
        """Frame in which the schemes differ most, that which only holds its keys left aside."""
        errors = [error for word, error in self.errors.items() if word != "constant"] or list(self.errors.values())
        spread = np.ptp(errors, axis=0) if len(errors) > 1 else errors[0]
        return int(np.argmax(spread))


def scenes(clips: Sequence[ComparedClip], results: Sequence[TrialResult]) -> list[Scene]:
    """Every clip at every rate at which at least one scheme did not fail."""
    found: dict[tuple[str, float], list[TrialResult]] = {}
    for result in results:
        if not result.trial.unseen and result.row.error is None:
            found.setdefault((result.trial.clip, result.trial.rate), []).append(result)
    by_name = {each.name: each for each in clips}
    return [
        Scene(
            by_name[clip],
            rate,
            tuple(result.trial.choice for result in done),
            {result.trial.choice.word: result.metric for result in done},
            {result.trial.choice.word: result.helps for result in done},
        )
        for (clip, rate), done in found.items()
    ]


def joined(stretches: Sequence[Animation]) -> Animation:
    """Put stretches of one clip one after the other; where they are in the world is left aside."""
    names = ("times", "rotations", "translations", *(() if stretches[0].scales is None else ("scales",)))
    values = {name: np.concatenate([getattr(stretch, name) for stretch in stretches]) for name in names}
    return replace(stretches[0], world=None, **values)


def flattened(points: np.ndarray) -> np.ndarray:
    """Directions of the view plane in which points spread most: one level, one up, shape=[3, 2]."""
    level = points.reshape(-1, 3)[:, :2]
    _, directions = np.linalg.eigh(np.cov((level - level.mean(axis=0)).T))
    x, y = directions[:, -1] * np.sign(directions[np.abs(directions[:, -1]).argmax(), -1])
    return np.array([[x, 0.0], [y, 0.0], [0.0, 1.0]])
