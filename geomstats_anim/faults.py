"""Faults of recorded motion: values that are missing, that spike, or that are held while the motion goes on.

The rules compare samples with what is around them, never with what a body can do, so that fast motion is left alone.
Their numbers were chosen on 195 recordings and hand-keyed clips.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geomstats_anim.names import DROPOUT, GAP, SPIKE
from geomstats_anim.rotations import Array
from geomstats_anim.spaces import Space

LONGEST_SPIKE = 3
"""Samples of a spike."""

LONGEST_FLIP = 0.5
"""Seconds of a spike whose steps out and back are half turns, see `HALF_TURN`."""

HALF_TURN = np.radians(150.0)
"""A joint that turns this far from one sample to the next, and later back, has flipped."""

LEAST_SPIKE = np.radians(20.0)
"""Radians that the steps out and back have at least, and that all of a spike departs from the motion across it."""

OUTSTANDING = 1.5
"""The steps out and back are wider than the median times this."""

PROMINENCE = np.radians(150.0)
"""Least departure times departure over unevenness: 30 degrees among samples that are even within 6 degrees, 60 degrees
within 24, half a turn within 216."""

AROUND = 3
"""Samples on either side that say how uneven the motion is."""

SHARE_OF_SPEED = 0.25
"""Share of the largest step around that counts as unevenness."""

SHARE_OF_CHAIN = 0.5
"""Share of the steps of parent and children meanwhile that counts as well, unless they spike together: a fist that
strikes moves with its arm."""

ACROSS = 1.3
"""A joint's move across a spike is at most this times the steps out and back."""

FLIP = np.radians(45.0)
"""Samples that depart this far are not taken for unevenness around another spike, unless a third of the samples do."""

LEAST_REPEATS = 2
"""Times that a drop-out repeats the sample before it, at least."""

LEAST_CATCH_UP = np.radians(1.0)
"""Radians by which motion that goes on misses where it was held."""

FARTHEST = 3.0
"""The step that ends it leads at most this times as far as the fastest around would have in that time, unlike pops."""


@dataclass(frozen=True)
class Fault:
    """Samples of one joint that are not to be believed.

    Parameters
    ----------
    kind : str
        `GAP`, `SPIKE` or `DROPOUT`.
    joint : int
    start, stop : int
        First sample, and the first good one after it.
    size : float
        Radians, or lengths in the unit of the space: what a spike departs, or what the step that ends a drop-out makes
        up for; nan for a gap.
    """

    kind: str
    joint: int
    start: int
    stop: int
    size: float


def find_faults(
    values: Array,
    times: Array,
    space: Space,
    missing: np.ndarray | None = None,
    steps: Array | None = None,
    parents: np.ndarray | None = None,
) -> list[Fault]:
    """Find the faults of joints.

    A *gap* is what is missing. A *spike* is one to three samples, or half a second that is half a turn off, that leaves
    the motion and comes back: the steps out and back, and the departure from the motion across, are 20 degrees at
    least, and the departure is large beside the unevenness around it, see `PROMINENCE`. A *drop-out* repeats a sample,
    bit for bit, twice or more while the motion goes on: the joint moves before and after, and where it was held misses
    where motion as fast as it is then would have begun by more than the mean of the steps before and after. Joints that
    are held from the same sample to the same sample are judged together. A drop-out too is another value that is held
    among moving ones, as far off as a spike. What is held and then goes on from there is no fault, however long.

    Parameters
    ----------
    values : array-like, shape=[F, N, C]
        Dense samples without cuts among them; what is missing is filled in, see `fill`.
    times : array-like, shape=[F]
        Seconds, increasing.
    space : Space
    missing : array-like of bool, shape=[F, N]
        Optional, default: nothing is missing.
    steps : array-like, shape=[F - 1, N]
        Distances from each sample to the next, exactly 0 where both are the same.
        Optional, default: `steps_between`.
    parents : array-like of int, shape=[N]
        Of each joint, -1 for none.
        Optional, default: the joints are not connected.

    Returns
    -------
    faults : list of Fault
        By first sample, then by joint; none touches another of its joint.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim.faults import find_faults
    >>> from geomstats_anim.spaces import Points
    >>> values = np.linspace(0.0, 1.0, 21)[:, None, None] * [[1.0, 0.0, 0.0]]
    >>> values[8:10] += [[0.0, 2.0, 0.0]]
    >>> find_faults(values, np.arange(21.0), Points(1.0))
    [Fault(kind='spike', joint=0, start=8, stop=10, size=2.0)]
    """
    steps = steps_between(values, space) if steps is None else steps
    faults: list[Fault] = []
    shape = len(values), values.shape[1]
    if missing is not None:
        runs = zip(*(each.tolist() for each in _runs(missing)), strict=True)
        faults += [Fault(GAP, joint, start, stop, np.nan) for joint, start, stop in runs]
    spikes = _apart(_find_spikes(values, times, space, steps, parents), mask_of(faults, *shape))
    if spikes:
        joints = np.unique([spike.joint for spike in spikes])
        values, steps = np.array(values), np.array(steps)
        values[:, joints] = fill(values[:, joints], times, space, mask_of(spikes, *shape)[:, joints])
        steps[:, joints] = steps_between(values[:, joints], space)
    faults += spikes
    faults += _apart(_find_dropouts(values, space, steps), mask_of(faults, *shape))
    return sorted(faults, key=lambda fault: (fault.start, fault.joint))


def steps_between(values: Array, space: Space) -> Array:
    """Return the distances from each sample to the next, shape=[F - 1, N], exactly 0 where both are the same."""
    return np.where(space.same(values[1:], values[:-1]), 0.0, space.distance(values[1:], values[:-1]))


def mask_of(faults: Iterable[Fault], n_frames: int, n_joints: int) -> np.ndarray:
    """Return which samples are of faults, shape=[F, N]."""
    mask = np.zeros((n_frames, n_joints), dtype=bool)
    for fault in faults:
        mask[fault.start : fault.stop, fault.joint] = True
    return mask


def fill(values: Array, times: Array, space: Space, mask: np.ndarray) -> Array:
    """Fill in samples on the shortest way between those beside them; at an end the nearest is held.

    Parameters
    ----------
    values : array-like, shape=[F, N, C]
    times : array-like, shape=[F]
    space : Space
    mask : array-like of bool, shape=[F, N]
        What to fill in; of no joint all.

    Returns
    -------
    filled : array-like, shape=[F, N, C]
        Of the type of `values`.
    """
    filled, frames = np.array(values), np.arange(len(values))
    for joint in np.flatnonzero(mask.any(axis=0)):
        bad, good = np.flatnonzero(mask[:, joint]), frames[~mask[:, joint]]
        after = np.searchsorted(good, bad)
        left, right = good[np.maximum(after - 1, 0)], good[np.minimum(after, len(good) - 1)]
        share = (times[bad] - times[left]) / np.where(right > left, times[right] - times[left], 1.0)
        filled[bad, joint] = space.between(values[left, joint], values[right, joint], np.where(right > left, share, 0))
    return filled


def _apart(found: list[Fault], others: np.ndarray) -> list[Fault]:
    """Leave out what overlaps or touches other samples, shape=[F, N]: nothing is known of the motion there."""
    return [fault for fault in found if not others[max(fault.start - 1, 0) : fault.stop + 1, fault.joint].any()]


def _runs(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the joint, start and stop of the runs of a mask, shape=[F, N], by joint."""
    edges = np.diff(np.pad(mask, ((1, 1), (0, 0))).astype(np.int8), axis=0).T
    joint, start = np.nonzero(edges == 1)
    return joint, start, np.nonzero(edges == -1)[1]


class _Excursions(NamedTuple):
    """Samples that may be spikes: the samples before and after them, and their joints, shape=[S] each."""

    before: np.ndarray
    after: np.ndarray
    joint: np.ndarray

    def at(self, kept: np.ndarray) -> _Excursions:
        """Return some of them."""
        return _Excursions(self.before[kept], self.after[kept], self.joint[kept])


def _find_spikes(values: Array, times: Array, space: Space, steps: Array, parents: np.ndarray | None) -> list[Fault]:
    found = _excursions(steps, times)
    departure = _departures(found, values, times, space, steps)
    found, departure = found.at(departure > 0.0), departure[departure > 0.0]
    if not len(departure):
        return []
    chain = SHARE_OF_CHAIN * _chain_speed(found, steps, parents)
    weight = departure * np.minimum(departure, space.farthest)
    prominence = weight / (_unevenness(found, values, times, space, steps) + chain)
    chosen: list[int] = []
    taken = np.zeros((len(values), values.shape[1]), dtype=bool)
    for k in np.argsort(-prominence, kind="stable").tolist():
        first, last, joint = int(found.before[k]), int(found.after[k]), int(found.joint[k])
        if not taken[first : last + 1, joint].any():
            taken[first + 1 : last, joint] = True
            chosen.append(k)
    found, departure, chain = found.at(np.array(chosen)), departure[chosen], chain[chosen]
    lonely = _without_flips(found, departure, values, times, space)
    is_spike = np.maximum(prominence[chosen], weight[chosen] / (lonely + chain)) >= PROMINENCE
    found, sizes = found.at(is_spike), departure[is_spike]
    is_held = (found.after - found.before - 1 > LONGEST_SPIKE) & (steps[found.before + 1, found.joint] == 0.0)
    kinds = np.where(is_held, DROPOUT, SPIKE).tolist()
    ends = zip(found.joint.tolist(), (found.before + 1).tolist(), found.after.tolist(), strict=True)
    return [Fault(kind, *end, size) for kind, end, size in zip(kinds, ends, sizes.tolist(), strict=True)]


def _excursions(steps: Array, times: Array) -> _Excursions:
    """List what lies between two wide steps: up to three samples, any number of one value, or half a turn away."""
    if not len(steps):
        return _Excursions(*[np.zeros(0, dtype=np.intp)] * 3)
    wide = steps >= LEAST_SPIKE
    joints = np.flatnonzero(wide.sum(axis=0) >= 2)
    # where most steps are wide, only wider ones stand out
    wide = wide[:, joints] & (steps[:, joints] > OUTSTANDING * np.median(steps[:, joints], axis=0))
    parts = []
    for length in range(1, LONGEST_SPIKE + 1):
        if len(steps) >= length + 2 * AROUND - 1:
            before, column = np.nonzero(wide[: len(steps) - length] & wide[length:])
            parts.append(_Excursions(before, before + length + 1, joints[column]))
    column, start, stop = _runs(steps[:, joints] == 0.0)
    inner = (stop - start >= LONGEST_SPIKE) & (start >= 2) & (stop <= len(steps) - 2)
    before, after, joint = start[inner] - 1, stop[inner] + 1, joints[column[inner]]
    swings = (steps[before, joint] >= LEAST_SPIKE) & (steps[after - 1, joint] >= LEAST_SPIKE)
    swings &= (steps[before - 1, joint] > 0.0) & (steps[after, joint] > 0.0)
    parts.append(_Excursions(before, after, joint).at(swings))
    column, step = np.nonzero((wide & (steps[:, joints] >= HALF_TURN)).T)
    flips = (np.diff(column) == 0) & (np.diff(step) > LONGEST_SPIKE)
    before, after, joint = step[:-1][flips], step[1:][flips] + 1, joints[column[:-1][flips]]
    brief = times[after] - times[before + 1] <= LONGEST_FLIP
    before, after, joint = before[brief], after[brief], joint[brief]
    parts.append(_Excursions(before, after, joint).at(steps[before + 1, joint] > 0.0))
    return _Excursions(*map(np.concatenate, zip(*parts, strict=True)))


def _chain_speed(found: _Excursions, steps: Array, parents: np.ndarray | None) -> Array:
    """Return the largest step out or back of parent and children that do not leave and come back too, shape=[S]."""
    speed = np.zeros(len(found.before))
    if parents is None:
        return speed
    n_frames, n_joints = len(steps) + 1, steps.shape[1]
    places = (found.before * n_frames + found.after) * n_joints
    together = places + found.joint
    for joint in np.unique(found.joint).tolist():
        own = np.flatnonzero(found.joint == joint)
        relatives = [*np.flatnonzero(parents == joint).tolist(), *[int(each) for each in parents[[joint]] if each >= 0]]
        for relative in relatives:
            step = np.maximum(steps[found.before[own], relative], steps[found.after[own] - 1, relative])
            speed[own] = np.maximum(speed[own], np.where(np.isin(places[own] + relative, together), 0.0, step))
    return speed


def _departures(found: _Excursions, values: Array, times: Array, space: Space, steps: Array) -> Array:
    """Return how far each departs from the motion across it, shape=[S]; 0 for what does not leave and come back."""
    before, after, joint = found
    first, last = values[before, joint], values[after, joint]
    departure, away = np.full(len(before), np.inf), np.full(len(before), np.inf)
    length = after - before - 1
    for at in (before + 1, before + (length + 1) // 2, after - 1):  # all of three samples, and of one value
        inside, share = values[at, joint], (times[at] - times[before]) / (times[after] - times[before])
        departure = np.minimum(departure, space.distance(inside, space.between(first, last, share)))
        away = np.minimum(away, np.minimum(space.distance(inside, first), space.distance(inside, last)))
    across, lesser = space.distance(first, last), np.minimum(steps[before, joint], steps[after - 1, joint])
    returns = (across <= ACROSS * lesser) & (away >= 0.5 * lesser) & (departure >= LEAST_SPIKE)
    returns &= (length <= LONGEST_SPIKE) | (across <= FARTHEST * (length + 1) * _speed(found, steps))
    # poses that pop in stepped animation; of a joint at rest a large one that comes back to the very same is none
    inner = (length > 1) & (steps[before + 1, joint] == 0.0) & (steps[after - 2, joint] == 0.0)
    held = (steps[np.maximum(before - 1, 0), joint] == 0.0) & (steps[np.minimum(after, len(steps) - 1), joint] == 0.0)
    returns &= ~(inner & held) | ((departure >= FLIP) & space.same(first, last))
    return np.where(returns, departure, 0.0)


def _speed(found: _Excursions, steps: Array) -> Array:
    """Return the largest step around each, shape=[S]."""
    speed = np.zeros(len(found.before))
    for k in range(AROUND):
        for at in (found.before - 1 - k, found.after + k):
            inside = (at >= 0) & (at < len(steps))
            speed = np.maximum(speed, np.where(inside, steps[np.clip(at, 0, len(steps) - 1), found.joint], 0.0))
    return speed


def _unevenness(found: _Excursions, values: Array, times: Array, space: Space, steps: Array) -> Array:
    """Return how far samples around each are from between their neighbours, and a share of the speed, shape=[S]."""
    uneven, n_frames = np.zeros(len(found.before)), len(values)
    for k in range(1, AROUND + 1):
        for at in (found.before - k, found.after + k):
            inside = (at >= 1) & (at < n_frames - 1)
            centre, joint = np.clip(at, 1, n_frames - 2), found.joint
            share = (times[centre] - times[centre - 1]) / (times[centre + 1] - times[centre - 1])
            even = space.between(values[centre - 1, joint], values[centre + 1, joint], share)
            off = space.distance(values[centre, joint], even)
            uneven = np.maximum(uneven, np.where(inside, off, 0.0))
    return np.maximum(uneven + SHARE_OF_SPEED * _speed(found, steps), 1e-6)


def _without_flips(found: _Excursions, departure: Array, values: Array, times: Array, space: Space) -> Array:
    """Return the unevenness around each, once all that departs far is filled in; inf where that is a third of all."""
    joints, column = np.unique(found.joint, return_inverse=True)
    far = departure >= FLIP
    mask = np.zeros((len(values), len(joints)), dtype=bool)
    for first, last, k in zip(found.before[far].tolist(), found.after[far].tolist(), column[far].tolist(), strict=True):
        mask[first + 1 : last, k] = True
    filled = fill(values[:, joints], times, space, mask)
    local = _Excursions(found.before, found.after, column)
    uneven = _unevenness(local, filled, times, space, steps_between(filled, space))
    count = np.concatenate([np.zeros((1, len(joints)), dtype=np.intp), np.cumsum(mask, axis=0)])
    start, stop = np.maximum(found.before - 2 * AROUND + 1, 0), np.minimum(found.after + 2 * AROUND, len(values))
    crowded = 3 * (count[stop, column] - count[start, column]) >= stop - start
    return np.where(crowded, np.inf, uneven)


def _find_dropouts(values: Array, space: Space, steps: Array) -> list[Fault]:
    joint, start, stop = _runs(steps == 0.0)
    inner = (stop - start >= LEAST_REPEATS) & (start >= 1) & (stop <= len(steps) - 2)
    joint, start, stop = joint[inner], start[inner], stop[inner]
    inner = (steps[start - 1, joint] > 0.0) & (steps[stop + 1, joint] > 0.0)
    joint, start, stop = joint[inner], start[inner], stop[inner]
    if not len(joint):
        return []
    ends, group = np.unique(np.stack([start, stop]), axis=1, return_inverse=True)
    group = group.reshape(-1)  # whose shape differs between versions of NumPy

    def together(sizes: Array) -> Array:
        return np.sqrt(np.bincount(group, sizes**2, ends.shape[1]))

    missed = _missed(values, space, steps, joint, stop)
    largest = np.zeros(ends.shape[1])
    np.maximum.at(largest, group, missed)
    mean = 0.5 * (together(steps[start - 1, joint]) + together(steps[stop + 1, joint]))
    fastest = np.max(
        [
            together(steps[np.clip(at, 0, len(steps) - 1), joint])
            for k in range(AROUND)
            for at in (start - 1 - k, stop + 1 + k)
        ],
        axis=0,
    )
    leaves = together(steps[stop, joint])
    is_fault = (largest >= LEAST_CATCH_UP) & (together(missed) > mean)
    is_fault &= leaves <= FARTHEST * (ends[1] - ends[0] + 1) * fastest
    return [
        Fault(DROPOUT, int(joint[k]), int(start[k]) + 1, int(stop[k]) + 1, float(missed[k]))
        for k in np.flatnonzero(is_fault[group])
    ]


def _missed(values: Array, space: Space, steps: Array, joint: np.ndarray, last: np.ndarray) -> Array:
    """Return how far the last held sample is from where motion as fast as the next step would have begun, shape=[S].

    That is a segment, for it may have begun more slowly; its distance is that of a flat triangle.
    """
    begins = space.before(values[last + 1, joint], values[last + 2, joint])
    far, leaves, next_step = space.distance(values[last, joint], begins), steps[last, joint], steps[last + 1, joint]
    along = (far**2 + next_step**2 - leaves**2) / (2.0 * next_step)
    beside = np.sqrt(np.maximum(far**2 - np.clip(along, 0.0, None) ** 2, 0.0))
    return np.where(along > next_step, leaves, np.where(along > 0.0, beside, far))
