"""Invariant metrics on SO(3), for Geomstats."""

from __future__ import annotations

from typing import Any

import geomstats.backend as gs
import numpy as np
from geomstats.geometry.invariant_metric import _InvariantMetricMatrix
from geomstats.geometry.special_orthogonal import _SpecialOrthogonalMatrices

from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian.compiled_metric import CompiledMetric


class SO3InvariantMetric(CompiledMetric, _InvariantMetricMatrix):
    """Left- or right-invariant metric on SO(3), with any symmetric positive definite matrix at the identity.

    It agrees with `geomstats.geometry.invariant_metric.InvariantMetric` wherever that is right: on diagonal matrices,
    short geodesics, and left-invariant curvature.

    Parameters
    ----------
    space : SpecialOrthogonal
        SO(3), as matrices.
    metric_mat_at_identity : array-like, shape=[3, 3]
        Symmetric positive definite, in the basis of rotations about x, y and z.
        Optional, default: identity, the bi-invariant metric.
    left : bool
        Whether the metric is left-invariant, and not right-invariant.
        Optional, default: True.

    Raises
    ------
    ValueError
        If the space is not SO(3) as matrices, the matrix is not symmetric positive definite, or left is not a bool.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats.geometry.special_orthogonal import SpecialOrthogonal
    >>> from geomstats_anim import SO3InvariantMetric
    >>> so3 = SpecialOrthogonal(3, equip=False)
    >>> metric_mat = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 4.0]])
    >>> so3 = so3.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=metric_mat, left=True)
    >>> base_point, point = so3.random_point(2)
    >>> tangent_vec = so3.metric.log(point, base_point)
    >>> bool(np.allclose(so3.metric.exp(tangent_vec, base_point), point, rtol=0.0, atol=1e-10))
    True
    >>> path = so3.metric.geodesic(base_point, end_point=point)
    >>> path([0.0, 0.5, 1.0]).shape
    (3, 3, 3)
    """

    def __init__(self, space: Any, metric_mat_at_identity: Any = None, left: bool = True) -> None:
        if not isinstance(space, _SpecialOrthogonalMatrices) or space.n != 3:
            raise ValueError("SO3InvariantMetric needs SpecialOrthogonal(3), with matrices as points.")
        if not isinstance(left, bool | np.bool_):
            raise ValueError(f"left is {left!r}, but it must be True or False.")
        matrix = np.eye(3) if metric_mat_at_identity is None else np.asarray(metric_mat_at_identity, dtype=np.float64)
        if matrix.shape != (3, 3):
            raise ValueError(f"metric_mat_at_identity has shape {matrix.shape}, but (3, 3) is needed.")
        try:
            self.parameters = MetricParameters.from_matrices(matrix[None], "left" if left else "right")
        except ValueError as error:
            raise ValueError(f"metric_mat_at_identity must be symmetric positive definite: {error}") from None
        self._matrices = 0.5 * (matrix + matrix.T)[None]
        self._scale = np.trace(self._matrices, axis1=1, axis2=2) / self.parameters.moments.sum(axis=-1)
        super().__init__(space, gs.from_numpy(self._matrices[0]), bool(left))

    def __repr__(self) -> str:
        """Say the side and the matrix."""
        rows = np.array2string(self._matrices[0], precision=4, separator=", ").replace("\n", "")
        return f"SO3InvariantMetric({self.parameters.invariance[0]}, {rows})"

    def __mul__(self, scalar: float) -> SO3InvariantMetric:
        """Multiply the inner product by a positive number, and distances by its square root."""
        if not isinstance(scalar, float):
            return NotImplemented
        return SO3InvariantMetric(self._space, scalar * self.metric_mat_at_identity, self.left)

    def inner_product_at_identity(self, tangent_vec_a: Any, tangent_vec_b: Any) -> Any:
        """Compute the inner product of two tangent vectors at the identity.

        Parameters
        ----------
        tangent_vec_a : array-like, shape=[..., 3, 3]
            First tangent vector at the identity.
        tangent_vec_b : array-like, shape=[..., 3, 3]
            Second tangent vector at the identity.

        Returns
        -------
        inner_product : array-like, shape=[...]
        """
        return self.inner_product(tangent_vec_a, tangent_vec_b)

    def curvature_at_identity(self, tangent_vec_a: Any, tangent_vec_b: Any, tangent_vec_c: Any) -> Any:
        r"""Compute the curvature at the identity.

        With Geomstats' sign for invariant metrics,
        :math:`R(x, y)z = \nabla_{[x,y]}z - \nabla_x\nabla_y z + \nabla_y\nabla_x z`. The fields are invariant, and the
        bracket of right-invariant ones is minus that of the matrices, which Geomstats forgets.

        Parameters
        ----------
        tangent_vec_a : array-like, shape=[..., 3, 3]
            Tangent vector at the identity.
        tangent_vec_b : array-like, shape=[..., 3, 3]
            Tangent vector at the identity.
        tangent_vec_c : array-like, shape=[..., 3, 3]
            Tangent vector at the identity.

        Returns
        -------
        curvature : array-like, shape=[..., 3, 3]
            Tangent vector at the identity.
        """
        return self.curvature(tangent_vec_a, tangent_vec_b, tangent_vec_c)

    def sectional_curvature_at_identity(self, tangent_vec_a: Any, tangent_vec_b: Any) -> Any:
        """Compute the sectional curvature at the identity of the planes that two tangent vectors span.

        Geomstats' is wrong for vectors that are not orthonormal.

        Parameters
        ----------
        tangent_vec_a : array-like, shape=[..., 3, 3]
            Tangent vector at the identity.
        tangent_vec_b : array-like, shape=[..., 3, 3]
            Tangent vector at the identity.

        Returns
        -------
        sectional_curvature : array-like, shape=[...]
            0 where the vectors span no plane.
        """
        return self.sectional_curvature(tangent_vec_a, tangent_vec_b)
