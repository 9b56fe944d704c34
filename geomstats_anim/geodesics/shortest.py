"""Shortest geodesics from the identity to rotations, for left-invariant metrics with diagonal matrices.

A geodesic found by shooting is certified as the shortest when it is no longer than the injectivity radius, or when it
reaches its end before its cut point. Otherwise shots start from the images of geodesics that passed theirs, and from
geodesics in all directions that a shortest one may take, until one is certified.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.cut_points import cut_points, states
from geomstats_anim.kernels import injectivity
from geomstats_anim.kernels.shooting import CONVERGED, shoot
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.rotations import Array

_DIRECTIONS, _LENGTHS = 4, 12
"""Geodesics looked at for each shot: directions of their momentum half way, and lengths."""

_ROUNDS = (0, 0, 4, 0, 8, 0, 8, 0, 16, 0, 16, 0, 16, 0)
"""Shots of each round at a target, that start from geodesics in all directions; 0: from images of those before."""

_SEARCH_PART, _FEW = 1024, 256
"""Problems searched at once: at most, which bounds the memory, and in a thread of their own."""

_CERTAIN = 1.0 + 1e-12
_SHORTER = 1.0 - 1e-9
_NO_LONGER, _NOTHING = 1.0 + 1e-6, 1e-10
"""Slack for the miss of the end point, of short turns above all, where the turn about one axis is the geodesic."""

_TRUSTED = 1e-5
"""Miss, in radians, whose Newton step a quick search does not look at again."""


class Shots(NamedTuple):
    """Geodesics that shooting found.

    Attributes
    ----------
    momentum : array-like, shape=[n, 3]
    energy : array-like, shape=[n]
        Squared length; infinite where none was found.
    status : array-like of int, shape=[n]
    residual : array-like, shape=[n]
        Miss of the end point, radians.
    shots : array-like of int, shape=[n]
    """

    momentum: Array
    energy: Array
    status: np.ndarray
    residual: Array
    shots: np.ndarray

    def at(self, index: np.ndarray) -> Shots:
        """Return a copy of some of them."""
        return Shots(*(values[index] for values in self))

    def replace(self, index: np.ndarray, other: Shots) -> None:
        """Write others over those at `index`, and count the shots of both."""
        other.shots[:] += self.shots[index]
        for mine, new in zip(self, other, strict=True):
            mine[index] = new

    def keep_better(self, index: np.ndarray, other: Shots) -> None:
        """Write those of `other` that are shorter over those at `index`, and count their shots."""
        self.shots[index] += other.shots
        better = (other.energy < _SHORTER * self.energy[index]) | (
            (other.status == CONVERGED) & (self.status[index] != CONVERGED)
        )
        for mine, new in zip(self[:4], other[:4], strict=True):
            mine[index[better]] = new[better]


def injectivity_radius(moments: Array) -> Array:
    """Return a length up to which every geodesic is certainly the only shortest one.

    It is the smaller of pi / sqrt(K), K the largest sectional curvature, and half the shortest closed geodesic, a full
    turn about the axis of the smallest moment (Klingenberg).

    Parameters
    ----------
    moments : array-like, shape=[n, 3]

    Returns
    -------
    radius : array-like, shape=[n]
    """
    radius = np.empty(len(moments))
    injectivity.radii(moments, radius)
    return radius


Effort = Literal["thorough", "quick"]


def shortest_momenta(moments: Array, vector: Array, start: Array | None = None, effort: Effort = "thorough") -> Shots:
    """Find initial momenta of the shortest geodesics.

    Parameters
    ----------
    moments : array-like, shape=[n, 3]
        Positive.
    vector : array-like, shape=[n, 3]
        Shortest rotation vectors of the targets, radians.
    start : array-like, shape=[n, 3]
        Momenta to try where a guess is not enough; not a number where none is known.
        Optional, default: None.
    effort : str
        "thorough": certify what Newton's method finds, and search everywhere where that fails. "quick": take it, exact
        to some 1e-10 radians, unless it is nothing, or longer than a turn about one axis, and then the best of what
        continuation finds.
        Optional, default: "thorough".

    Returns
    -------
    shots : Shots
    """
    # copies: the kernels would be compiled once more for arrays that are read-only or of another type
    moments, vector = (np.array(values, dtype=np.float64, order="C") for values in (moments, vector))
    is_thorough = effort == "thorough"
    doubtful, trusted = (_doubtful, 0.0) if is_thorough else (_too_long, _TRUSTED)
    best = _shoot(moments, vector, trusted=trusted)
    index, images = doubtful(best, moments, vector)
    if start is not None and len(index):
        best.keep_better(index, _shoot(moments[index], vector[index], start[index], trusted=trusted))
        left, images = doubtful(best.at(index), moments[index], vector[index])
        index = index[left]
    search = _search if is_thorough else _follow

    def run(part: slice) -> None:
        for begin in range(part.start, part.stop, _SEARCH_PART):
            some = slice(begin, min(begin + _SEARCH_PART, part.stop))
            own = index[some]
            best.replace(own, search(moments[own], vector[own], best.at(own), images[some]))

    in_threads(run, len(index), _FEW)
    return best


def _doubtful(shots: Shots, moments: Array, vector: Array) -> tuple[np.ndarray, Array]:
    """Find those that were not found, or are not certified as the shortest, and images of them; see `cut_points`."""
    far = np.flatnonzero(~(np.sqrt(shots.energy) <= _CERTAIN * injectivity_radius(moments)))
    is_certain, images = _certified(shots.at(far), moments[far])
    return far[~is_certain], images[~is_certain]


def _too_long(shots: Shots, moments: Array, vector: Array) -> tuple[np.ndarray, Array]:
    """Find those that were not found, or are certainly not the shortest, and their momenta."""
    bound = _NO_LONGER * np.sqrt(_bi_invariant_energy(moments, vector)) + _NOTHING
    index = np.flatnonzero(~(np.sqrt(shots.energy) <= bound))
    return index, shots.momentum[index]


def _follow(moments: Array, vector: Array, first: Shots, images: Array) -> Shots:
    """Find geodesics by continuation in the metric."""
    return _shoot(moments, vector, may_follow=True)


def _search(moments: Array, vector: Array, first: Shots, images: Array) -> Shots:
    """Find the shortest geodesics where a first shot was not enough, from it and its images on.

    Geodesics from A to B are those from B to A, reversed. The same one of the two is always searched for, so that the
    distance is symmetric even where the search errs.
    """
    largest = vector[np.arange(len(vector)), np.abs(vector).argmax(axis=1)]
    vector = np.where(largest[:, None] < 0.0, -vector, vector)
    best = first._replace(shots=np.zeros_like(first.shots))
    is_certain: np.ndarray = np.zeros(len(vector), dtype=bool)
    turned = np.flatnonzero(largest < 0.0)
    if len(turned):
        best.replace(turned, _shoot(moments[turned], vector[turned]))
        is_certain[turned], images[turned] = _certified(best.at(turned), moments[turned])
    index, starts = np.flatnonzero(~is_certain), images[~is_certain, None]
    for turn, n_starts in enumerate(_ROUNDS):
        if not len(index):
            break
        if n_starts:
            energy = np.minimum(best.energy[index], _bi_invariant_energy(moments[index], vector[index]))
            starts = _ahead(moments[index], vector[index], energy, turn, n_starts)
        n_starts = starts.shape[1]
        own = np.repeat(index, n_starts)
        found = _shoot(moments[own], vector[own], starts.reshape(-1, 3))
        is_certain, images = _certified(found, moments[own])
        is_certain = is_certain.reshape(-1, n_starts)
        choice = np.where(is_certain, 0.0, found.energy.reshape(-1, n_starts)).argmin(axis=1)
        shots = found.shots.reshape(-1, n_starts).sum(axis=1)
        best.keep_better(index, found.at(choice + n_starts * np.arange(len(index)))._replace(shots=shots))
        left = ~is_certain.any(axis=1)
        index, starts = index[left], images.reshape(-1, n_starts, 3)[left]
    backward = turned[best.status[turned] == CONVERGED]
    best.replace(backward, _reversed(moments[backward], vector[backward], best.momentum[backward]))
    return best


def _certified(shots: Shots, moments: Array) -> tuple[np.ndarray, Array]:
    """Return which were found and are the shortest, and images of the others to start from; see `cut_points`."""
    cuts = cut_points(moments, shots.momentum)
    return cuts.is_shortest & (shots.status == CONVERGED), cuts.image


def _ahead(moments: Array, vector: Array, energy: Array, turn: int, n_starts: int) -> Array:
    """Return momenta, shape=[n, n_starts, 3], of geodesics no longer than some squared lengths that end near targets.

    Half way, the body momentum of a shortest geodesic has the signs of its target's rotation vector, see `cut_points`.
    """
    n = _DIRECTIONS * n_starts
    directions = np.where(vector < 0.0, -1.0, 1.0)[:, None] * np.abs(_directions(turn, n))
    momentum = (np.sqrt(moments * energy[:, None])[:, None] * directions).reshape(-1, 3)
    every = np.repeat(moments, n, axis=0)
    shares = np.arange(1, _LENGTHS + 1) / _LENGTHS
    forth, _ = states(every, momentum, 0.5 * shares)
    back, body = states(every, -momentum, 0.5 * shares)
    ends = quat.multiply(quat.conjugate(back), forth).reshape(len(moments), -1, 4)
    cosine = np.einsum("nsi,ni->ns", ends, quat.exp(vector))
    nearest = np.argsort(-cosine, axis=1, kind="stable")[:, :n_starts]
    first = -(shares[:, None] * body.reshape(-1, _LENGTHS, 3)).reshape(len(moments), -1, 3)
    return np.take_along_axis(first, nearest[..., None], axis=1)


def _reversed(moments: Array, vector: Array, momentum: Array) -> Shots:
    """Turn geodesics round: given those to exp(vector), find those to exp(-vector)."""
    _, body = states(moments, momentum, np.ones(1))
    # one more shot takes off what rounding the turn has picked up
    return _shoot(moments, -vector, -body[:, 0])


def _shoot(
    moments: Array,
    vector: Array,
    start: Array | None = None,
    may_follow: bool = False,
    trusted: float = 0.0,
) -> Shots:
    """Run the compiled solver on a batch."""
    n = len(moments)
    start = np.full((n, 3), np.nan) if start is None else np.ascontiguousarray(start)
    momentum, residual = np.zeros((n, 3)), np.zeros(n)
    status, shots = np.zeros(n, dtype=np.intp), np.zeros(n, dtype=np.intp)

    def run(part: slice) -> None:
        shoot(
            moments[part],
            vector[part],
            start[part],
            may_follow,
            trusted,
            momentum[part],
            residual[part],
            status[part],
            shots[part],
        )

    in_threads(run, n)
    energy = np.where(status == CONVERGED, (momentum**2 / moments).sum(axis=-1), np.inf)
    return Shots(momentum, energy, status, residual, shots)


def _bi_invariant_energy(moments: Array, vector: Array) -> Array:
    """Return the squared length of the turn about the rotation's axis, which bounds the shortest geodesic's."""
    return (moments * vector**2).sum(axis=-1)


def _directions(turn: int, n: int) -> Array:
    """Spread unit vectors, shape=[n, 3], over the sphere: a Fibonacci lattice, turned in each round."""
    i = np.arange(n) + 0.5
    height, azimuth = 1.0 - 2.0 * i / n, np.pi * (1.0 + np.sqrt(5.0)) * i
    radius = np.sqrt(1.0 - height**2)
    lattice = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=-1)
    return quat.rotate(quat.exp(turn * np.array([0.7, 1.1, 0.4])), lattice)
