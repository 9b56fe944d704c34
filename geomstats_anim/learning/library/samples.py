"""Samples of a library: segments between uniform keys, what surrounds them, and what the spline misses in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.interpolation.residuals import basis
from geomstats_anim.interpolation.splines import PoseSpline
from geomstats_anim.learning.library.context import Contexts, contexts_of
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

GAP_RATE = 30.0
"""Gaps are counted in frames of this many per second."""

GAPS = (2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40)
"""Lengths of segments that are learned for, a model each; with each its double, which the self-check needs."""

MOST_SAMPLES = 4500
"""Segments that a model is fitted to."""

_MOST_INNER = 12
"""Frames of a segment at which its residual is fitted."""


def n_sines(gap: int) -> int:
    """Return how many sines the residual in a gap of so many frames is made of."""
    return min(gap - 1, 6) if gap < 6 else (5 if gap < 16 else 6)


@dataclass(frozen=True, eq=False)
class Samples:
    """Segments of one length.

    Parameters
    ----------
    contexts : Contexts
    sines : array-like, shape=[n, N, B, 3]
        Residuals of the plain spline: weights of sines, radians.
    middles : array-like, shape=[n, B, 4]
        Rotations of the plain spline in the middle of each.
    clip : array-like of int, shape=[n]
        Clip that each is from.
    """

    contexts: Contexts
    sines: Array
    middles: Array
    clip: np.ndarray

    def at(self, segments: np.ndarray) -> Samples:
        """Take some segments."""
        return Samples(self.contexts.at(segments), self.sines[segments], self.middles[segments], self.clip[segments])

    @classmethod
    def joined(cls, samples: list[Samples]) -> Samples:
        """Join samples one after the other."""
        columns = zip(*((each.sines, each.middles, each.clip) for each in samples), strict=True)
        return cls(Contexts.joined([each.contexts for each in samples]), *map(np.concatenate, columns))


def frames_of(gap: int, clip: Animation) -> int:
    """Return how many frames of a clip a gap has, at least 2."""
    rate = (clip.n_frames - 1) / (clip.times[-1] - clip.times[0])
    return max(2, round(gap / GAP_RATE * rate))


def samples_of(
    clips: Sequence[Animation], gap: int, trunk: np.ndarray, vertical: Array, most: int = MOST_SAMPLES
) -> Samples | None:
    """Cut clips into segments between uniform keys, which start at several frames.

    Parameters
    ----------
    clips : sequence of Animation
    gap : int
        In frames of 30 per second.
    trunk, vertical
        See `contexts_of`.
    most : int
        About the most segments that are cut.

    Returns
    -------
    samples : Samples or None
        None if no clip has two segments.
    """
    lengths = [frames_of(gap, clip) for clip in clips]
    n_segments = sum(clip.n_frames / length for clip, length in zip(clips, lengths, strict=True))
    found = []
    for i, (clip, length) in enumerate(zip(clips, lengths, strict=True)):
        n_phases = min(length, max(1, int(np.ceil(most / n_segments))))
        for phase in np.unique(np.round(np.linspace(0, length, n_phases, endpoint=False)).astype(int)):
            keys = np.arange(phase, clip.n_frames, length)
            if len(keys) > 2:
                found.append(_segments(i, clip, keys, gap, trunk, vertical))
    return Samples.joined(found) if found else None


def _segments(number: int, clip: Animation, keys: np.ndarray, gap: int, trunk: np.ndarray, vertical: Array) -> Samples:
    """Return the segments between keys of a clip, given by its number."""
    length, n_segments = int(keys[1] - keys[0]), len(keys) - 1
    inner = np.unique(np.round(np.linspace(1, length - 1, min(length - 1, _MOST_INNER))).astype(int))
    frames = (keys[:-1, None] + inner).ravel()
    curve = CurveParameters.plain("geodesic-spline", clip.n_joints)
    spline = PoseSpline(clip.times[keys], clip.rotations[keys], curve.metric, curve.tension)
    segment = np.repeat(np.arange(n_segments), len(inner))
    start, end = clip.times[keys[:-1]], clip.times[keys[1:]]
    fraction = (clip.times[frames] - start[segment]) / (end - start)[segment]
    missed = quat.difference(spline(segment, fraction), clip.rotations[frames])
    missed = missed.reshape(n_segments, len(inner), -1)
    count = n_sines(gap)
    to_sines = np.linalg.pinv(basis(inner / length, count)[:, :count], rcond=1e-9)
    return Samples(
        contexts_of(clip.times[keys], clip.rotations[keys], trunk, vertical),
        (to_sines @ missed).reshape(n_segments, count, clip.n_joints, 3),
        spline(np.arange(n_segments), np.full(n_segments, 0.5)),
        np.full(n_segments, number),
    )
