"""Find which points of a body are planted on the ground, and when: those that are low and still, by no names.

A point is planted where it is near the lowest height at which it rests, and slow. It lands below both thresholds, and
lifts above half as much again, so that noise does not part a step in two; or where it has drifted off. Motion that is
dense and keys that are sparse are judged alike, from one sample to the next: between sparse keys a planted point has
hardly moved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.markers import joint_matrices
from geomstats_anim.rotations import Array

BODY = 2.0
"""Metres: the size of a body for which the default lengths are, see `body_size`."""

_HYSTERESIS = 1.5
"""Thresholds of a point that lifts, over those of one that lands."""

_LOW = 0.05
"""Quantile of the heights at which a point is slow that is taken for its lowest, so that single faults are not."""


@dataclass(frozen=True)
class ContactParameters:
    """Hold when a point counts as planted.

    Parameters
    ----------
    height : float
        Centimetres above its resting height within which a point lands.
    speed : float
        Centimetres per second below which it lands.
    drift : float
        Centimetres by which it may be elsewhere at the next sample, however long after; and half as much again from
        where it rests on average.
    shortest : float
        Seconds that it stays planted at least.
    window : float
        Seconds over which speed is measured, or the gap between samples where that is longer.
    reach : float
        Centimetres above the ground at which a point may rest, such as an ankle.

    Raises
    ------
    ValueError
        If one is not a positive number.
    """

    height: float = 4.0
    speed: float = 20.0
    drift: float = 2.0
    shortest: float = 0.06
    window: float = 0.05
    reach: float = 17.0

    def __post_init__(self) -> None:
        """Check that all are positive."""
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} is {value}, but it must be a positive number.")

    @classmethod
    def for_size(cls, size: float) -> ContactParameters:
        """Scale the default lengths to a body of a size in metres, see `body_size`."""
        usual, share = cls(), size / BODY
        lengths = {name: getattr(usual, name) * share for name in ("height", "speed", "drift", "reach")}
        return cls(**lengths)


@dataclass(frozen=True, eq=False)
class Contacts:
    """Planted points, and the times of their stances.

    Parameters
    ----------
    up : array-like, shape=[3]
        Unit vector upwards.
    times : array-like, shape=[F]
        Seconds, of the samples.
    joints : array-like of int, shape=[P]
        The joints that are planted at some time; where they start is the point.
    planted : array-like of bool, shape=[F - 1, P]
        Whether each point is, from each sample to the next.
    ground : float
        Height of the lowest point at rest, metres; NaN if there is none.
    """

    up: Array
    times: Array
    joints: np.ndarray
    planted: np.ndarray
    ground: float

    @property
    def seconds(self) -> float:
        """Seconds for which points are planted, of all points together."""
        return float(np.diff(self.times) @ self.planted.sum(axis=1))

    @property
    def share(self) -> float:
        """Share of the time in which some point is planted."""
        durations = np.diff(self.times)
        return float(durations @ self.planted.any(axis=1) / durations.sum()) if len(durations) else 0.0


def body_size(places: Array) -> float:
    """Return how large a body is, metres: twice the largest distance of a joint from the mean of all that move.

    Parameters
    ----------
    places : array-like, shape=[F, B, 3]
    """
    moving = places[:, (np.ptp(places, axis=0) > 0.0).any(axis=-1)]
    if not moving.size:
        return 0.0
    return 2.0 * float(np.linalg.norm(moving - moving.mean(axis=1, keepdims=True), axis=-1).max())


def find_contacts(
    animation: Animation,
    up: Array,
    parameters: ContactParameters | None = None,
    ground: float | None = None,
) -> Contacts:
    """Find which joints are planted on the ground, and when.

    Parameters
    ----------
    animation : Animation
        Dense motion, or keys; placed in the world.
    up : array-like, shape=[3]
        Unit vector upwards in the world.
    parameters : ContactParameters
        Optional, default: scaled to the size of the body.
    ground : float
        Height of the ground, metres.
        Optional, default: the lowest height at which a point rests.

    Returns
    -------
    contacts : Contacts

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import Animation, Skeleton
    >>> skeleton = Skeleton(["hip", "foot"], [-1, 0], [[0, 1, 0], [0, -1, 0]], np.tile([0, 0, 0, 1], (2, 1)))
    >>> times, turns = np.arange(4) / 10, np.tile([0.0, 0.0, 0.0, 1.0], (4, 2, 1))
    >>> turns[2:, 0] = [0.6, 0.0, 0.0, 0.8]
    >>> walk = Animation(skeleton, times, turns, np.tile(skeleton.rest_translations, (4, 1, 1)))
    >>> find_contacts(walk, np.array([0.0, 1.0, 0.0])).planted.T
    array([[ True, False, False]])
    """
    candidates = _turned(animation)
    none = Contacts(up, animation.times, candidates[:0], np.zeros((max(animation.n_frames - 1, 0), 0), bool), np.nan)
    if animation.n_frames < 2 or not len(candidates):
        return none
    places = joint_matrices(animation)[..., 3]
    if parameters is None:
        parameters = ContactParameters.for_size(body_size(places) or BODY)
    places = places[:, candidates]
    speeds, limits = _speeds(animation.times, places, parameters)
    heights = _higher(places @ up)
    levels = _resting_heights(heights, speeds <= limits)
    if np.isnan(levels).all():
        return none
    ground = float(np.nanmin(levels)) if ground is None else ground
    rises = heights - np.where(np.abs(levels - ground) <= 0.01 * parameters.reach, levels, np.nan)
    allowed = 0.01 * parameters.height
    lands = (speeds <= limits) & (rises <= allowed)
    stays = (speeds <= _HYSTERESIS * limits) & (rises <= _HYSTERESIS * allowed)
    stays = _runs_with(stays, lands)
    stays &= _near_rest(places, stays, lands) <= _HYSTERESIS * 0.01 * parameters.drift
    planted = _long_enough(_runs_with(stays, lands), np.diff(animation.times), parameters.shortest)
    some = planted.any(axis=0)
    return Contacts(up, animation.times, candidates[some], planted[:, some], ground)


def _turned(animation: Animation) -> np.ndarray:
    """Return the joints that turns of others move: all but roots, and what hangs on joints that never turn."""
    turns = np.any(quat.distance(animation.rotations, animation.rotations[:1]) >= STILL, axis=0)
    moved = np.zeros(animation.n_joints, dtype=bool)
    for joint, parent in enumerate(animation.skeleton.parents.tolist()):
        moved[joint] = parent >= 0 and (moved[parent] or turns[parent])
    return np.flatnonzero(moved)


def _higher(heights: Array) -> Array:
    """Return the greater of the heights at both ends of each gap between samples."""
    return np.maximum(heights[1:], heights[:-1])


def _speeds(times: Array, places: Array, parameters: ContactParameters) -> tuple[Array, Array]:
    """Return the speeds of points from each sample to the next, and those below which they land, shape=[F - 1, P]."""
    middles, gaps = 0.5 * (times[1:] + times[:-1]), np.maximum(np.diff(times), parameters.window)
    before = np.maximum(middles - 0.5 * gaps, times[0])
    after = np.minimum(middles + 0.5 * gaps, times[-1])
    ways = np.linalg.norm(_at(times, places, after) - _at(times, places, before), axis=-1)
    durations = (after - before)[:, None]
    return ways / durations, 0.01 * np.minimum(parameters.speed, parameters.drift / durations)


def _at(times: Array, values: Array, wanted: Array) -> Array:
    """Interpolate values, shape=[F, P, 3], linearly."""
    index = np.clip(np.searchsorted(times, wanted, side="right") - 1, 0, len(times) - 2)
    weight = ((wanted - times[index]) / np.diff(times)[index])[:, None, None]
    return (1.0 - weight) * values[index] + weight * values[index + 1]


def _resting_heights(heights: Array, slow: np.ndarray) -> Array:
    """Return the lowest heights at which points are slow, shape=[P]; NaN where they never are."""
    # as np.nanquantile, which goes through the points one by one
    ordered = np.sort(np.where(slow, heights, np.nan), axis=0)
    place = _LOW * np.maximum(slow.sum(axis=0) - 1, 0)
    below, points = place.astype(np.intp), np.arange(heights.shape[1])
    low, high = ordered[below, points], ordered[np.ceil(place).astype(np.intp), points]
    return low + (place - below) * (high - low)


def _runs_with(runs: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """Keep the runs along the first axis, shape=[N, P], in which there is a mark."""
    labels = _labels(runs)
    marked = np.bincount(labels[marks & runs], minlength=labels.max(initial=0) + 1) > 0
    return runs & marked[labels]


def _near_rest(places: Array, runs: np.ndarray, marks: np.ndarray) -> Array:
    """Return how far points are, from each sample to the next, from their mean place where a run has marks."""
    labels, marked = _labels(runs), marks & runs
    counts = np.maximum(np.bincount(labels[marked], minlength=labels.max(initial=0) + 1), 1)
    middles = 0.5 * (places[1:] + places[:-1])
    sums = [np.bincount(labels[marked], middles[marked][:, k], minlength=len(counts)) for k in range(3)]
    rest = (np.stack(sums, axis=-1) / counts[:, None])[labels]
    return np.maximum(*(np.linalg.norm(ends - rest, axis=-1) for ends in (places[1:], places[:-1])))


def _long_enough(runs: np.ndarray, durations: Array, shortest: float) -> np.ndarray:
    """Keep the runs along the first axis, shape=[N, P], that last."""
    labels = _labels(runs)
    weights = np.broadcast_to(durations[:, None], runs.shape)
    lasting = np.bincount(labels[runs], weights[runs], minlength=labels.max(initial=0) + 1) >= shortest
    return runs & lasting[labels]


def _labels(runs: np.ndarray) -> np.ndarray:
    """Return the numbers of runs along the first axis, from 1 on; what is in none has the number of another."""
    starts = runs.copy()
    starts[1:] &= ~runs[:-1]
    return np.cumsum(starts.T).reshape(starts.T.shape).T
