"""Compiled solvers for geodesics, behind Geomstats' own interfaces for exponential and logarithm."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geomstats.numerics.geodesic import ExpSolver, LogSolver
from numpy.typing import ArrayLike

from geomstats_anim.geodesics.pose_geodesics import LogResult, PoseGeodesics
from geomstats_anim.kernels.shooting import CONVERGED
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.differentiation import Differentiable, followed
from geomstats_anim.riemannian.failures import raise_failures
from geomstats_anim.riemannian.matrices import PoseMatrices
from geomstats_anim.rotations import Array


class GeodesicExpSolver(ExpSolver):
    """Exponential by the compiled flow of the free rigid body.

    Parameters
    ----------
    arrays : PoseMatrices
    parameters : MetricParameters
    differentiable : Differentiable
        Answers for arrays that are differentiated.
    """

    def __init__(self, arrays: PoseMatrices, parameters: MetricParameters, differentiable: Differentiable) -> None:
        super().__init__(solves_ivp=True)
        self._arrays, self._parameters, self._differentiable = arrays, parameters, differentiable

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
        if followed(tangent_vec, base_point):
            return self._differentiable.exp(tangent_vec, base_point)
        geodesics, batch = self._leave(tangent_vec, base_point, "base_point", "tangent_vec")
        n = len(geodesics.initial)
        return self._arrays.write_points(geodesics(np.arange(n), np.ones(n)), batch)

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
        if followed(tangent_vec, base_point):
            return self._differentiable.path(tangent_vec, base_point)
        geodesics, batch = self._leave(tangent_vec, base_point, "initial_point", "initial_tangent_vec")
        return _path(self._arrays, geodesics, batch)

    def _leave(
        self, tangent_vec: Any, base_point: Any, point_name: str, vec_name: str
    ) -> tuple[PoseGeodesics, tuple[int, ...]]:
        """Make geodesics, and return the shape of the batch too."""
        base = self._arrays.read_points(base_point, point_name)
        velocity = self._arrays.read_velocities(tangent_vec, base, vec_name)
        batch = velocity.shape[:-2]
        return PoseGeodesics(mat.flat(base, batch, 2), mat.flat(velocity, batch, 2), self._parameters), batch


class GeodesicLogSolver(LogSolver):
    """Logarithm by the compiled boundary value solver: the shortest geodesic that it finds, with its status.

    Parameters
    ----------
    arrays : PoseMatrices
    parameters : MetricParameters
    scale : array-like, shape=[B]
        Multiples of the matrices of the parameters that those of the metric are.
    differentiable : Differentiable
        Answers for arrays that are differentiated.
    """

    def __init__(
        self, arrays: PoseMatrices, parameters: MetricParameters, scale: Array, differentiable: Differentiable
    ) -> None:
        super().__init__(solves_bvp=True)
        self._arrays, self._parameters, self._scale = arrays, parameters, scale
        self._differentiable = differentiable

    def solve(self, point: Any, base_point: Any = None) -> LogResult:
        """Find logarithms, and return how each search ended.

        Parameters
        ----------
        point : array-like, shape=[..., *space.shape]
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        result : LogResult
            Its status, residual, length and iterations have shape [...] on SO(3), and [..., B], one per bone, on
            SO(3)^B. The length is in the norm of the metric.
        """
        geodesics, batch = self._join(point, base_point, "point", "base_point")
        found = (geodesics.status == CONVERGED)[..., None]
        velocity = np.where(found, geodesics.velocity, 0.0)
        length = np.sqrt(2.0 * self._scale) * geodesics.length
        per_joint = batch + self._arrays.per_joint
        values = geodesics.status, geodesics.residual, length, geodesics.iterations
        return LogResult(
            self._arrays.write_tangent_vecs(velocity, geodesics.initial, batch),
            *(self._arrays.write(value, per_joint) for value in values),
        )

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Find logarithms.

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
        if followed(point, base_point):
            return self._differentiable.log(point, base_point)
        geodesics, batch = self._join(point, base_point, "point", "base_point")
        raise_failures(geodesics.status, batch + self._arrays.per_joint)
        return self._arrays.write_tangent_vecs(geodesics.velocity, geodesics.initial, batch)

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
        if followed(point, base_point):
            return self._differentiable.path(self._differentiable.log(point, base_point), base_point)
        geodesics, batch = self._join(point, base_point, "end_point", "initial_point")
        raise_failures(geodesics.status, batch + self._arrays.per_joint)
        return _path(self._arrays, geodesics, batch)

    def _join(
        self, point: Any, base_point: Any, point_name: str, base_name: str
    ) -> tuple[PoseGeodesics, tuple[int, ...]]:
        """Find geodesics, and return the shape of the batch too."""
        base = self._arrays.read_points(base_point, base_name)
        end = self._arrays.read_points(point, point_name)
        batch = np.broadcast_shapes(base.shape, end.shape)[:-2]
        return PoseGeodesics.between(mat.flat(base, batch, 2), mat.flat(end, batch, 2), self._parameters), batch


def _path(arrays: PoseMatrices, geodesics: PoseGeodesics, batch: tuple[int, ...]) -> Callable[[Any], Any]:
    """Return the function of time of a batch of geodesics."""
    backward = PoseGeodesics(geodesics.initial, -geodesics.velocity, geodesics.parameters)
    n, n_joints = geodesics.initial.shape[:2]

    def path(t: ArrayLike) -> Any:
        """Evaluate the geodesics.

        Parameters
        ----------
        t : float or array-like, shape=[n_times]
            Any times: 0 at the initial point, 1 at the end point.

        Returns
        -------
        points : array-like, shape=[..., n_times, *space.shape]
        """
        times = np.atleast_1d(mat.read(t, (), "t"))
        if times.ndim > 1:
            raise ValueError(f"t has shape {times.shape}, but (n_times,) is needed.")
        points = np.empty((n, len(times), n_joints, 4))
        for ahead, column in ((geodesics, times >= 0.0), (backward, times < 0.0)):
            order = np.flatnonzero(column)[np.argsort(np.abs(times[column]), kind="stable")]
            index, parameter = np.repeat(np.arange(n), len(order)), np.tile(np.abs(times[order]), n)
            points[:, order] = ahead(index, parameter).reshape(n, len(order), n_joints, 4)
        return arrays.write_points(points, (*batch, len(times)))

    return path
