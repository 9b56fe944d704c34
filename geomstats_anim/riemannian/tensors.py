"""Tensors and fields of the metrics: curvature, Christoffel symbols in a chart, Jacobi fields.

The chart is that of rotation vectors, one for each bone, in the order of the bones; it is singular at a full turn only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geomstats.geometry.riemannian_metric import RiemannianMetric
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.exponential import exponential_rates, left_jacobian
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.geodesics.shortest import injectivity_radius
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian import levi_civita
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.matrices import PoseMatrices
from geomstats_anim.rotations import Array

_NO_PLANE = 1e-14
"""Squared area, relative to the product of squared lengths, of two vectors that span no plane."""


class TensorMetric(RiemannianMetric):
    """Tensors that Geomstats does not implement for points that are matrices."""

    parameters: MetricParameters
    _arrays: PoseMatrices
    _matrices: Array
    """Matrices at the identity, shape=[B, 3, 3]."""
    _scale: Array
    """Multiples of the matrices of the parameters that they are, shape=[B]."""

    def curvature(self, tangent_vec_a: Any, tangent_vec_b: Any, tangent_vec_c: Any, base_point: Any = None) -> Any:
        r"""Compute the curvature.

        With Geomstats' sign for invariant metrics,
        :math:`R(x, y)z = \nabla_{[x,y]}z - \nabla_x\nabla_y z + \nabla_y\nabla_x z`.

        Parameters
        ----------
        tangent_vec_a, tangent_vec_b, tangent_vec_c : array-like, shape=[..., *space.shape]
            Tangent vectors at base_point.
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        curvature : array-like, shape=[..., *space.shape]
            Tangent vector at base_point.
        """
        return self._on_velocities(levi_civita.curvature, base_point, tangent_vec_a, tangent_vec_b, tangent_vec_c)

    def curvature_derivative(
        self, tangent_vec_a: Any, tangent_vec_b: Any, tangent_vec_c: Any, tangent_vec_d: Any, base_point: Any = None
    ) -> Any:
        r"""Compute the covariant derivative of the curvature, :math:`(\nabla_a R)(b, c) d`.

        Parameters
        ----------
        tangent_vec_a, tangent_vec_b, tangent_vec_c, tangent_vec_d : array-like, shape=[..., *space.shape]
            Tangent vectors at base_point.
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        curvature_derivative : array-like, shape=[..., *space.shape]
            Tangent vector at base_point.
        """
        vectors = (tangent_vec_a, tangent_vec_b, tangent_vec_c, tangent_vec_d)
        return self._on_velocities(levi_civita.curvature_derivative, base_point, *vectors)

    def sectional_curvature(self, tangent_vec_a: Any, tangent_vec_b: Any, base_point: Any = None) -> Any:
        """Compute the sectional curvature of the planes that two tangent vectors span.

        Parameters
        ----------
        tangent_vec_a, tangent_vec_b : array-like, shape=[..., *space.shape]
            Tangent vectors at base_point.
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        sectional_curvature : array-like, shape=[...]
            0 where the vectors span no plane.
        """
        base = self._arrays.read_points(base_point, "base_point")
        a = self._arrays.read_velocities(tangent_vec_a, base, "tangent_vec_a")
        b = self._arrays.read_velocities(tangent_vec_b, base, "tangent_vec_b")
        along = self._product(levi_civita.curvature(self.parameters, a, b, a), b)
        squares = self._product(a, a) * self._product(b, b)
        area = squares - self._product(a, b) ** 2
        spans = area > _NO_PLANE * squares
        value = np.where(spans, along / np.where(spans, area, 1.0), 0.0)
        return self._arrays.write(value, value.shape)

    def injectivity_radius(self, base_point: Any = None) -> Any:
        """Bound the injectivity radius from below; it is the same everywhere.

        Every geodesic that is not longer is the only shortest one between its ends.

        Parameters
        ----------
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        radius : array-like, shape=[...]
        """
        radius = (np.sqrt(2.0 * self._scale) * injectivity_radius(self.parameters.moments)).min()
        return self._everywhere(np.asarray(radius), base_point)

    def scalar_curvature(self, base_point: Any = None) -> Any:
        """Compute the scalar curvature, shape=[...]; it is the same everywhere."""
        value = (levi_civita.principal_curvatures(self.parameters).sum(axis=-1) / self._scale).sum()
        return self._everywhere(np.asarray(value), base_point)

    def ricci_tensor(self, base_point: Any = None) -> Any:
        """Compute the Ricci curvature in the chart of rotation vectors.

        Parameters
        ----------
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        ricci_tensor : array-like, shape=[..., dim, dim]
        """
        return self._in_chart(levi_civita.ricci(self.parameters), base_point)

    def metric_matrix(self, base_point: Any = None) -> Any:
        """Compute the matrix of the metric in the chart of rotation vectors.

        Parameters
        ----------
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        metric_matrix : array-like, shape=[..., dim, dim]
        """
        return self._in_chart(2.0 * self._matrices, base_point)

    def christoffels(self, base_point: Any = None) -> Any:
        """Compute the Christoffel symbols in the chart of rotation vectors.

        Parameters
        ----------
        base_point : array-like, shape=[..., *space.shape]
            Optional, default: identity.

        Returns
        -------
        christoffels : array-like, shape=[..., dim, dim, dim]
            The contravariant index is the first.
        """
        chart, jacobian = self._chart(base_point)
        units = np.eye(3)
        shape = (*chart.shape[:-2], 3, 3, *chart.shape[-2:])
        point = np.broadcast_to(chart[..., None, None, :, :], shape)
        ahead, across = (units[:, None] + sign * units[None] for sign in (1.0, -1.0))
        # the acceleration of exp(c) where c' is constant is a quadratic form of c'
        squares = (
            exponential_rates(point, np.broadcast_to(pair[:, :, None], shape), np.zeros(shape)).acceleration
            for pair in (ahead, across)
        )
        bending = 0.25 * (next(squares) - next(squares))
        lines = np.moveaxis(jacobian, -1, -3)  # the velocities of the coordinate lines, shape=[..., 3, B, 3]
        first, second = lines[..., :, None, :, :], lines[..., None, :, :, :]
        outward = np.where(self.parameters.is_right, -1.0, 1.0)[:, None]
        turning = 0.5 * outward * (self._connection(first, second) + self._connection(second, first))
        inverse = np.linalg.inv(jacobian)[..., None, None, :, :, :]
        symbols = outward * (inverse @ (bending + turning)[..., None])[..., 0]
        return self._blocks(np.moveaxis(symbols, -1, -4), 3)

    def jacobi_field(
        self, base_point: Any, tangent_vec: Any, field: Any, field_derivative: Any
    ) -> Callable[[ArrayLike], Any]:
        """Make the Jacobi field along a geodesic: how neighbouring geodesics leave it.

        Parameters
        ----------
        base_point : array-like, shape=[..., *space.shape]
        tangent_vec : array-like, shape=[..., *space.shape]
            Velocity of the geodesic at base_point.
        field : array-like, shape=[..., *space.shape]
            Value of the field at base_point.
        field_derivative : array-like, shape=[..., *space.shape]
            Covariant derivative of the field along the geodesic, at base_point.

        Returns
        -------
        path : callable
            Takes times, shape=[n_times] or [], and returns the field, shape=[..., n_times, *space.shape], tangent at
            the points of the geodesic.
        """
        base = self._arrays.read_points(base_point, "base_point")
        velocity = self._arrays.read_velocities(tangent_vec, base, "tangent_vec")
        value = self._arrays.read_velocities(field, base, "field")
        derivative = self._arrays.read_velocities(field_derivative, base, "field_derivative")
        batch = np.broadcast_shapes(velocity.shape, value.shape, derivative.shape)[:-2]
        outward = np.where(self.parameters.is_right, -1.0, 1.0)[:, None]
        change = derivative - self._connection(velocity, value) + outward * quat.cross(velocity, value)
        base, velocity, value, change = (mat.flat(values, batch, 2) for values in (base, velocity, value, change))
        n = len(base)

        def path(t: ArrayLike) -> Any:
            times = np.atleast_1d(mat.read(t, (), "t"))
            if times.ndim > 1:
                raise ValueError(f"t has shape {times.shape}, but (n_times,) is needed.")
            points, vectors = np.empty((n, len(times), *base.shape[1:])), np.empty((n, len(times), *value.shape[1:]))
            for sign, column in ((1.0, times >= 0.0), (-1.0, times < 0.0)):
                order = np.flatnonzero(column)[np.argsort(np.abs(times[column]), kind="stable")]
                index, parameter = np.repeat(np.arange(n), len(order)), np.tile(np.abs(times[order]), n)
                geodesics = PoseGeodesics(base, sign * velocity, self.parameters)
                by = geodesics.variations(index, parameter)
                found = by.by_initial @ value[index][..., None] + by.by_velocity @ (sign * change)[index][..., None]
                points[:, order] = geodesics(index, parameter).reshape(n, len(order), *base.shape[1:])
                vectors[:, order] = found.reshape(n, len(order), *value.shape[1:])
            return self._arrays.write_tangent_vecs(
                vectors.reshape(-1, *value.shape[1:]), points.reshape(-1, *base.shape[1:]), (*batch, len(times))
            )

        return path

    def _connection(self, first: Array, second: Array) -> Array:
        return levi_civita.connection(self.parameters, first, second)

    def _product(self, first: Array, second: Array) -> Array:
        """Return the inner product, shape=[...], of velocities."""
        momentum = (self._matrices @ second[..., None])[..., 0]
        return 2.0 * np.einsum("...bi,...bi->...", first, momentum)

    def _on_velocities(self, function: Callable[..., Array], base_point: Any, *vectors: Any) -> Any:
        """Apply a multilinear function of velocities to tangent vectors."""
        base = self._arrays.read_points(base_point, "base_point")
        letters = zip("abcd", vectors, strict=False)
        velocities = [self._arrays.read_velocities(vector, base, f"tangent_vec_{letter}") for letter, vector in letters]
        value = function(self.parameters, *velocities)
        batch = value.shape[:-2]
        return self._arrays.write_tangent_vecs(mat.flat(value, batch, 2), mat.flat(base, batch, 2), batch)

    def _everywhere(self, value: Array, base_point: Any) -> Any:
        """Repeat a number for every base point."""
        batch = self._arrays.read_points(base_point, "base_point").shape[:-2]
        return self._arrays.write(np.full(batch, value), batch)

    def _chart(self, base_point: Any) -> tuple[Array, Array]:
        """Return rotation vectors, shape=[..., B, 3], and the derivative of the velocities by them.

        Those of right-invariant joints are of the inverse, which carries them to left-invariant ones.
        """
        base = self._arrays.read_points(base_point, "base_point")
        chart = np.where(self.parameters.is_right, -1.0, 1.0)[:, None] * quat.log(base)
        return chart, np.moveaxis(left_jacobian(chart), -1, -2)

    def _in_chart(self, forms: Array, base_point: Any) -> Any:
        """Return the matrix of bilinear forms of the joints, shape=[B, 3, 3], in the chart."""
        _, jacobian = self._chart(base_point)
        return self._blocks(np.moveaxis(np.moveaxis(jacobian, -1, -2) @ forms @ jacobian, -3, -1), 2)

    def _blocks(self, values: Array, rank: int) -> Any:
        """Write tensors of the joints, shape=[..., 3, ..., 3, B], as those of the space, shape=[..., dim, ..., dim]."""
        n_joints, batch = values.shape[-1], values.shape[: values.ndim - rank - 1]
        whole = np.zeros((*batch, *(n_joints, 3) * rank))
        joint = np.arange(n_joints)
        whole[(..., *(joint, slice(None)) * rank)] = np.moveaxis(values, -1, 0)
        return self._arrays.write(whole, (*batch, *(3 * n_joints,) * rank))
