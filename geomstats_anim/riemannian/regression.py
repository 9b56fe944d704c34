"""Regression along a geodesic, by Levenberg's and Marquardt's method with exact Jacobians, for each joint by itself."""

from __future__ import annotations

import warnings
from typing import Any

import geomstats.backend as gs
import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.exceptions import ConvergenceWarning

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian.estimators import mean_estimator, variance_score
from geomstats_anim.rotations import Array

_MAX_STEPS = 200
_NO_STEP = 1e-11
"""Largest step, in radians, after which the search has ended."""

_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-3, 1e-12, 1e12


class GeodesicRegression(RegressorMixin, BaseEstimator):
    """The geodesic exp(x coef, intercept) that is nearest to poses y in the sum of squared distances.

    Geomstats' own finds it by differences of its loss, or by gradients that its NumPy backend does not have.

    Parameters
    ----------
    space : PoseSpace or SpecialOrthogonal
        Equipped with a metric of this package.
    center_X : bool
        Whether the intercept is at the mean of X, and not at 0.
        Optional, default: True.

    Attributes
    ----------
    intercept_ : array-like, shape=[*space.shape]
    coef_ : array-like, shape=[*space.shape]
        Tangent vector at the intercept.
    mean_ : float
        Of X; 0 if it is not centered.
    """

    def __init__(self, space: Any, center_X: bool = True) -> None:
        self.space, self.center_X = space, center_X

    def fit(self, X: Any, y: Any, weights: Any = None) -> GeodesicRegression:
        """Find the geodesic.

        Parameters
        ----------
        X : array-like, shape=[n_samples]
        y : array-like, shape=[n_samples, *space.shape]
        weights : array-like, shape=[n_samples]
            Optional, default: None, all the same.

        Returns
        -------
        self : GeodesicRegression

        Warns
        -----
        ConvergenceWarning
            If the search of a joint has not ended.
        """
        metric = self.space.metric
        times = np.asarray(gs.to_numpy(X), dtype=np.float64)
        share = np.ones(len(times)) if weights is None else np.asarray(gs.to_numpy(weights), dtype=np.float64)
        self.mean_ = float(times.mean()) if self.center_X else 0.0
        times = times - self.mean_
        mean = mean_estimator(self.space).fit(y, weights=gs.from_numpy(share)).estimate_
        logs = gs.to_numpy(metric.coordinates(metric.log(y, mean), mean))
        design = np.stack([np.ones_like(times), times], axis=-1)
        (offset, slope), *_ = np.linalg.lstsq(np.sqrt(share)[:, None] * design, np.sqrt(share)[:, None] * logs)
        start = metric.exp(metric.from_coordinates(gs.from_numpy(offset), mean), mean)
        slope = metric.from_coordinates(gs.from_numpy(slope), start)

        arrays = metric._arrays
        base = arrays.read_points(start, "start")
        fit = _Fit(arrays.read_points(y, "y"), times, share, metric.parameters)
        base, velocity, has_ended = fit.search(base, arrays.read_velocities(slope, base, "slope"))
        if not has_ended.all():
            warnings.warn(
                f"The regression of joint {np.flatnonzero(~has_ended)[0]} has not converged.",
                ConvergenceWarning,
                stacklevel=2,
            )
        self.intercept_ = arrays.write_points(base[None], ())
        self.coef_ = arrays.write_tangent_vecs(velocity[None], base[None], ())
        return self

    def predict(self, X: Any) -> Any:
        """Return the poses, shape=[n_samples, *space.shape], at X, shape=[n_samples]."""
        return self.space.metric.geodesic(self.intercept_, initial_tangent_vec=self.coef_)(X - self.mean_)

    def score(self, X: Any, y: Any, sample_weight: Any = None) -> float:
        """Return the share of the variance of y, shape=[n_samples, *space.shape], that is predicted."""
        return variance_score(self.space, y, self.predict(X), sample_weight)


class _Fit:
    """Least squares of all joints at once; their geodesics do not depend on one another."""

    def __init__(self, targets: Array, times: Array, share: Array, parameters: MetricParameters) -> None:
        self._targets, self._times, self._share, self._parameters = targets, times, share, parameters
        self._index = np.arange(len(times))

    def search(self, base: Array, velocity: Array) -> tuple[Array, Array, np.ndarray]:
        """Return the best base points, shape=[B, 4], and velocities, shape=[B, 3], and which searches have ended."""
        n_joints = len(base)
        damping = np.full(n_joints, _FIRST_DAMPING)
        loss, normal, slope = self._look(base, velocity)
        for _ in range(_MAX_STEPS):
            damped = normal + damping[:, None, None] * (normal * np.eye(6))
            step = np.asarray(np.linalg.solve(damped + 1e-300 * np.eye(6), slope[..., None])[..., 0], dtype=np.float64)
            trial_base = self._turned(base, step[:, :3])
            trial_velocity = velocity + step[:, 3:]
            trial = self._look(trial_base, trial_velocity)
            is_better = trial[0] <= loss
            base, velocity = (
                np.where(is_better[:, None], new, old) for new, old in ((trial_base, base), (trial_velocity, velocity))
            )
            loss = np.where(is_better, trial[0], loss)
            normal = np.where(is_better[:, None, None], trial[1], normal)
            slope = np.where(is_better[:, None], trial[2], slope)
            damping = np.clip(np.where(is_better, 0.1 * damping, 10.0 * damping), _LEAST_DAMPING, _MOST_DAMPING)
            has_ended = np.abs(step).max(axis=-1) < _NO_STEP
            if has_ended.all():
                break
        return base, velocity, has_ended

    def _look(self, base: Array, velocity: Array) -> tuple[Array, Array, Array]:
        """Return the loss of each joint, Gauss' normal matrices, shape=[B, 6, 6], and downhill slopes, shape=[B, 6]."""
        n = len(self._times)
        geodesics = PoseGeodesics(np.tile(base, (n, 1, 1)), self._times[:, None, None] * velocity, self._parameters)
        ones = np.ones(n)
        by = geodesics.variations(self._index, ones)
        miss = PoseGeodesics.between(geodesics(self._index, ones), self._targets, self._parameters)
        jacobian = np.concatenate([by.by_initial, self._times[:, None, None, None] * by.by_velocity], axis=-1)
        weighted = self._share[:, None, None, None] * (np.moveaxis(jacobian, -1, -2) @ self._parameters.matrices)
        loss = (self._share[:, None] * miss.length**2).sum(axis=0)
        slope = (weighted @ miss.velocity[..., None])[..., 0].sum(axis=0)
        return loss, (weighted @ jacobian).sum(axis=0), slope

    def _turned(self, base: Array, vector: Array) -> Array:
        turn = quat.exp(vector)
        left, right = quat.multiply(turn, base), quat.multiply(base, turn)
        return np.where(self._parameters.is_right[:, None], left, right)
