"""Learn a library of clips of one rig."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation
from geomstats_anim.learning.library.gap_model import GapModel
from geomstats_anim.learning.library.motion_library import MotionLibrary
from geomstats_anim.learning.library.one_thread import one_thread
from geomstats_anim.learning.library.parts import body_parts
from geomstats_anim.learning.library.samples import GAPS, MOST_SAMPLES, samples_of
from geomstats_anim.rotations import Array

UP: Array = np.array([0.0, 1.0, 0.0])
UP.setflags(write=False)


def learn_library(
    clips: Sequence[Animation],
    vertical: ArrayLike = UP,
    gaps: Sequence[int] = GAPS,
    seed: int = 0,
    provenance: Mapping[str, Any] | None = None,
    progress: Callable[[float], None] = lambda gaps: None,
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
    parts, models = body_parts(skeleton), []
    with one_thread():
        for done, gap in enumerate(gaps, 1):
            samples = samples_of(clips, gap, parts.trunk, up)
            if samples is not None:
                rng = np.random.default_rng(seed)
                chosen = np.sort(rng.permutation(len(samples.clip))[:MOST_SAMPLES])
                models.append(GapModel.fitted(gap, samples.at(chosen), parts, rng))
            progress(done)
    if not models:
        raise ValueError("The clips are too short to learn from: none has two gaps of two frames.")
    return MotionLibrary(skeleton, up, tuple(models), dict(provenance or {}))
