"""Base of the metrics on SO(3) and SO(3)^B: the inner product, and what follows from geodesics.

It is one mathematics on arrays of shape [..., B, 3, 3], with B = 1 for SO(3): one compiled call for all elements of a
batch and all bones. Numbers are float64 inside; arrays of other backends are converted at the boundary, and where they
are differentiated the exact derivatives are known; see `differentiation`.
"""

from __future__ import annotations

from typing import Any

import geomstats.backend as gs
import numpy as np
from geomstats.errors import check_integer

from geomstats_anim import rotations as quat
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.differentiation import Differentiable, followed
from geomstats_anim.riemannian.matrices import PoseMatrices
from geomstats_anim.riemannian.solvers import GeodesicExpSolver, GeodesicLogSolver
from geomstats_anim.riemannian.tensors import TensorMetric
from geomstats_anim.riemannian.transport import transport
from geomstats_anim.rotations import Array


class CompiledMetric(TensorMetric):
    """Invariant metric on SO(3)^B, or on SO(3) with points that have no axis of bones.

    A subclass sets what is below, and calls `_instantiate_solvers`.

    Attributes
    ----------
    parameters : MetricParameters
    """

    def _instantiate_solvers(self) -> None:
        self._arrays = PoseMatrices(self._space.shape, self.parameters)
        self._differentiable = Differentiable(
            self.parameters, self._matrices, self._scale, has_joints=len(self._space.shape) > 2
        )
        self.exp_solver = GeodesicExpSolver(self._arrays, self.parameters, self._differentiable)
        self.log_solver = GeodesicLogSolver(self._arrays, self.parameters, self._scale, self._differentiable)

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
        if followed(tangent_vec_a, tangent_vec_b, base_point):
            return self._differentiable.inner_product(tangent_vec_a, tangent_vec_b, base_point)
        base = self._arrays.read_points(base_point, "base_point")
        velocity_a = self._arrays.read_velocities(tangent_vec_a, base, "tangent_vec_a")
        velocity_b = self._arrays.read_velocities(tangent_vec_b, base, "tangent_vec_b")
        product = self._product(velocity_a, velocity_b)
        return self._arrays.write(product, product.shape)

    def coordinates(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """See tangent vectors in the orthonormal frame of the metric, in which inner products are sums of products.

        The frame is along the principal axes of each bone, and moved around by the translations that are isometries.

        Parameters
        ----------
        tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at base_point; what of it is not tangent is projected away.
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        coordinates : array-like, shape=[..., dim]
        """
        base = self._arrays.read_points(base_point, "base_point")
        velocity = self._arrays.read_velocities(tangent_vec, base, "tangent_vec")
        values = self._roots * self.parameters.along_axes(velocity)
        return self._arrays.write(values, (*values.shape[:-2], self._space.dim))

    def from_coordinates(self, coordinates: Any, base_point: Any = None) -> Any:
        """Undo `coordinates`.

        Parameters
        ----------
        coordinates : array-like, shape=[..., dim]
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        tangent_vec : array-like, shape=[..., *space.shape]
            Tangent vector at base_point.
        """
        base = self._arrays.read_points(base_point, "base_point")
        values = mat.read(coordinates, (self._space.dim,), "coordinates")
        values = values.reshape(*values.shape[:-1], self.parameters.n_joints, 3)
        batch = np.broadcast_shapes(values.shape[:-2], base.shape[:-2])
        velocity = self.parameters.from_axes(values / self._roots)
        return self._arrays.write_tangent_vecs(mat.flat(velocity, batch, 2), mat.flat(base, batch, 2), batch)

    @property
    def _roots(self) -> Array:
        """Return the lengths of the principal axes' unit velocities, shape=[B, 3]."""
        return np.sqrt(2.0 * self._scale[:, None] * self.parameters.moments)

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

    def squared_dist(self, point_a: Any, point_b: Any) -> Any:
        """Compute the squared distance of points, shape=[...]; it is differentiable at 0, as the distance is not."""
        if followed(point_a, point_b):
            return self._differentiable.squared_dist(point_a, point_b)
        return super().squared_dist(point_a, point_b)

    def dist_pairwise(self, points: Any, n_jobs: int = 1, **joblib_kwargs: Any) -> Any:
        """Compute the distances between all pairs of points, in one call.

        Parameters
        ----------
        points : array-like, shape=[n_samples, *space.shape]
        n_jobs : int
            Ignored, as are the arguments of joblib: the call is compiled, and takes threads by itself.
            Optional, default: 1.

        Returns
        -------
        dist : array-like, shape=[n_samples, n_samples]
        """
        rows, columns = np.triu_indices(len(points), k=1)
        dist = np.zeros((len(points), len(points)))
        dist[rows, columns] = dist[columns, rows] = gs.to_numpy(self.dist(points[rows], points[columns]))
        return self._arrays.write(dist, dist.shape)

    def parallel_transport(
        self,
        tangent_vec: Any,
        base_point: Any,
        direction: Any = None,
        end_point: Any = None,
        n_steps: int = 100,
        return_endpoint: bool = False,
    ) -> Any:
        """Transport a tangent vector along a geodesic; see `transport` for the method.

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
        base = self._arrays.read_points(base_point, "base_point")
        velocity = self._arrays.read_velocities(direction, base, "direction")
        vector = self._arrays.read_velocities(tangent_vec, base, "tangent_vec")
        batch = np.broadcast_shapes(velocity.shape, vector.shape)[:-2]
        turn, transported = transport(
            self.parameters, mat.flat(velocity, batch, 2), mat.flat(vector, batch, 2), n_steps
        )
        base, is_right = mat.flat(base, batch, 2), self.parameters.is_right[:, None]
        end = np.where(is_right, quat.multiply(turn, base), quat.multiply(base, turn))
        result = self._arrays.write_tangent_vecs(transported, end, batch)
        return (result, self._arrays.write_points(end, batch)) if return_endpoint else result

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
        return self._arrays.write(normal, vectors.shape)

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
