"""Several clips as one objective: in this process, or spread over the workers of Ray."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim.learning.objective import Objective
from geomstats_anim.learning.tune.ray_runtime import one_place_each, require
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

IN_MEMORY = 32
"""Clips that a process keeps in memory; the others wait in files."""


class Corpus:
    """Mean quality of several clips of one rig, as a function of the curve; every scored frame weighs the same.

    The results do not depend on the number of workers, not even in the last bit: each clip sees the same calls, and the
    sum is taken in the order of the clips.

    Parameters
    ----------
    objectives : iterable of Objective
        Of the same joints. Taken one at a time, so a generator need never have them all in memory.
    workers : int
        Processes that evaluate the clips. More than one needs Ray, running: see `ray_runtime.running`.
        Optional, default: 1, this process.
    in_memory : int
        Clips that a process keeps in memory.
        Optional, default: 32.
    """

    def __init__(self, objectives: Iterable[Objective], workers: int = 1, in_memory: int = IN_MEMORY) -> None:
        self._clips: _Shelf | _Spread = _Spread(workers, in_memory) if workers > 1 else _Shelf(in_memory)
        frames = []
        for objective in objectives:
            self.skeleton, self.kind = objective.animation.skeleton, objective.kind
            frames.append(self._clips.add(objective))
        if not frames:
            raise ValueError("A corpus needs at least one clip.")
        self._shares = [count / max(1, sum(frames)) for count in frames]

    def value(self, curve: CurveParameters) -> float:
        """Return the quality; 0 is perfect."""
        return float(self._mean(Objective.value, curve))

    def quality(self, curve: CurveParameters) -> float:
        """Return the quality without the smoothing of `value`."""
        return float(self._mean(Objective.quality, curve))

    def value_and_gradient(self, curve: CurveParameters) -> tuple[float, Array]:
        """Return the quality, and its derivative, shape=[B, 7], as `Objective.value_and_gradient` has it."""
        values, gradients = zip(*self._clips.each(Objective.value_and_gradient, curve), strict=True)
        return float(self._weigh(values)), np.asarray(self._weigh(gradients))

    def rotation_errors_and_gradient(self, curve: CurveParameters, joints: np.ndarray) -> tuple[Array, Array]:
        """Return rotation errors of some joints, and their derivatives, as `Objective.rotation_errors_and_gradient`."""
        run = partial(Objective.rotation_errors_and_gradient, joints=joints)
        errors, gradients = zip(*self._clips.each(run, curve), strict=True)
        return np.asarray(self._weigh(errors)), np.asarray(self._weigh(gradients))

    def rotation_errors_by_joint(self, curve: CurveParameters, joints: np.ndarray | None = None) -> Array:
        """Return the mean rotation error of each joint, radians, as `Objective.rotation_errors_by_joint`."""
        run = partial(Objective.rotation_errors_by_joint, joints=joints)
        return np.asarray(self._mean(run, curve))

    def errors_by_joint(self, curve: CurveParameters) -> Array:
        """Return each joint's rotation error and part of the quality, shape=[2, B], as `Objective.errors_by_joint`."""
        return np.asarray(self._mean(Objective.errors_by_joint, curve))

    def _mean(self, function: Callable[..., Any], curve: CurveParameters) -> Any:
        return self._weigh(self._clips.each(function, curve))

    def _weigh(self, values: Iterable[Any]) -> Any:
        # one after the other: NumPy's own sum groups its terms by their number
        return sum(share * value for share, value in zip(self._shares, values, strict=True))


class _Shelf:
    """Clips in memory up to a number, and in files beyond it; their geodesics, the next start, are kept with them."""

    def __init__(self, in_memory: int) -> None:
        self._in_memory = in_memory
        self._clips: list[Objective | Path] = []
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def add(self, objective: Objective) -> int:
        """Add a clip, and return its number of scored frames."""
        if len(self._clips) < self._in_memory:
            self._clips.append(objective)
        else:
            self._folder = self._folder or tempfile.TemporaryDirectory(prefix="geomstats_anim-")
            self._clips.append(Path(self._folder.name, f"{len(self._clips)}.pickle"))
            self._put(len(self._clips) - 1, objective)
        return objective.animation.n_frames if objective.scored is None else int(objective.scored.sum())

    def each(self, function: Callable[..., Any], curve: CurveParameters) -> list[Any]:
        """Evaluate a function of every clip."""
        results = []
        for i, objective in enumerate(self):
            results.append(function(objective, curve))
            self._put(i, objective)
        return results

    def __iter__(self) -> Iterator[Objective]:
        for clip in self._clips:
            yield pickle.loads(clip.read_bytes()) if isinstance(clip, Path) else clip

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel whole, as files do not; out of Ray's object store, all clips together take no memory of their own."""
        return _Shelf._of, (list(self),)

    @classmethod
    def _of(cls, clips: list[Objective | Path]) -> _Shelf:
        shelf = cls(len(clips))
        shelf._clips = clips
        return shelf

    def _put(self, i: int, objective: Objective) -> None:
        path = self._clips[i]
        if isinstance(path, Path):
            with path.open("wb") as file:
                pickle.dump(objective, file, protocol=pickle.HIGHEST_PROTOCOL)


class _Spread:
    """A shelf in each of several processes of Ray, filled in turn."""

    def __init__(self, workers: int, in_memory: int) -> None:
        # an actor that only holds clips takes no processor from those that run trials
        shelf = require("ray").remote(_Shelf)
        self.shelves = [shelf.options(num_cpus=0, **there).remote(in_memory) for there in one_place_each(workers)]
        self._n_clips = 0

    def add(self, objective: Objective) -> int:
        shelf = self.shelves[self._n_clips % len(self.shelves)]
        self._n_clips += 1
        return int(require("ray").get(shelf.add.remote(objective)))

    def each(self, function: Callable[..., Any], curve: CurveParameters) -> list[Any]:
        by_shelf = require("ray").get([shelf.each.remote(function, curve) for shelf in self.shelves])
        n_shelves = len(self.shelves)
        return [by_shelf[i % n_shelves][i // n_shelves] for i in range(self._n_clips)]
