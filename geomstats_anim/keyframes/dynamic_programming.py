"""Errors of slerp between every pair of frames that could be neighbouring keys, and the best paths over them.

Slerp is the bi-invariant geodesic, and the only scheme whose error between two keys depends on nothing but them: with
it, choosing keys is a shortest path.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.kernels import segment_errors as kernel
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.kinematics import breadth_first, world_pose
from geomstats_anim.markers import Markers, joint_matrices
from geomstats_anim.rotations import Array


class UnreachableError(ValueError):
    """No choice of keys leads from the first frame to the last."""


class Measure(NamedTuple):
    """The definition of error.

    Attributes
    ----------
    location, rotation : array-like, shape=[B]
        Weight of each joint's squared distance of bone ends, square metres, and of its angle, radians.
    markers : Markers or None
        Those whose largest distance in the world counts instead, over frames, metres; None for the weighted sum.
    """

    location: Array
    rotation: Array
    markers: Markers | None = None

    @property
    def largest(self) -> bool:
        """Return whether the largest distance counts, and not a sum."""
        return self.markers is not None


def segment_errors(animation: Animation, candidates: np.ndarray, window: int, measure: Measure) -> Array:
    """Measure the error of every segment between candidates that are not further apart than a window.

    Parameters
    ----------
    animation : Animation
        The truth.
    candidates : array-like of int, shape=[N]
        Frames that may be keys, increasing.
    window : int
        Candidates that a segment may reach ahead, W.
    measure : Measure

    Returns
    -------
    errors : array-like, shape=[N, W]
        Of the segment from candidate n to candidate n + 1 + w: the sum over its inner frames, or the largest;
        infinite beyond the last candidate.
    """
    errors = np.full((len(candidates), window), np.inf)
    truth = truth_of(animation, measure)

    def run(part: slice) -> None:
        kernel.fill(part.start, part.stop, candidates, truth, errors)

    in_threads(run, errors.size)
    return errors


def fewest(
    animation: Animation, candidates: np.ndarray, forced: np.ndarray, tolerance: float, measure: Measure
) -> np.ndarray:
    """Find the fewest candidates between which slerping stays within a tolerance.

    Parameters
    ----------
    animation : Animation
        The truth.
    candidates : array-like of int, shape=[N]
        Frames that may be keys, increasing.
    forced : array-like of bool, shape=[N]
        Those that must be, the first and the last among them.
    tolerance : float
        Largest distance of markers, metres.
    measure : Measure
        With markers.

    Returns
    -------
    chosen : array-like of int, shape=[K]
        Indices of candidates.

    Raises
    ------
    UnreachableError
        If even neighbouring candidates are not within the tolerance.
    """
    before = np.full(len(candidates), -1, dtype=np.intp)
    kernel.reach(candidates, forced, truth_of(animation, measure), tolerance, before)
    chosen = [len(candidates) - 1]
    while chosen[-1]:
        if before[chosen[-1]] < 0:
            raise UnreachableError(f"No keys among {len(candidates)} frames stay within {tolerance:g} m.")
        chosen.append(int(before[chosen[-1]]))
    return np.array(chosen[::-1], dtype=np.intp)


def cheapest(errors: Array, forced: np.ndarray, count: int, largest: bool) -> np.ndarray:
    """Choose candidates so that the segments between them cost least, by dynamic programming.

    Parameters
    ----------
    errors : array-like, shape=[N, W]
        See `segment_errors`.
    forced : array-like of bool, shape=[N]
        Candidates that must be chosen, the first and the last among them.
    count : int
        How many to choose, K.
    largest : bool
        Whether the largest error of a segment counts, not the sum.

    Returns
    -------
    chosen : array-like of int, shape=[K]
        Indices of candidates.

    Raises
    ------
    UnreachableError
        If the window is too narrow for so few.
    """
    steps = np.zeros((count, len(errors)), dtype=np.uint16)
    total = kernel.cheapest(errors, forced, largest, steps)
    if not np.isfinite(total):
        raise UnreachableError(f"No {count} of {len(errors)} frames are joined by segments that were measured.")
    chosen = [len(errors) - 1]
    for row in steps[:0:-1]:
        chosen.append(chosen[-1] - int(row[chosen[-1]]))
    return np.array(chosen[::-1], dtype=np.intp)


class Truth(NamedTuple):
    """Arrays of an animation and a measure, for the compiled code."""

    order: np.ndarray
    parents: np.ndarray
    bone_ends: Array
    times: Array
    rotations: Array
    translations: Array
    ends: Array
    location: Array
    rotation: Array
    largest: bool
    world: Array
    scales: Array
    joints: np.ndarray
    offsets: Array
    weights: Array
    places: Array


def truth_of(animation: Animation, measure: Measure) -> Truth:
    """Copy what the compiled code needs into plain arrays."""
    skeleton, markers = animation.skeleton, measure.markers or Markers.none()
    shape = (animation.n_frames, animation.n_joints)
    # copies, as compiled code has one variant for arrays that may be written to and another for those that may not
    return Truth(
        breadth_first(skeleton),
        np.array(skeleton.parents),
        np.array(skeleton.bone_ends),
        np.array(animation.times),
        np.array(animation.rotations),
        np.array(animation.translations),
        world_pose(animation).ends,
        np.array(measure.location),
        np.array(measure.rotation),
        measure.largest,
        np.array(np.broadcast_to(np.eye(3, 4), (shape[0], 3, 4)) if animation.world is None else animation.world),
        np.ones((*shape, 3)) if animation.scales is None else np.array(animation.scales),
        markers.joints,
        markers.offsets,
        markers.weights,
        markers.places(joint_matrices(animation)),
    )
