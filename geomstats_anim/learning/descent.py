"""The moves of the gradient search, and the best point that they have led to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from geomstats_anim.geodesics.exponential import left_jacobian
from geomstats_anim.learning.batched_bfgs import batched_bfgs
from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.names import MAX_TENSION
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array

BOUND = np.log(10.0)
"""Largest |log alpha| and |log beta|: a condition number of at most 100."""

ROUGHLY = {"maxiter": 60, "ftol": 1e-5}
EXACTLY = {"maxiter": 100, "ftol": 2e-6}
"""Tolerances of L-BFGS-B: starts are followed roughly, the best exactly; ftol is in shares of the start's value."""

_REFINED = 1e-6
"""Tolerance of a single joint's descent, in shares of its error at the start."""

_NEGLIGIBLE = 1e-3
"""Share of the largest rotation error that a joint's is not followed below; with the square of it, it does not turn."""

_FLAT = 1e-2
"""Curvature of a joint, as a share of the largest, below which its variables are not stretched any more."""

_HELPS = 1.0 - 1e-6
"""A point counts as better if it leaves at most this share of an error."""

_MOMENTS, _AXES, TENSIONS = [0, 1], [2, 3, 4], [5, 6]
_TENSION, _TRANSLATION_TENSION = TENSIONS
BOUNDS = [(-BOUND, BOUND)] * 2 + [(-np.pi, np.pi)] * 3 + [(0.0, MAX_TENSION)] * 2
"""Of the columns of a point."""

_TILTED_MOMENTS = 2.0
"""Largest |log alpha| and |log beta| of the tilted matrices that are tried."""


class Tally:
    """Evaluations so far, and the best value, reported to a callable."""

    def __init__(self, progress: Callable[[int, float], None]) -> None:
        self._progress = progress
        self.evaluations, self.best = 0, np.inf

    def count(self, value: float = np.inf) -> None:
        """Count one more evaluation, and report the least of its value and the best one."""
        self.evaluations += 1
        self._progress(self.evaluations, min(self.best, value))


class Search:
    """The best point so far, shape=[B, 7]: log alpha, log beta, the axes' rotation vector and both tensions."""

    def __init__(
        self,
        objective: Learnable,
        n_joints: int,
        family: str,
        scheme: str,
        sides: Sequence[str],
        one_side: bool,
        tally: Tally,
    ) -> None:
        self.objective, self.n_joints, self._tally = objective, n_joints, tally
        self._free, self._sides, self._one_side = free_columns(family, scheme), sides, one_side
        self.best_value = np.inf
        self.best_point: Array = np.zeros((n_joints, 7))
        self.best_sides: tuple[str, ...] = (sides[0],) * n_joints
        self.best_errors: Array = np.full(n_joints, np.inf)
        self.offer(self.best_point, self.best_sides)
        if _TENSION in self._free:
            self._choose_tensions()
        self.scale = np.ones((n_joints, 7))
        self._base = self.best_point
        self._base_value, self._base_errors = self.best_value, self.best_errors
        self._turning = np.flatnonzero(self._base_errors > _NEGLIGIBLE**2 * self._base_errors.max(initial=0.0))

    @property
    def found(self) -> Found:
        """Return the best so far."""
        return Found(self.curve(self.best_point, self.best_sides), self.best_value, self._tally.evaluations)

    @staticmethod
    def curve(point: Array, sides: Sequence[str]) -> CurveParameters:
        """Return the curve of a point, shape=[J, 7], of as many joints as there are sides."""
        alpha, beta, *axes, tension, translation_tension = point.T
        tilted = np.stack(axes, axis=-1) if np.any(axes) else None
        metric = MetricParameters(np.exp(alpha), np.exp(beta), tilted, tuple(sides))
        return CurveParameters(metric, tension, translation_tension)

    def _choose_tensions(self) -> None:
        """Start from the best of a few tensions for each joint, and for all translations."""
        point = self.best_point.copy()
        for tension in (1.0, 0.5, 1.5, 2.0):
            point[:, TENSIONS] = tension
            self.offer_by_joint(point, self.best_sides)
        for tension in (0.0, 1.0, 2.0):
            point = self.best_point.copy()
            point[:, _TRANSLATION_TENSION] = tension
            self.offer(point, self.best_sides)

    def offer(self, point: Array, sides: tuple[str, ...]) -> bool:
        """Keep a point if it is better than the best so far."""
        return self._offer(point, sides)[0]

    def _offer(self, point: Array, sides: tuple[str, ...]) -> tuple[bool, Array]:
        """Offer a point, and return whether it is the best, and its rotation errors."""
        errors, parts = self.objective.errors_by_joint(self.curve(point, sides))
        value = float(parts.sum())
        better = value < self.best_value
        if better:
            self.best_value, self.best_point, self.best_sides = value, point.copy(), sides
            self.best_errors = errors
            self._tally.best = min(self._tally.best, value)
        self._tally.count()
        return better, errors

    def offer_by_joint(self, point: Array, sides: tuple[str, ...]) -> None:
        """Offer a point, and then the best of it and the best so far, joint by joint."""
        _, errors = self._offer(point, sides)
        if self._one_side and sides != self.best_sides:
            return
        better = errors < self.best_errors
        mixed_sides = (mine if ok else other for ok, mine, other in zip(better, sides, self.best_sides, strict=True))
        self.offer(np.where(better[:, None], point, self.best_point), tuple(mixed_sides))

    def grid(self, side: str, values: Array) -> Array:
        """Return the best point of the grid for each joint's own rotation error, shape=[B, 7].

        A joint that no point helps, because it does not turn, or about one axis only, stays at the identity.
        """
        point, least = self._base.copy(), _HELPS * self._base_errors
        for moments in np.stack(np.meshgrid(values, values, indexing="ij"), axis=-1).reshape(-1, 2):
            trial = self._base.copy()
            trial[:, _MOMENTS] = moments
            errors = self._rotation_errors(trial, (side,) * self.n_joints)
            better = errors < least
            point[better], least[better] = trial[better], errors[better]
        return point

    def refine(self, point: Array, sides: tuple[str, ...], rounds: int) -> Array:
        """Follow the gradient of each joint's own rotation error, and return where it leads, shape=[B, 7]."""
        free = [column for column in self._free if column != _TRANSLATION_TENSION]

        def placed(values: Array, joints: np.ndarray) -> Array:
            current = point[joints].copy()
            current[:, free] = values
            return current

        def evaluate(values: Array, joints: np.ndarray) -> tuple[Array, Array]:
            current = placed(values, joints)
            curve = self.curve(current, [sides[joint] for joint in joints])
            errors, gradient = self.objective.rotation_errors_and_gradient(curve, joints)
            self._tally.count()
            return errors, by_coordinates(gradient, current)[:, free]

        lower, upper = np.transpose([BOUNDS[column] for column in free])
        tolerance = _REFINED * np.maximum(self._base_errors, _NEGLIGIBLE * self._base_errors.max(initial=1e-12))
        values, _, curvature = batched_bfgs(evaluate, point[:, free], lower, upper, tolerance, rounds)
        self.scale[:, free] = np.sqrt(curvature + _FLAT * curvature.max(initial=1e-12))
        self.scale[:, _TRANSLATION_TENSION] = self.scale[:, free].min()
        return placed(values, np.arange(self.n_joints))

    def descend(self, point: Array, sides: tuple[str, ...], stop: dict[str, float]) -> None:
        """Follow the gradient from a point."""
        from scipy.optimize import minimize

        unit = max(self._base_value, 1e-12)
        scale = self.scale[:, self._free]

        def placed(flat: Array) -> Array:
            current = point.copy()
            current[:, self._free] = np.clip(flat.reshape(scale.shape) / scale, *bounds)
            return current

        def evaluate(flat: Array) -> tuple[float, Array]:
            current = placed(flat)
            value, gradient = self.objective.value_and_gradient(self.curve(current, sides))
            self._tally.count(value)
            # in units of the start's value, so that tolerances mean the same for metres and radians
            return value / unit, (by_coordinates(gradient, current)[:, self._free] / scale).ravel() / unit

        bounds = np.transpose([BOUNDS[column] for column in self._free])
        options: Any = {"maxcor": 20, "gtol": 1e-7, "maxls": 4, **stop}
        result = minimize(
            evaluate,
            (point[:, self._free] * scale).ravel(),
            jac=True,
            method="L-BFGS-B",
            bounds=np.stack([(bound * scale).ravel() for bound in bounds], axis=-1),
            options=options,
        )
        # a descent follows geodesics that may cease to be the shortest, in some joints
        self.offer_by_joint(placed(result.x), sides)

    def try_other_sides(self, points: dict[str, Array]) -> None:
        """Turn single joints to the other side, root to leaf, where that helps."""
        for joint in range(self.n_joints):
            other = "right" if self.best_sides[joint] == "left" else "left"
            point = self.best_point.copy()
            point[joint] = points[other][joint]
            sides = (*self.best_sides[:joint], other, *self.best_sides[joint + 1 :])
            self.offer(point, sides)

    def tilt(self, n_trials: int, n_starts: int, rounds: int) -> None:
        """Go on from the best so far with free axes, and from the best of several sets of tilted matrices."""
        point, sides = self.best_point, self.best_sides
        random = np.random.default_rng(0)
        moments = random.uniform(-_TILTED_MOMENTS, _TILTED_MOMENTS, (n_trials, 2))
        trials = np.concatenate([moments, random.normal(0.0, 1.5, (n_trials, 3))], axis=1)
        starts = [self._best_tilted(point, sides, some) for some in np.array_split(trials, n_starts)]
        for start, start_sides in [(point, sides), *starts]:
            self.offer_by_joint(self.refine(start, start_sides, rounds), start_sides)

    def _best_tilted(
        self, diagonal: Array, diagonal_sides: tuple[str, ...], trials: Array
    ) -> tuple[Array, tuple[str, ...]]:
        """Choose the trial, shape=[n, 5], that is best for each joint's own rotation error, and its side."""
        point, chosen, least = diagonal.copy(), list(diagonal_sides), np.full(self.n_joints, -np.inf)
        least[self._turning] = np.inf  # the others keep what they have
        for number, trial in enumerate(trials):
            side = self._sides[number % len(self._sides)]
            trial_sides = diagonal_sides if self._one_side else (side,) * self.n_joints
            trial_point = diagonal.copy()
            trial_point[:, [*_MOMENTS, *_AXES]] = trial
            trial_errors = self._rotation_errors(trial_point, trial_sides)
            better = np.flatnonzero(trial_errors < least)
            point[better], least[better] = trial_point[better], trial_errors[better]
            for joint in better:
                chosen[joint] = trial_sides[joint]
        return point, tuple(chosen)

    def _rotation_errors(self, point: Array, sides: tuple[str, ...]) -> Array:
        """Return the rotation errors of the joints that turn, shape=[B], and those at the start of the others."""
        curve = self.curve(point[self._turning], [sides[joint] for joint in self._turning])
        errors = self._base_errors.copy()
        errors[self._turning] = self.objective.rotation_errors_by_joint(curve, self._turning)
        self._tally.count()
        return errors


def by_coordinates(gradient: Array, point: Array) -> Array:
    """Derive by the axes' rotation vector instead of by a turn from the left."""
    by_vector = np.einsum("bij,bi->bj", left_jacobian(point[:, _AXES]), gradient[:, _AXES])
    return np.concatenate([gradient[:, _MOMENTS], by_vector, gradient[:, TENSIONS]], axis=1)


def free_columns(family: str, scheme: str) -> list[int]:
    """Return the columns of a point that a family and a scheme leave free."""
    axes = _AXES if family == "spd" else []
    return [*_MOMENTS, *axes, *(TENSIONS if scheme == "geodesic-spline" else [])]
