"""Learn a library of clips of one rig."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation
from geomstats_anim.learning.library.actions import cluster_clips
from geomstats_anim.learning.library.doubts import LeftOut, doubts_of, errors_left_out
from geomstats_anim.learning.library.gap_model import GapModel, fit_gap, nearest_models
from geomstats_anim.learning.library.mirror import Mirror, mirror_of, usual_pose
from geomstats_anim.learning.library.motion_library import MotionLibrary
from geomstats_anim.learning.library.one_thread import one_thread
from geomstats_anim.learning.library.parts import BodyParts, body_parts
from geomstats_anim.learning.library.samples import GAPS, MOST_SAMPLES, samples_of
from geomstats_anim.rotations import Array

UP: Array = np.array([0.0, 1.0, 0.0])
UP.setflags(write=False)

_CLUSTERED = 8
"""Length of the segments by which clips are clustered, in frames of 30 per second, where there are any."""


def learn_library(
    clips: Sequence[Animation],
    vertical: ArrayLike = UP,
    gaps: Sequence[int] = GAPS,
    seed: int = 0,
    provenance: Mapping[str, Any] | None = None,
    progress: Callable[[float], None] = lambda gaps: None,
    address: str | None = None,
    cpus: int | None = None,
) -> MotionLibrary:
    """Learn what splines miss of clips, for others of the same rig and like motion.

    Parameters
    ----------
    clips : sequence of Animation
        Of one rig, its joints in one order.
    vertical : array-like, shape=[3]
        Unit vector upwards in the space of the skeleton.
        Optional, default: y.
    gaps : sequence of int
        Lengths of segments to learn for, in frames of 30 per second.
        Optional, default: `GAPS`.
    seed : int
        Of the choice of samples and centres.
        Optional, default: 0.
    provenance : mapping
        Plain values to keep with it.
        Optional, default: none.
    progress : callable
        Called with the number of gaps that are done.
        Optional, default: nobody is told.
    address : str
        HOST:PORT of a Ray cluster, over which the gaps are spread; the result is the same.
        Optional, default: the environment variable RAY_ADDRESS, else none.
    cpus : int
        Workers; Ray is started for more than one.
        Optional, default: 1.

    Returns
    -------
    library : MotionLibrary

    Raises
    ------
    ValueError
        If there is no clip, the joints of one differ, or all are too short to learn from.
    """
    if not clips:
        raise ValueError("A library needs at least one clip, but there is none.")
    skeleton, up = clips[0].skeleton, np.array(vertical, dtype=np.float64)
    if any(clip.skeleton.joints != skeleton.joints for clip in clips):
        raise ValueError("A library is of one rig, but the joints of the clips differ.")
    parts = body_parts(skeleton)
    with one_thread():
        usual = usual_pose(np.concatenate([clip.rotations for clip in clips]))
        mirror, actions, n_recorded = mirror_of(skeleton, up, usual), _actions(clips, parts, up), len(clips)
        if mirror is not None:
            clips = [*clips, *map(mirror.animation, clips)]
        task = _GapTask(clips, n_recorded, parts, up, actions, seed)
        fits = [fit for fit in _spread(task, gaps, progress, address, cpus) if fit is not None]
    if not fits:
        raise ValueError("The clips are too short to learn from: none has two gaps of two frames.")
    return MotionLibrary(skeleton, up, usual, _with_doubts(fits, parts, mirror), dict(provenance or {}))


@dataclass(frozen=True, eq=False)
class _GapTask:
    """Data that the models of all lengths are fitted to: recorded clips, then perhaps the mirror images of each."""

    clips: Sequence[Animation]
    n_recorded: int
    parts: BodyParts
    vertical: Array
    actions: np.ndarray
    seed: int

    def __call__(self, gap: int) -> tuple[GapModel, LeftOut] | None:
        """Fit the model of one length, and return its errors on actions left out; None if no clip is long enough."""
        samples = samples_of(self.clips, gap, self.parts.trunk, self.vertical)
        if samples is None:
            return None
        rng = np.random.default_rng(self.seed)
        samples = samples.at(np.sort(rng.permutation(len(samples.clip))[:MOST_SAMPLES]))
        # a mirror image is of the clip that it mirrors
        samples = replace(samples, clip=samples.clip % self.n_recorded)
        with one_thread():
            model, left_out = fit_gap(gap, samples, self.parts, self.actions, rng)
            return model, errors_left_out(samples, left_out, self.clips[0].skeleton, self.parts, rng)


def _actions(clips: Sequence[Animation], parts: BodyParts, vertical: Array) -> np.ndarray:
    """Cluster the clips at the length that is nearest to that of most use."""
    for gap in sorted(GAPS, key=lambda gap: abs(np.log(gap / _CLUSTERED))):
        samples = samples_of(clips, gap, parts.trunk, vertical)
        if samples is not None:
            return cluster_clips(samples, parts, len(clips))
    return np.zeros(len(clips), dtype=np.intp)


def _spread(
    task: _GapTask, gaps: Sequence[int], progress: Callable[[float], None], address: str | None, cpus: int | None
) -> list[tuple[GapModel, LeftOut] | None]:
    """Fit all models, here or on workers."""
    from geomstats_anim.learning.tune import ray_runtime

    if not ray_runtime.is_wanted(address, cpus):
        fits = []
        for done, gap in enumerate(gaps, 1):
            fits.append(task(gap))
            progress(done)
        return fits
    with ray_runtime.running(address, cpus):
        return ray_runtime.map_tasks(task, gaps, progress)


def _with_doubts(
    fits: Sequence[tuple[GapModel, LeftOut]], parts: BodyParts, mirror: Mirror | None
) -> tuple[GapModel, ...]:
    """Give each model its doubts, from the errors of that of twice its length; both sides of the body the same."""
    other = np.arange(len(parts.joints))
    if mirror is not None:
        other = parts.of_joint[mirror.counterpart[[joints[0] for joints in parts.joints]]]
    models = [model for model, _ in fits]
    doubles = nearest_models(models, np.array([2.0 * model.gap for model in models]))
    found = []
    for (model, left_out), double in zip(fits, doubles, strict=True):
        doubts = doubts_of(left_out, fits[double][1] if double >= 0 else None)
        found.append(replace(model, doubts=0.5 * (doubts + doubts[other])))
    return tuple(found)
