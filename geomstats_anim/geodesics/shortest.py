"""Shortest geodesics from the identity to rotations, for left-invariant metrics with diagonal matrices.

A geodesic found by shooting is certified as the shortest when it is no longer than the injectivity radius. Where it is
longer, or none was found, the other way round and continuation in the metric are tried, and then a survey: rays in
directions all over the sphere, as long as the best geodesic so far, whose nearest passes by the target start new shots.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.kernels import injectivity
from geomstats_anim.kernels.rigid_body import playback
from geomstats_anim.kernels.shooting import CONVERGED, shoot
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.rotations import Array

_RAYS, _RAY_SAMPLES, _CANDIDATES = 64, 24, 16
_MIN_ROUNDS, _MAX_ROUNDS = 3, 8
_SEARCH_PART = 256
"""Problems searched at once; bounds the memory."""

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
    index = doubtful(best, moments, vector)
    if start is not None and len(index):
        best.keep_better(index, _shoot(moments[index], vector[index], start[index], trusted=trusted))
        index = index[doubtful(best.at(index), moments[index], vector[index])]
    search = _search_everywhere if is_thorough else _follow
    for begin in range(0, len(index), _SEARCH_PART):
        part = index[begin : begin + _SEARCH_PART]
        best.replace(part, search(moments[part], vector[part]))
    return best


def _doubtful(shots: Shots, moments: Array, vector: Array) -> np.ndarray:
    """Find those that were not found, or may not be the shortest."""
    certain = (shots.status == CONVERGED) & (np.sqrt(shots.energy) <= _CERTAIN * injectivity_radius(moments))
    return np.flatnonzero(~certain)


def _too_long(shots: Shots, moments: Array, vector: Array) -> np.ndarray:
    """Find those that were not found, or are certainly not the shortest."""
    bound = _NO_LONGER * np.sqrt(_bi_invariant_energy(moments, vector)) + _NOTHING
    return np.flatnonzero(~(np.sqrt(shots.energy) <= bound))


def _follow(moments: Array, vector: Array) -> Shots:
    """Find geodesics by continuation in the metric, either way round, and keep the shorter."""
    best = _shoot(moments, vector, may_follow=True)
    best.keep_better(np.arange(len(vector)), _shoot(moments, _long_way(vector), may_follow=True))
    return best


def _search_everywhere(moments: Array, vector: Array) -> Shots:
    """Find the shortest geodesics where a shot alone is not enough.

    Geodesics from A to B are those from B to A, reversed. The same one of the two is always searched for, so that the
    distance is symmetric even where the search errs.
    """
    largest = np.take_along_axis(vector, np.abs(vector).argmax(axis=1)[:, None], axis=1)
    vector = np.where(largest < 0.0, -vector, vector)
    best = _follow(moments, vector)
    index = _doubtful(best, moments, vector)
    if len(index):
        found = best.at(index)
        _survey(moments[index], vector[index], found)
        best.replace(index, found)
    backward = np.flatnonzero((largest[:, 0] < 0.0) & (best.status == CONVERGED))
    best.replace(backward, _reversed(moments[backward], vector[backward], best.momentum[backward]))
    return best


def _reversed(moments: Array, vector: Array, momentum: Array) -> Shots:
    """Turn geodesics round: given those to exp(vector), find those to exp(-vector)."""
    end = _ends(moments, momentum)
    is_short_way = (end * quat.exp(vector)).sum(axis=-1, keepdims=True) >= 0.0
    way = np.where(is_short_way, -vector, -_long_way(vector))
    # one more shot takes off what rounding the turn has picked up
    return _shoot(moments, way, -quat.rotate(quat.conjugate(end), momentum))


def _shoot(
    moments: Array,
    vector: Array,
    start: Array | None = None,
    max_energy: Array | None = None,
    may_follow: bool = False,
    trusted: float = 0.0,
) -> Shots:
    """Run the compiled solver on a batch."""
    n = len(moments)
    start = np.full((n, 3), np.nan) if start is None else np.ascontiguousarray(start)
    max_energy = np.full(n, np.inf) if max_energy is None else max_energy
    momentum, residual = np.zeros((n, 3)), np.zeros(n)
    status, shots = np.zeros(n, dtype=np.intp), np.zeros(n, dtype=np.intp)

    def run(part: slice) -> None:
        shoot(
            moments[part],
            vector[part],
            start[part],
            max_energy[part],
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


def _long_way(vector: Array) -> Array:
    """Return the rotation vectors of the same rotations the other way round."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    axis = np.where(angle > 0.0, vector / np.where(angle > 0.0, angle, 1.0), [1.0, 0.0, 0.0])
    return vector - 2.0 * np.pi * axis


def _bi_invariant_energy(moments: Array, vector: Array) -> Array:
    """Return the squared length of the turn about the rotation's axis, which bounds the shortest geodesic's."""
    return (moments * vector**2).sum(axis=-1)


def _directions(turn: int) -> Array:
    """Spread unit vectors, shape=[_RAYS, 3], evenly over the sphere: a Fibonacci lattice, turned in each round."""
    i = np.arange(_RAYS) + 0.5
    height, azimuth = 1.0 - 2.0 * i / _RAYS, np.pi * (1.0 + np.sqrt(5.0)) * i
    radius = np.sqrt(1.0 - height**2)
    lattice = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=-1)
    return quat.rotate(quat.exp(turn * np.array([0.7, 1.1, 0.4])), lattice)


def _survey(moments: Array, vector: Array, best: Shots) -> None:
    """Look for shorter geodesics in every direction, until two rounds have found nothing; writes to `best`."""
    bi_invariant_energy = _bi_invariant_energy(moments, vector)
    index = np.arange(len(moments))
    for turn in range(_MAX_ROUNDS):
        before = best.energy[index]
        reach = np.minimum(before, bi_invariant_energy[index])
        start, is_short_way = _passes(moments[index], vector[index], reach, turn)
        way = np.where(is_short_way[..., None], vector[index, None], _long_way(vector[index])[:, None])
        mirrored, mirrored_way = _mirrored(moments[index], vector[index], best.momentum[index])
        candidates = np.concatenate([start, mirrored], axis=1)
        ways = np.concatenate([way, mirrored_way], axis=1)
        n_candidates = candidates.shape[1]
        found = _shoot(
            np.repeat(moments[index], n_candidates, axis=0),
            ways.reshape(-1, 3),
            candidates.reshape(-1, 3),
            np.repeat(reach, n_candidates),
        )
        choice = found.energy.reshape(-1, n_candidates).argmin(axis=1) + n_candidates * np.arange(len(index))
        shots = found.shots.reshape(-1, n_candidates).sum(axis=1)
        best.keep_better(index, found.at(choice)._replace(shots=shots))
        if turn + 1 >= _MIN_ROUNDS:
            index = index[best.energy[index] < before]
        if not len(index):
            return


def _passes(moments: Array, vector: Array, energy: Array, turn: int) -> tuple[Array, np.ndarray]:
    """Return momenta, shape=[n, _CANDIDATES, 3], of rays that pass near the targets, and whether by the short way."""
    n = len(moments)
    momentum = np.sqrt(moments * energy[:, None])[:, None] * _directions(turn)
    inverse = np.repeat(1.0 / moments, _RAYS, axis=0)
    flat = momentum.reshape(-1, 3)
    n_rays = n * _RAYS
    parameter = np.tile(np.arange(1, _RAY_SAMPLES + 1) / _RAY_SAMPLES, n_rays)
    first = np.arange(n_rays) * _RAY_SAMPLES
    poses = np.empty((n_rays * _RAY_SAMPLES, 1, 4))
    column = np.zeros(n_rays, dtype=np.intp)

    def run(part: slice) -> None:
        playback(inverse[part], flat[part], first[part], first[part] + _RAY_SAMPLES, parameter, column[part], poses)

    in_threads(run, n_rays)
    cosine = np.einsum("nrsi,ni->nrs", poses.reshape(n, _RAYS, _RAY_SAMPLES, 4), quat.exp(vector))
    sample = np.abs(cosine).argmax(axis=2)
    nearest = np.take_along_axis(cosine, sample[..., None], axis=2)[..., 0]
    ray = np.argsort(-np.abs(nearest), axis=1, kind="stable")[:, :_CANDIDATES]
    share = (np.take_along_axis(sample, ray, axis=1) + 1) / _RAY_SAMPLES
    start = np.take_along_axis(momentum, ray[..., None], axis=1) * share[..., None]
    return start, np.take_along_axis(nearest, ray, axis=1) > 0.0


def _mirrored(moments: Array, vector: Array, momentum: Array) -> tuple[Array, Array]:
    """Return momenta of the mirror images of geodesics, shape=[n, 12, 3], and the ways they go.

    Half turns about the principal axes, and reversal of time, carry geodesics to geodesics. At the cut locus a shortest
    geodesic and one of its images end at the same point; near it the image is a good start for the competitor.
    """
    body_momentum = quat.rotate(quat.conjugate(_ends(moments, momentum)), momentum)
    flip = 1.0 - 2.0 * np.eye(3)
    images = np.concatenate([body_momentum[:, None] * flip, momentum[:, None] * -flip], axis=1)
    ways = np.stack([vector, _long_way(vector)], axis=1)
    return np.tile(images, (1, 2, 1)), np.repeat(ways, images.shape[1], axis=1)


def _ends(moments: Array, momentum: Array) -> Array:
    """Return the ends of geodesics that start at the identity, shape=[n, 4]."""
    n = len(moments)
    end = np.empty((n, 1, 4))
    index = np.arange(n)
    playback(1.0 / moments, momentum, index, index + 1, np.ones(n), np.zeros(n, dtype=np.intp), end)
    return end[:, 0]
