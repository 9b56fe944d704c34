"""What the metrics on SO(3) and SO(3)^B share: arrays in and out, the inner product, and what follows from geodesics.

It is one mathematics on arrays of shape [..., B, 3, 3], with B = 1 for SO(3): one compiled call for all elements of a
batch and all bones. Numbers are float64 inside; arrays of other backends are converted at the boundary, so that
they cannot differentiate what is here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import geomstats.backend as gs
import numpy as np
from geomstats.errors import check_integer
from geomstats.geometry.riemannian_metric import RiemannianMetric
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.solvers import GeodesicExpSolver, GeodesicLogSolver
from geomstats_anim.rotations import Array


class CompiledMetric(RiemannianMetric):
    """Invariant metric on SO(3)^B, or on SO(3) with points that have no axis of bones.

    A subclass sets what is below, and calls `_instantiate_solvers`.

    Attributes
    ----------
    parameters : MetricParameters
    """

    parameters: MetricParameters
    _matrices: Array
    """Matrices at the identity, shape=[B, 3, 3]."""
    _scale: Array
    """What multiples of the matrices of the parameters they are, shape=[B]."""

    def _instantiate_solvers(self) -> None:
        self.exp_solver = GeodesicExpSolver(self)
        self.log_solver = GeodesicLogSolver(self)

    def _read_points(self, point: Any, name: str) -> Array:
        """Rotation matrices, shape=[..., B, 3, 3]."""
        if point is None:
            return np.broadcast_to(np.eye(3), self._matrices.shape)
        matrix = mat.read_rotations(point, self._space.shape, name)
        return matrix.reshape(*matrix.shape[: -self._space.point_ndim], *self._matrices.shape)

    def _read_velocity(self, tangent_vec: Any, base: Array, name: str) -> Array:
        """Velocities, shape=[..., B, 3], in the frame where the metric is constant."""
        vector = mat.read(tangent_vec, self._space.shape, name)
        vector = vector.reshape(*vector.shape[: -self._space.point_ndim], *self._matrices.shape)
        velocity = mat.body_velocity(vector, base)
        if not self.parameters.is_right.any():
            return velocity
        return np.where(self.parameters.is_right[:, None], _apply(base, velocity), velocity)

    def _tangent_vec(self, velocity: Array, base: Array) -> Array:
        """Tangent vectors, shape=[..., B, 3, 3], of velocities as `_read_velocity` gives them."""
        if self.parameters.is_right.any():
            body = _apply(np.swapaxes(base, -1, -2), velocity)
            velocity = np.where(self.parameters.is_right[:, None], body, velocity)
        return base @ mat.hat(velocity)

    def _write(self, values: np.ndarray, shape: tuple[int, ...]) -> Any:
        """Hand an array to the backend."""
        return gs.from_numpy(values.reshape(shape))

    def _path(self, geodesics: PoseGeodesics, batch: tuple[int, ...]) -> Callable[[Any], Any]:
        """Make the function of time of a batch of geodesics."""
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
            return self._write(quat.to_matrix(points), (*batch, len(times), *self._space.shape))

        return path

    def inner_product(self, tangent_vec_a: Any, tangent_vec_b: Any, base_point: Any = None) -> Any:
        """Compute the inner product of two tangent vectors at a base point.

        As Geomstats' own, it is 2 a^T Z b on the axis vectors of the tangent vectors, summed over the bones.

        Parameters
        ----------
        tangent_vec_a : array-like, shape=[..., *space.shape]
            First tangent vector at base_point; what of it is not tangent is projected away.
        tangent_vec_b : array-like, shape=[..., *space.shape]
            Second tangent vector at base_point; what of it is not tangent is projected away.
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        inner_product : array-like, shape=[...]
        """
        base = self._read_points(base_point, "base_point")
        velocity_a = self._read_velocity(tangent_vec_a, base, "tangent_vec_a")
        velocity_b = self._read_velocity(tangent_vec_b, base, "tangent_vec_b")
        product = 2.0 * np.einsum("...bi,...bi->...", velocity_a, _apply(self._matrices, velocity_b))
        return self._write(product, product.shape)

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Compute the Riemannian exponential of a tangent vector at a base point.

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
        return self.exp_solver.exp(tangent_vec, base_point)

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Compute the Riemannian logarithm of a point from a base point: the shortest found.

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
            If no geodesic was found for an element; `log_solver.solve` returns every status instead.
        """
        return self.log_solver.log(point, base_point)

    def parallel_transport(
        self,
        tangent_vec: Any,
        base_point: Any,
        direction: Any = None,
        end_point: Any = None,
        n_steps: int = 100,
        return_endpoint: bool = False,
    ) -> Any:
        """Transport a tangent vector along a geodesic.

        In an orthonormal invariant frame the transport is a rotation, with the velocity of the geodesic times rates
        that are constant along it (Milnor, "Curvatures of left invariant metrics on Lie groups", 1976, section 4).
        Steps of Magnus' method of fourth order integrate it, so that it keeps inner products exactly.

        Parameters
        ----------
        tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at base point to be transported.
        base_point : array-like, shape=[..., *space.shape]
        direction : array-like, shape=[..., *space.shape]
            Tangent vector at base point, along which to transport.
            Optional, default: the logarithm of `end_point`.
        end_point : array-like, shape=[..., *space.shape]
            Point to transport to.
            Optional, unused if there is a direction.
        n_steps : int
            Optional, default: 100.
        return_endpoint : bool
            Whether to return the end point of the geodesic too.
            Optional, default: False.

        Returns
        -------
        transported_tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at the end of the geodesic.
        end_point : array-like, shape=[..., *space.shape]
            Only if `return_endpoint` is True.
        """
        check_integer(n_steps, "n_steps")
        if direction is None:
            if end_point is None:
                raise ValueError("Give a direction or an end_point to transport along.")
            direction = self.log(end_point, base_point)
        base = self._read_points(base_point, "base_point")
        velocity = self._read_velocity(direction, base, "direction")
        vector = self._read_velocity(tangent_vec, base, "tangent_vec")
        shape = np.broadcast_shapes(velocity.shape, vector.shape)
        velocity, vector = np.broadcast_to(velocity, shape), np.broadcast_to(vector, shape)
        batch, n_joints, is_right = velocity.shape[:-2], velocity.shape[-2], self.parameters.is_right[:, None]
        n = math.prod(batch)

        # the geodesics from the identity, at the two Gauss nodes of each step, and at their end
        gauss = 0.5 + np.array([-1.0, 1.0]) * np.sqrt(3.0) / 6.0
        times = np.append((np.arange(n_steps)[:, None] + gauss) / n_steps, 1.0)
        initial = np.broadcast_to(quat.IDENTITY, (n, n_joints, 4))
        geodesics = PoseGeodesics(initial, velocity.reshape(n, n_joints, 3), self.parameters)
        turned = geodesics(np.repeat(np.arange(n), len(times)), np.tile(times, n))
        turned = turned.reshape(n, len(times), n_joints, 4)

        # the momentum is constant in space if the metric is left-invariant, and in the body if it is right-invariant
        axes, moments = self.parameters.axes_quaternions, self.parameters.moments
        momentum = _apply(self.parameters.matrices, geodesics.velocity)
        towards = np.where(is_right, turned[:, :-1], quat.conjugate(turned[:, :-1]))
        principal = quat.rotate(axes, quat.rotate(towards, momentum[:, None])) / moments
        sums = 0.5 * moments.sum(axis=-1, keepdims=True) - moments
        rates = sums * np.sqrt(moments / moments.prod(axis=-1, keepdims=True))
        spin = np.where(is_right, rates, -rates) * principal / n_steps
        early, late = spin[:, ::2], spin[:, 1::2]
        steps = quat.exp(0.5 * (early + late) + np.sqrt(3.0) / 12.0 * np.cross(late, early))
        frame = initial
        for step in np.moveaxis(steps, 1, 0):
            frame = quat.multiply(step, frame)

        orthonormal = np.sqrt(moments) * quat.rotate(axes, vector.reshape(n, n_joints, 3))
        transported = quat.rotate(quat.conjugate(axes), quat.rotate(frame, orthonormal) / np.sqrt(moments))
        turn = quat.to_matrix(turned[:, -1]).reshape(*batch, n_joints, 3, 3)
        end = np.where(is_right[..., None], turn @ base, base @ turn)
        shape = batch + self._space.shape
        result = self._write(self._tangent_vec(transported.reshape(*batch, n_joints, 3), end), shape)
        return (result, self._write(end, shape)) if return_endpoint else result

    def normal_basis(self, basis: Any, base_point: Any = None) -> Any:
        """Make a basis of a tangent space orthonormal, one vector after the other (Gram and Schmidt).

        Geomstats only scales the vectors, which is not enough unless they are orthogonal already.

        Parameters
        ----------
        basis : array-like, shape=[dim, *space.shape]
            Linearly independent.
        base_point : array-like, shape=[*space.shape]
            Optional, default: identity.

        Returns
        -------
        basis : array-like, shape=[dim, *space.shape]
        """
        vectors = np.asarray(basis, dtype=np.float64)
        gram = np.asarray(self.inner_product(vectors[:, None], vectors[None, :], base_point))
        try:
            factor = np.linalg.cholesky(gram)
        except np.linalg.LinAlgError:
            raise ValueError("basis must be linearly independent.") from None
        normal = np.linalg.solve(factor, vectors.reshape(len(vectors), -1))
        return self._write(normal, vectors.shape)

    def random_unit_tangent_vec(self, base_point: Any = None, n_vectors: int = 1) -> Any:
        """Generate random unit tangent vectors at a point.

        Parameters
        ----------
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.
        n_vectors : int
            More than 1 only for a single base point.
            Optional, default: 1.

        Returns
        -------
        tangent_vec : array-like, shape=[..., *space.shape]
        """
        return self.normalize(self._space.random_tangent_vec(base_point, n_vectors), base_point)


def _apply(matrix: Array, vector: Array) -> Array:
    """Multiply matrices, shape=[..., 3, 3], and vectors, shape=[..., 3]."""
    return (matrix @ vector[..., None])[..., 0]
