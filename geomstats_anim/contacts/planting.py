"""Keep planted points where they are between keys.

A curve through keys leads a point along p(t). Where the point is planted, it should be at its place P instead: it has
to move by P - p(t). Before and after, that goes to zero, and so does the weight of the point, by cubics that join with
continuous velocity: at the next key, or after `EASE` seconds, whichever is first. So nothing has to move at a key; and
if the curve has a continuous velocity, the motion still has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geomstats_anim.animation import Animation
from geomstats_anim.contacts.detection import Contacts
from geomstats_anim.contacts.reaching import Body, smooth
from geomstats_anim.markers import joint_matrices, joint_places
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

EASE = 0.3
"""Seconds, at most, in which a correction comes and goes."""

_PROBE = 2e-3
"""Seconds, at most, between the samples by which the velocity of a point is measured."""

_TINY = 1e-3
"""Share of that time by which a sample may be late."""

_SAME = 1e-5
"""Seconds by which times that are the same may differ."""


@dataclass(frozen=True, eq=False)
class Plants:
    """Points that stay in place, each for some time.

    Parameters
    ----------
    joints : array-like of int, shape=[N]
        Where these joints start is the point.
    starts, ends : array-like, shape=[N]
        Seconds.
    start_places, end_places : array-like, shape=[N, 3]
        In the world, metres; in between, a point goes from one to the other, at rest at both ends.
    """

    joints: np.ndarray
    starts: Array
    ends: Array
    start_places: Array
    end_places: Array

    @classmethod
    def of(cls, contacts: Contacts, animation: Animation) -> Plants:
        """Take one for each time that a point is planted, at its mean place there.

        Parameters
        ----------
        contacts : Contacts
        animation : Animation
            That they were found in.
        """
        padded = np.pad(contacts.planted.astype(np.int8), ((1, 1), (0, 0)))
        changes = np.diff(padded, axis=0).T
        (point, first), (_, last) = np.nonzero(changes == 1), np.nonzero(changes == -1)
        sums = np.cumsum(
            np.pad(joint_matrices(animation)[..., 3][:, contacts.joints], ((1, 0), (0, 0), (0, 0))), axis=0
        )
        places = (sums[last + 1, point] - sums[first, point]) / (last + 1 - first)[:, None]
        return cls(contacts.joints[point], contacts.times[first], contacts.times[last], places, places)

    @property
    def number(self) -> int:
        """Number of plants, N."""
        return len(self.joints)

    def chosen(self, plants: np.ndarray) -> Plants:
        """Keep some, by index or mask."""
        return Plants(*(value[plants] for value in vars(self).values()))

    def through_keys(self, keys: Animation) -> Plants:
        """Cut them at keys, and take the places of the keys; before the first and after the last, nothing moves.

        One in which no key is keeps its place.

        Parameters
        ----------
        keys : Animation
            Placed in the world.
        """
        times, places = keys.times, joint_matrices(keys)[..., 3]
        first = np.searchsorted(times, self.starts - _SAME)
        counts = np.searchsorted(times, self.ends + _SAME) - first
        starts, ends = np.maximum(self.starts, times[0]), np.minimum(self.ends, times[-1])
        plant = np.repeat(np.arange(self.number), counts + 1)  # as many parts as keys, and one
        part = np.arange(len(plant)) - np.repeat(np.cumsum(counts + 1) - counts - 1, counts + 1)
        is_first, is_last = part == 0, part == counts[plant]
        before, after = (np.clip(first[plant] + part + k, 0, len(times) - 1) for k in (-1, 0))
        joints, alone = self.joints[plant], (counts[plant] == 0)[:, None]
        start_places = np.where(alone, self.start_places[plant], places[np.where(is_first, after, before), joints])
        end_places = np.where(alone, self.end_places[plant], places[np.where(is_last, before, after), joints])
        starts, ends = np.where(is_first, starts[plant], times[before]), np.where(is_last, ends[plant], times[after])
        parts = Plants(joints, starts, ends, start_places, end_places)
        return parts.chosen(parts.ends - parts.starts > _SAME)

    @property
    def _steps(self) -> Array:
        """Seconds between the probes of each."""
        return np.minimum(_PROBE, 0.25 * (self.ends - self.starts))

    def probes(self) -> Array:
        """Return the times at which a curve must be known beside those that are wanted, seconds, increasing."""
        steps = self._steps[:, None] * np.arange(3)
        return np.unique([self.starts[:, None] + steps, self.ends[:, None] - steps])

    def at_rest(self, times: Array, places: Array, points: np.ndarray, is_end: bool) -> tuple[Array, Array]:
        """Return where a curve leads the points where they begin or end to rest, and how fast, by samples inside.

        Parameters
        ----------
        times : array-like, shape=[F]
        places : array-like, shape=[F, P, 3]
        points : array-like of int, shape=[N]
        is_end : bool

        Returns
        -------
        places, velocities : array-like, shape=[N, 3]
        """
        steps = -self._steps if is_end else self._steps
        edges = self.ends if is_end else self.starts
        one, two, three = (
            places[np.searchsorted(times, edges + k * steps - _TINY * self._steps), points] for k in range(3)
        )
        return one, (4.0 * two - 3.0 * one - three) / (2.0 * steps[:, None])


@dataclass(frozen=True, eq=False)
class Planted:
    """A motion whose points stay planted.

    Parameters
    ----------
    animation : Animation
    plants : Plants
        Those that are kept.
    left : Plants
        Those that are not: the curve leads their points further away than they may be moved, so they are taken to lift.
    """

    animation: Animation
    plants: Plants
    left: Plants


def plant(
    dense: Animation,
    keys: Animation,
    plants: Plants,
    parameters: MetricParameters,
    reach: float = np.inf,
    moves_root: bool = True,
    wanted: np.ndarray | None = None,
) -> Planted:
    """Keep points in place.

    Parameters
    ----------
    dense : Animation
        A curve through the keys, placed in the world, at the times that are wanted and `plants.probes()`.
    keys : Animation
        What is the same in two keys one after the other stays so; at the keys nothing is changed.
    plants : Plants
        Cut at the keys.
    parameters : MetricParameters
        Of all joints.
    reach : float
        Metres by which a point may be moved.
        Optional, default: any.
    moves_root : bool
        Whether the joint that moves with the whole body may be moved, where turns do not suffice.
        Optional, default: True.
    wanted : array-like of bool, shape=[F]
        Which frames are corrected and returned, so that no work goes into those that only say how fast points are.
        Optional, default: all.

    Returns
    -------
    planted : Planted
        Frames without correction are the same, bit for bit.
    """
    left = np.zeros(plants.number, dtype=bool)
    points, column = np.unique(plants.joints, return_inverse=True)
    places = joint_places(dense, points)
    while not left.all():
        pulls = _Pulls.of(dense.times, places, keys.times, plants.chosen(~left), column[~left])
        far = pulls.furthest > reach
        if not far.any():
            break
        left[np.flatnonzero(~left)[far]] = True
    chosen = np.arange(dense.n_frames) if wanted is None else np.flatnonzero(wanted)
    if left.all():
        return Planted(dense if wanted is None else dense.at_frames(chosen), plants.chosen(~left), plants)
    kept = np.flatnonzero(np.bincount(column[~left]))
    body = Body.of(dense, keys, points[kept], parameters, moves_root)
    moved = np.flatnonzero(pulls.ways[chosen].any(axis=(1, 2)))
    some = np.ix_(chosen[moved], kept)
    rotations, translations = dense.rotations[chosen], dense.translations[chosen]
    goals = places[some] + pulls.ways[some]
    rotations[moved], translations[moved] = body.reached(chosen[moved], goals, pulls.weights[some])
    scales, world = (None if each is None else each[chosen] for each in (dense.scales, dense.world))
    animation = Animation(dense.skeleton, dense.times[chosen], rotations, translations, scales, world)
    return Planted(animation, plants.chosen(~left), plants.chosen(left))


@dataclass(frozen=True, eq=False)
class _Pulls:
    """Ways that points have to move, and their weights.

    Parameters
    ----------
    ways : array-like, shape=[F, P, 3]
        Metres.
    weights : array-like, shape=[F, P]
        In [0, 1].
    furthest : array-like, shape=[N]
        The longest way for each plant.
    """

    ways: Array
    weights: Array
    furthest: Array

    @classmethod
    def of(cls, times: Array, places: Array, key_times: Array, plants: Plants, column: np.ndarray) -> _Pulls:
        """Find them from where a curve leads points, shape=[F, P, 3], and which of these each plant is of."""
        before, after = _eases(key_times, plants)
        first = np.searchsorted(times, plants.starts - before)
        counts = np.searchsorted(times, plants.ends + after, side="right") - first
        plant = np.repeat(np.arange(plants.number), counts)
        frame = np.arange(len(plant)) + np.repeat(first - np.cumsum(counts) + counts, counts)
        now, starts, ends = times[frame], plants.starts[plant], plants.ends[plant]
        travelled = smooth(np.clip((now - starts) / (ends - starts), 0.0, 1.0))[:, None]
        goals = plants.start_places[plant] + travelled * (plants.end_places - plants.start_places)[plant]
        ways, weights = goals - places[frame, column[plant]], np.ones(len(plant))
        for is_end, eased, lengths in ((False, now < starts, before), (True, now > ends, after)):
            own = plant[eased]
            here, velocity = plants.at_rest(times, places, column, is_end)
            missing = (plants.end_places if is_end else plants.start_places) - here
            gone = now[eased] - ends[eased] if is_end else starts[eased] - now[eased]
            share = np.clip(1.0 - gone / lengths[own], 0.0, 1.0)
            weights[eased] = smooth(share)
            slope = (-1.0 if is_end else 1.0) * lengths[own] * share**2 * (1.0 - share)
            ways[eased] = weights[eased, None] * missing[own] + slope[:, None] * velocity[own]
        furthest = np.zeros(plants.number)
        np.maximum.at(furthest, plant, np.linalg.norm(ways, axis=-1))
        order = np.argsort(weights, kind="stable")  # where two meet, the one that holds wins
        shape = places.shape[:2]
        all_ways, all_weights = np.zeros((*shape, 3)), np.zeros(shape)
        all_ways[frame[order], column[plant[order]]] = ways[order]
        all_weights[frame[order], column[plant[order]]] = weights[order]
        all_ways[np.isin(times, key_times)] = 0.0
        return cls(all_ways, all_weights, furthest)


def _eases(key_times: Array, plants: Plants) -> tuple[Array, Array]:
    """Return the seconds in which each plant comes and goes: to the next key, and half of the way to the next plant."""
    padded = np.concatenate([[-np.inf], key_times, [np.inf]])
    before = plants.starts - padded[np.searchsorted(key_times, plants.starts - _SAME)]
    after = padded[1 + np.searchsorted(key_times, plants.ends + _SAME, side="right")] - plants.ends
    order = np.lexsort((plants.starts, plants.joints))
    same = plants.joints[order[1:]] == plants.joints[order[:-1]]
    room = np.maximum(plants.starts[order[1:]] - plants.ends[order[:-1]], 0.0)
    room = np.where(same, np.where(room < _SAME, 0.0, 0.5 * room), np.inf)
    before[order[1:]] = np.minimum(before[order[1:]], room)
    after[order[:-1]] = np.minimum(after[order[:-1]], room)
    before, after = (np.where(np.isinf(ease), 0.0, np.minimum(ease, EASE)) for ease in (before, after))
    return before, after
