"""The gradient search: a coarse grid, scipy's L-BFGS-B from there with the exact gradient, the better side a joint.

The rotation error is a sum over joints, so one evaluation of the grid serves all joints at once, and each takes its own
best. The location error couples a joint to those below it; there the rotation's best is where the search starts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.optimize import minimize

from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array
from geomstats_anim.shortest import Effort

FAMILIES = ("diagonal", "spd")
INVARIANCE_CHOICES = ("left", "right", "clip", "joint")

BOUND = np.log(10.0)
"""Largest |log alpha| and |log beta|: a condition number of at most 100."""

_GRID = np.linspace(-2.0, 2.0, 5)
_ROUGHLY = {"maxiter": 60, "ftol": 1e-6}
_EXACTLY = {"maxiter": 200, "ftol": 1e-8}
"""When L-BFGS-B stops: starts are followed roughly, the best of them exactly; ftol is in shares of slerp's value."""

_HELPS = 1.0 - 1e-6
"""A point counts as better if it leaves at most this share of an error."""

_AXES_BOUND = np.pi
_TILTED = 150
"""Tilted matrices that every joint tries, where the family has them."""


class Learnable(Protocol):
    """What a search needs of its objective."""

    def value(self, parameters: MetricParameters) -> float:
        """Return the quality; 0 is perfect."""
        ...

    def value_and_gradient(self, parameters: MetricParameters) -> tuple[float, Array]:
        """Return the quality, and its derivative, shape=[B, 5], by log alpha, log beta and a turn of the axes."""
        ...

    def rotation_errors_by_joint(self, parameters: MetricParameters, effort: Effort = "thorough") -> Array:
        """Return the weighted rotation error of each joint, shape=[B], which depends on its own parameters only."""
        ...


@dataclass(frozen=True)
class Found:
    """A metric and its value."""

    parameters: MetricParameters
    value: float
    evaluations: int


def search_gradient(
    objective: Learnable,
    n_joints: int,
    family: str = "diagonal",
    invariance: str = "joint",
    progress: Callable[[int, float], None] = lambda evaluations, value: None,
) -> Found:
    """Minimise an objective over metrics.

    Parameters
    ----------
    objective : Learnable
    n_joints : int
    family : str
        "diagonal", or "spd": any symmetric positive definite matrix.
        Optional, default: "diagonal".
    invariance : str
        "left", "right", "clip" (the better one for all joints) or "joint" (one a joint).
        Optional, default: "joint".
    progress : callable
        Called with the number of evaluations and the best value so far.

    Returns
    -------
    found : Found
        Never worse than the identity metric.
    """
    if family not in FAMILIES:
        raise ValueError(f"There is no family {family!r}; the families are {', '.join(FAMILIES)}.")
    if invariance not in INVARIANCE_CHOICES:
        raise ValueError(f"There is no invariance {invariance!r}; the choices are {', '.join(INVARIANCE_CHOICES)}.")
    search = _Search(objective, n_joints, invariance != "joint", progress)
    sides = ("left", "right") if invariance in ("clip", "joint") else (invariance,)
    search.offer(np.zeros((n_joints, 2)), (sides[0],) * n_joints)
    search.identity_value, search.identity_errors = search.best_value, search.best_errors
    starts = {side: search.grid(side) for side in sides}
    if invariance == "joint":
        best = np.argmin([errors for _, errors in starts.values()], axis=0)
        mixed = tuple(sides[i] for i in best)
        points = np.stack([point for point, _ in starts.values()])
        search.descend(points[best, np.arange(n_joints)], mixed, _ROUGHLY)
        search.try_other_sides(dict(zip(sides, points, strict=True)))
    for side, (point, _) in starts.items():
        search.descend(point, (side,) * n_joints, _ROUGHLY)
    search.descend(search.best_point, search.best_sides, _EXACTLY)
    if family == "spd":
        search.free_axes(sides)
        search.descend(search.best_point, search.best_sides, _EXACTLY)
    return Found(search.parameters(search.best_point, search.best_sides), search.best_value, search.evaluations)


class _Search:
    """The best point so far, shape=[B, 2] or [B, 5]: log alpha, log beta and the axes' rotation vector."""

    def __init__(
        self, objective: Learnable, n_joints: int, one_side: bool, progress: Callable[[int, float], None]
    ) -> None:
        self.objective, self.n_joints, self._one_side, self._progress = objective, n_joints, one_side, progress
        self.best_value, self.evaluations = np.inf, 0
        self.best_point: Array = np.zeros((n_joints, 2))
        self.best_sides: tuple[str, ...] = ("left",) * n_joints
        self.best_errors: Array = np.full(n_joints, np.inf)
        self.identity_value, self.identity_errors = 1.0, self.best_errors

    @staticmethod
    def parameters(point: Array, sides: Sequence[str]) -> MetricParameters:
        axes = point[:, 2:] if point.shape[1] == 5 else None
        return MetricParameters(np.exp(point[:, 0]), np.exp(point[:, 1]), axes, tuple(sides))

    def offer(self, point: Array, sides: tuple[str, ...]) -> bool:
        """Keep a point if it is better than the best so far."""
        self.evaluations += 1
        value = self.objective.value(self.parameters(point, sides))
        better = value < self.best_value
        if better:
            self.best_value, self.best_point, self.best_sides = value, point.copy(), sides
            self.best_errors = self._rotation_errors(point, sides)
        self._progress(self.evaluations, self.best_value)
        return better

    def offer_by_joint(self, point: Array, sides: tuple[str, ...]) -> None:
        """Offer a point, and then the best of it and the best so far, joint by joint."""
        self.offer(point, sides)
        if self._one_side and sides != self.best_sides:
            return
        errors = self._rotation_errors(point, sides)
        if point.shape != self.best_point.shape:
            self.best_point = np.concatenate([self.best_point, np.zeros((self.n_joints, 3))], axis=1)
        better = errors < self.best_errors
        mixed_sides = (mine if ok else other for ok, mine, other in zip(better, sides, self.best_sides, strict=True))
        self.offer(np.where(better[:, None], point, self.best_point), tuple(mixed_sides))

    def grid(self, side: str) -> tuple[Array, Array]:
        """Best point of the grid for each joint's own rotation error, shape=[B, 2], and those errors.

        A joint that no point helps, because it does not turn, or about one axis only, stays at the identity.
        """
        points = np.stack(np.meshgrid(_GRID, _GRID, indexing="ij"), axis=-1).reshape(-1, 2)
        sides = (side,) * self.n_joints
        errors = [self._rotation_errors(np.tile(point, (self.n_joints, 1)), sides, "quick") for point in points]
        best, least = points[np.argmin(errors, axis=0)], np.min(errors, axis=0)
        helps = least < _HELPS * self.identity_errors
        return np.where(helps[:, None], best, 0.0), np.where(helps, least, self.identity_errors)

    def descend(self, point: Array, sides: tuple[str, ...], stop: dict[str, float]) -> None:
        """Follow the gradient from a point."""
        shape = point.shape
        unit = max(self.identity_value, 1e-12)

        def evaluate(flat: Array) -> tuple[float, Array]:
            self.evaluations += 1
            current = flat.reshape(shape)
            value, gradient = self.objective.value_and_gradient(self.parameters(current, sides))
            self._progress(self.evaluations, min(self.best_value, value))
            by_point = gradient[:, :2]
            if shape[1] == 5:
                # the gradient is by a turn from the left, the point holds a rotation vector
                by_axes = np.einsum("bij,bi->bj", left_jacobian(current[:, 2:]), gradient[:, 2:])
                by_point = np.concatenate([by_point, by_axes], axis=1)
            # in units of slerp's value, so that tolerances mean the same for metres and radians
            return value / unit, by_point.ravel() / unit

        options: Any = {"maxcor": 20, "gtol": 1e-7, **stop}
        bounds = [(-BOUND, BOUND)] * 2 + [(-_AXES_BOUND, _AXES_BOUND)] * (shape[1] - 2)
        result = minimize(
            evaluate,
            point.ravel(),
            jac=True,
            method="L-BFGS-B",
            bounds=bounds * shape[0],
            options=options,
        )
        # a descent follows geodesics that may cease to be the shortest, in some joints
        self.offer_by_joint(result.x.reshape(shape), sides)

    def try_other_sides(self, points: dict[str, Array]) -> None:
        """Turn single joints to the other side, root to leaf, where that helps; then follow the gradient once more."""
        turned = False
        for joint in range(self.n_joints):
            other = "right" if self.best_sides[joint] == "left" else "left"
            point = self.best_point.copy()
            point[joint] = points[other][joint]
            sides = (*self.best_sides[:joint], other, *self.best_sides[joint + 1 :])
            turned |= self.offer(point, sides)
        if turned:
            self.descend(self.best_point, self.best_sides, _ROUGHLY)

    def free_axes(self, sides: Sequence[str]) -> None:
        """Go on from the best diagonal matrices with axes unturned, and from the best of many tilted ones."""
        diagonal = np.concatenate([self.best_point, np.zeros((self.n_joints, 3))], axis=1)
        diagonal_sides = self.best_sides
        random = np.random.default_rng(0)
        trials = np.concatenate(
            [random.uniform(_GRID[0], _GRID[-1], (_TILTED, 2)), random.normal(0.0, 1.5, (_TILTED, 3))], axis=1
        )
        self.descend(diagonal, diagonal_sides, _ROUGHLY)
        errors = self._rotation_errors(diagonal, diagonal_sides)
        point, chosen = diagonal.copy(), list(diagonal_sides)
        for number, trial in enumerate(trials):
            trial_sides = diagonal_sides if self._one_side else (sides[number % len(sides)],) * self.n_joints
            trial_errors = self._rotation_errors(np.tile(trial, (self.n_joints, 1)), trial_sides, "quick")
            better = np.flatnonzero(trial_errors < _HELPS * errors)
            point[better], errors[better] = trial, trial_errors[better]
            for joint in better:
                chosen[joint] = trial_sides[joint]
        self.descend(point, tuple(chosen), _ROUGHLY)

    def _rotation_errors(self, point: Array, sides: tuple[str, ...], effort: Effort = "thorough") -> Array:
        self.evaluations += 1
        errors = self.objective.rotation_errors_by_joint(self.parameters(point, sides), effort)
        self._progress(self.evaluations, self.best_value)
        return errors


def left_jacobian(vector: Array) -> Array:
    """Differentiate a rotation, as a turn from the left, by its rotation vector (Sola 2017, equation 145).

    Parameters
    ----------
    vector : array-like, shape=[..., 3]

    Returns
    -------
    jacobian : array-like, shape=[..., 3, 3]
    """
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    zero = np.zeros_like(vector[..., 0])
    x, y, z = np.moveaxis(vector, -1, 0)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    hat = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    second = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    return np.eye(3) + first * hat + second * (hat @ hat)
