"""Compiled solvers for geodesics, behind Geomstats' own interfaces for exponential and logarithm."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from geomstats.numerics.geodesic import ExpSolver, LogSolver

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import LogResult, LogStatus, PoseGeodesics
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.rotations import Array

if TYPE_CHECKING:
    from geomstats_anim.riemannian.compiled_metric import CompiledMetric

_NAMED_FAILURES = 5
"""How many elements the error of a logarithm names."""


class GeodesicExpSolver(ExpSolver):
    """Exponential by the compiled flow of the free rigid body.

    Parameters
    ----------
    metric : CompiledMetric
    """

    def __init__(self, metric: CompiledMetric) -> None:
        super().__init__(solves_ivp=True)
        self._metric = metric

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Follow geodesics for the unit of time.

        Parameters
        ----------
        tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at the base point; what of it is not tangent is projected away.
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        end_point : array-like, shape=[..., *space.shape]
        """
        geodesics, batch = self._leave(tangent_vec, base_point, "base_point", "tangent_vec")
        n = len(geodesics.initial)
        end = quat.to_matrix(geodesics(np.arange(n), np.ones(n)))
        return self._metric._write(end, batch + self._metric._space.shape)

    def geodesic_ivp(self, tangent_vec: Any, base_point: Any) -> Callable[[Any], Any]:
        """Make geodesics that leave points with given velocities.

        Parameters
        ----------
        tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at the base point; what of it is not tangent is projected away.
        base_point : array-like, shape=[..., *space.shape]

        Returns
        -------
        path : callable
            Takes times, shape=[n_times] or [], and returns points, shape=[..., n_times, *space.shape].
        """
        return self._metric._path(*self._leave(tangent_vec, base_point, "initial_point", "initial_tangent_vec"))

    def _leave(
        self, tangent_vec: Any, base_point: Any, point_name: str, vec_name: str
    ) -> tuple[PoseGeodesics, tuple[int, ...]]:
        """Make geodesics, and tell the shape of the batch."""
        metric = self._metric
        base = metric._read_points(base_point, point_name)
        velocity = metric._read_velocity(tangent_vec, base, vec_name)
        batch = velocity.shape[:-2]
        initial = np.broadcast_to(quat.from_matrix(base), (*velocity.shape[:-1], 4))
        shape = (math.prod(batch), metric.parameters.n_joints)
        geodesics = PoseGeodesics(initial.reshape(*shape, 4), velocity.reshape(*shape, 3), metric.parameters)
        return geodesics, batch


class GeodesicLogSolver(LogSolver):
    """Logarithm by the compiled boundary value solver: the shortest geodesic that it finds, with its status.

    Parameters
    ----------
    metric : CompiledMetric
    """

    def __init__(self, metric: CompiledMetric) -> None:
        super().__init__(solves_bvp=True)
        self._metric = metric

    def solve(self, point: Any, base_point: Any = None) -> LogResult:
        """Find logarithms, and tell how each search ended.

        Parameters
        ----------
        point : array-like, shape=[..., *space.shape]
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        result : LogResult
            Its status, residual, length and iterations have shape [...] on SO(3), and [..., B], one a bone, on
            SO(3)^B. The length is in the norm of the metric.
        """
        metric = self._metric
        base = metric._read_points(base_point, "base_point")
        end = metric._read_points(point, "point")
        geodesics, batch = self._join(base, end)
        found = (geodesics.status == LogStatus.CONVERGED)[..., None]
        velocity = np.where(found, geodesics.velocity, 0.0).reshape(*batch, metric.parameters.n_joints, 3)
        per_bone = batch + metric._space.shape[:-2]
        length = np.sqrt(2.0 * metric._scale) * geodesics.length
        return LogResult(
            metric._write(metric._tangent_vec(velocity, base), batch + metric._space.shape),
            metric._write(geodesics.status, per_bone),
            metric._write(geodesics.residual, per_bone),
            metric._write(length, per_bone),
            metric._write(geodesics.iterations, per_bone),
        )

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Find logarithms, or raise.

        Parameters
        ----------
        point : array-like, shape=[..., *space.shape]
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at the base point.

        Raises
        ------
        RuntimeError
            If no geodesic was found for an element; `solve` returns the others.
        """
        result = self.solve(point, base_point)
        _raise_failures(np.asarray(result.status))
        return result.tangent_vec

    def geodesic_bvp(self, point: Any, base_point: Any) -> Callable[[Any], Any]:
        """Make geodesics that join points.

        Parameters
        ----------
        point : array-like, shape=[..., *space.shape]
            Reached at time 1.
        base_point : array-like, shape=[..., *space.shape]
            Left at time 0.

        Returns
        -------
        path : callable
            Takes times, shape=[n_times] or [], and returns points, shape=[..., n_times, *space.shape].

        Raises
        ------
        RuntimeError
            If no geodesic was found for an element.
        """
        metric = self._metric
        base = metric._read_points(base_point, "initial_point")
        geodesics, batch = self._join(base, metric._read_points(point, "end_point"))
        _raise_failures(geodesics.status.reshape(batch + metric._space.shape[:-2]))
        return metric._path(geodesics, batch)

    def _join(self, base: Array, end: Array) -> tuple[PoseGeodesics, tuple[int, ...]]:
        """Find geodesics, and tell the shape of the batch."""
        shape = np.broadcast_shapes(base.shape, end.shape)
        batch, n_joints = shape[:-3], shape[-3]

        def flat(matrices: Array) -> Array:
            quaternions = np.broadcast_to(quat.from_matrix(matrices), (*shape[:-2], 4))
            return quaternions.reshape(math.prod(batch), n_joints, 4)

        return PoseGeodesics.between(flat(base), flat(end), self._metric.parameters), batch


def _raise_failures(status: np.ndarray) -> None:
    """Name the elements without a geodesic, and say what to do."""
    failures = np.argwhere(status != LogStatus.CONVERGED)
    if not len(failures):
        return
    names = ", ".join(mat.at("", tuple(index)) for index in failures[:_NAMED_FAILURES]) if status.ndim else "the pair"
    more = f" and {len(failures) - _NAMED_FAILURES} more" if len(failures) > _NAMED_FAILURES else ""
    sentences = " ".join(LogStatus(code).sentence for code in np.unique(status) if code != LogStatus.CONVERGED)
    raise RuntimeError(f"The logarithm failed for {names}{more}. {sentences} log_solver.solve returns every status.")
