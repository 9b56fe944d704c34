"""The optima of families of metrics that contain one another.

The spline contains the geodesic, "spd" contains "diagonal", and a side for each joint contains one for all. The search
of a family starts from the optima of those that it contains, and takes one of them where it finds nothing better.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim.learning.descent import EXACTLY, ROUGHLY, TENSIONS, Search, Tally
from geomstats_anim.learning.learnable import Learnable
from geomstats_anim.names import INVARIANCES
from geomstats_anim.parameters import CurveParameters
from geomstats_anim.rotations import Array

_GRID = np.linspace(-2.0, 2.0, 5)
"""Of log alpha and log beta."""

_ROUNDS, _TILTED_ROUNDS = 20, 60
"""Largest number of steps of the descent of a single joint."""

_TRIALS, _STARTS = 64, 1
"""Tilted matrices that every joint tries on each side, and descents from the best."""


_GAINS = 1.0 - 1e-4
"""Largest share of the value that a contained optimum leaves for a descent from there."""


class Optimum(NamedTuple):
    """The best metric that is known of a family.

    Attributes
    ----------
    point : array-like, shape=[B, 7]
        See `Search`.
    sides : tuple of str, shape=[B]
    value : float
        Of the objective.
    quality : float
        The same without smoothing, by which optima are compared.
    scale : array-like, shape=[B, 7]
        Square roots of curvatures.
    starts : tuple of array-like, shape=[B, 7]
        Points that are best for the rotations of each joint by itself.
    """

    point: Array
    sides: tuple[str, ...]
    value: float
    quality: float
    scale: Array
    starts: tuple[Array, ...]


class Families:
    """The optima of all families that have been asked for.

    Parameters
    ----------
    objective : Learnable
    n_joints : int
    tally : Tally
    """

    def __init__(self, objective: Learnable, n_joints: int, tally: Tally) -> None:
        self._objective, self._n_joints, self._tally = objective, n_joints, tally
        self._known: dict[tuple[str, str, str], Optimum] = {}

    def best(self, scheme: str, family: str, invariance: str) -> Optimum:
        """Return the optimum of a family, never above those of the families that it contains."""
        key = (scheme, family, invariance)
        if key not in self._known:
            found, starts = self._contained(*key), tuple[Array, ...]()
            if invariance != "clip":  # which is one of two sides, and nothing else
                found.append(self._search(*key, found))
                starts = found[-1].starts
            best = min(found, key=lambda optimum: optimum.quality)
            # a contained one may win on one side; its joints are mixed from where the search has led all the same
            self._known[key] = best._replace(starts=starts or best.starts)
        return self._known[key]

    def _contained(self, scheme: str, family: str, invariance: str) -> list[Optimum]:
        if invariance == "clip":
            return [self.best(scheme, family, side) for side in INVARIANCES]
        contained = []
        if invariance == "joint":
            contained.append(self.best(scheme, family, "clip"))
        if family == "spd":
            contained.append(self.best(scheme, "diagonal", invariance))
        if scheme == "geodesic-spline":
            contained.append(self.best("geodesic", family, invariance))
        if family == "diagonal" and invariance in INVARIANCES:
            contained.append(self._plain(scheme, invariance))
        return contained

    def _plain(self, scheme: str, side: str) -> Optimum:
        """Return the bi-invariant metric with the usual tension."""
        point = np.zeros((self._n_joints, 7))
        point[:, TENSIONS] = CurveParameters.plain(scheme, 1).tension
        return self._optimum(point, (side,) * self._n_joints, np.ones_like(point), ())

    def _optimum(self, point: Array, sides: tuple[str, ...], scale: Array, starts: tuple[Array, ...]) -> Optimum:
        curve = Search.curve(point, sides)
        value, quality = self._objective.value(curve), self._objective.quality(curve)
        return Optimum(point, sides, value, quality, scale, starts)

    def _search(self, scheme: str, family: str, invariance: str, contained: list[Optimum]) -> Optimum:
        """Search a family from the optima of those that it contains."""
        sides = INVARIANCES if invariance == "joint" else (invariance,)
        search = Search(self._objective, self._n_joints, family, scheme, sides, invariance != "joint", self._tally)
        if invariance == "joint":
            starts = self._mix_sides(search, scheme, family)
        elif family == "spd":
            starts = self._tilt(search, scheme, invariance)
        else:
            starts = self._fit_diagonal(search, invariance)
        search.descend(search.best_point, search.best_sides, EXACTLY if invariance == "joint" else ROUGHLY)
        own = search.best_value
        for optimum in contained:
            search.offer_by_joint(optimum.point, optimum.sides)
        if search.best_value < _GAINS * own:
            search.descend(search.best_point, search.best_sides, EXACTLY)
        return self._optimum(search.best_point, search.best_sides, search.scale, starts)

    def _fit_diagonal(self, search: Search, side: str) -> tuple[Array, ...]:
        """Fit each joint by itself, and return where that has led."""
        sides = (side,) * self._n_joints
        start = search.grid(side, _GRID)
        fit = search.refine(start, sides, _ROUNDS)
        search.offer_by_joint(fit, sides)
        if self._objective.kind != "loc":
            return (fit,)
        # what is best for rotations may be far from what is best for bone ends alone
        for point in (fit, start):
            search.descend(point, sides, ROUGHLY)
        return fit, start

    def _tilt(self, search: Search, scheme: str, side: str) -> tuple[Array, ...]:
        """Free the axes of diagonal matrices, and try tilted ones: random, or for the spline the geodesic's optimum."""
        sides, diagonal = (side,) * self._n_joints, self.best(scheme, "diagonal", side)
        search.offer(diagonal.point, sides)
        if scheme == "geodesic":
            search.tilt(_TRIALS, _STARTS, _TILTED_ROUNDS)
            return (search.best_point,)
        start = self.best("geodesic", "spd", side).point.copy()
        start[:, TENSIONS] = diagonal.point[:, TENSIONS]
        for point in (search.best_point, start):
            search.offer_by_joint(search.refine(point, sides, _TILTED_ROUNDS), sides)
        return (search.best_point,)

    def _mix_sides(self, search: Search, scheme: str, family: str) -> tuple[Array, ...]:
        """Choose the better side for each joint."""
        optima = [self.best(scheme, family, side) for side in INVARIANCES]
        for points in zip(*(optimum.starts for optimum in optima), strict=True):
            for optimum, point in zip(optima, points, strict=True):
                search.offer_by_joint(point, optimum.sides)
            search.try_other_sides(dict(zip(INVARIANCES, points, strict=True)))
        left = np.array([side == "left" for side in search.best_sides])[:, None]
        search.scale = np.where(left, optima[0].scale, optima[1].scale)
        return ()
