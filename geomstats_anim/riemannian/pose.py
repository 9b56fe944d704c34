"""Pose Lie group SO(3)^B and invariant metrics on it, for Geomstats."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import geomstats.backend as gs
import numpy as np
from geomstats.errors import check_integer
from geomstats.geometry.nfold_manifold import NFoldManifold
from geomstats.geometry.special_orthogonal import SpecialOrthogonal

from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian.compiled_metric import CompiledMetric


class PoseSpace(NFoldManifold):
    """Pose Lie group SO(3)^B: a rotation for each bone of a skeleton.

    Parameters
    ----------
    n_bones : int
        B.
    equip : bool
        Whether to equip it with the bi-invariant metric.
        Optional, default: True.

    Examples
    --------
    >>> from geomstats_anim import MetricParameters, PoseMetric, PoseSpace
    >>> space = PoseSpace(2)
    >>> parameters = MetricParameters(alpha=[2.0, 1.0], beta=[0.5, 3.0], invariance=["left", "right"])
    >>> space = space.equip_with_metric(PoseMetric, parameters=parameters)
    >>> base_point, point = space.random_point(2)
    >>> space.metric.geodesic(base_point, end_point=point)([0.0, 0.5, 1.0]).shape
    (3, 2, 3, 3)
    >>> result = space.metric.log_solver.solve(point, base_point)
    >>> result.status
    array([0, 0])
    """

    def __init__(self, n_bones: int, equip: bool = True) -> None:
        n_bones = operator.index(n_bones)
        check_integer(n_bones, "n_bones")
        super().__init__(SpecialOrthogonal(3, equip=False), n_bones, equip=equip)

    def __repr__(self) -> str:
        """Return the call that makes the space, and its metric."""
        metric = f" with {self.metric!r}" if hasattr(self, "metric") else ""
        return f"PoseSpace({self.n_bones}){metric}"

    @property
    def n_bones(self) -> int:
        """Return the number of bones, B."""
        return self.n_copies

    @staticmethod
    def default_metric() -> type:
        """Return the metric to equip the space with if equip is True."""
        return PoseMetric

    @property
    def identity(self) -> Any:
        """Return the identity of the group, shape=[B, 3, 3]."""
        return gs.tile(gs.eye(3), (self.n_bones, 1, 1))

    def belongs(self, point: Any, atol: float = gs.atol) -> Any:
        """Evaluate if a point belongs to the space.

        Parameters
        ----------
        point : array-like, shape=[..., B, 3, 3]
        atol : float
            Optional, default: backend atol.

        Returns
        -------
        belongs : array-like, shape=[...]
        """
        if tuple(point.shape[-3:]) != self.shape:
            return gs.zeros(point.shape[:-3], dtype=bool)
        return super().belongs(point, atol)

    def is_tangent(self, vector: Any, base_point: Any = None, atol: float = gs.atol) -> Any:
        """Check whether a vector is tangent at a base point.

        Parameters
        ----------
        vector : array-like, shape=[..., B, 3, 3]
        base_point : array-like, shape=[..., B, 3, 3]
            Optional, default: identity.
        atol : float
            Optional, default: backend atol.

        Returns
        -------
        is_tangent : array-like, shape=[...]
        """
        return super().is_tangent(vector, self.identity if base_point is None else base_point, atol)

    def to_tangent(self, vector: Any, base_point: Any = None) -> Any:
        """Project a vector to the tangent space at a base point.

        Parameters
        ----------
        vector : array-like, shape=[..., B, 3, 3]
        base_point : array-like, shape=[..., B, 3, 3]
            Optional, default: identity.

        Returns
        -------
        tangent_vec : array-like, shape=[..., B, 3, 3]
        """
        base_point = self.identity if base_point is None else base_point
        seen = gs.matmul(gs.moveaxis(base_point, -1, -2), vector)
        return 0.5 * gs.matmul(base_point, seen - gs.moveaxis(seen, -1, -2))

    def compose(self, point_a: Any, point_b: Any) -> Any:
        """Multiply poses, bone by bone.

        Parameters
        ----------
        point_a : array-like, shape=[..., B, 3, 3]
            Left factor.
        point_b : array-like, shape=[..., B, 3, 3]
            Right factor.

        Returns
        -------
        product : array-like, shape=[..., B, 3, 3]
        """
        return self.base_manifold.compose(point_a, point_b)

    def inverse(self, point: Any) -> Any:
        """Invert poses, shape=[..., B, 3, 3]."""
        return self.base_manifold.inverse(point)

    def tangent_translation_map(self, point: Any, left: bool = True, inverse: bool = False) -> Callable[[Any], Any]:
        """Compute the push-forward map of the translation by a point.

        Parameters
        ----------
        point : array-like, shape=[..., B, 3, 3]
        left : bool
            Whether to translate from the left, and not from the right.
            Optional, default: True.
        inverse : bool
            Whether to translate by the inverse of the point.
            Optional, default: False.

        Returns
        -------
        tangent_map : callable
            Takes and returns tangent vectors, shape=[..., B, 3, 3].
        """
        return self.base_manifold.tangent_translation_map(point, left=left, inverse=inverse)

    def lie_bracket(self, tangent_vec_a: Any, tangent_vec_b: Any, base_point: Any = None) -> Any:
        """Compute the Lie bracket of two tangent vectors.

        Parameters
        ----------
        tangent_vec_a : array-like, shape=[..., B, 3, 3]
            First tangent vector at base_point.
        tangent_vec_b : array-like, shape=[..., B, 3, 3]
            Second tangent vector at base_point.
        base_point : array-like, shape=[..., B, 3, 3]
            Optional, default: identity.

        Returns
        -------
        bracket : array-like, shape=[..., B, 3, 3]
            Tangent vector at base_point.
        """
        return self.base_manifold.lie_bracket(tangent_vec_a, tangent_vec_b, base_point)

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Compute the group exponential, which is the Riemannian one of the bi-invariant metric.

        Parameters
        ----------
        tangent_vec : array-like, shape=[..., B, 3, 3]
            Tangent vector at base_point.
        base_point : array-like, shape=[..., B, 3, 3]
            Optional, default: identity.

        Returns
        -------
        end_point : array-like, shape=[..., B, 3, 3]
        """
        return PoseMetric(self).exp(tangent_vec, base_point)

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Compute the group logarithm, which is the Riemannian one of the bi-invariant metric.

        Parameters
        ----------
        point : array-like, shape=[..., B, 3, 3]
        base_point : array-like, shape=[..., B, 3, 3]
            Optional, default: identity.

        Returns
        -------
        tangent_vec : array-like, shape=[..., B, 3, 3]
            Tangent vector at base_point.
        """
        return PoseMetric(self).log(point, base_point)


class PoseMetric(CompiledMetric):
    """Invariant metric on the pose Lie group, with a matrix and a side for each bone.

    Parameters
    ----------
    space : PoseSpace
    parameters : MetricParameters
        One joint a bone.
        Optional, default: the bi-invariant metric.

    Raises
    ------
    ValueError
        If the space is not a PoseSpace, or has not as many bones as the parameters have joints.
    """

    def __init__(self, space: PoseSpace, parameters: MetricParameters | None = None) -> None:
        if not isinstance(space, PoseSpace):
            raise ValueError("PoseMetric needs a PoseSpace.")
        parameters = MetricParameters.identity(space.n_bones) if parameters is None else parameters
        if parameters.n_joints != space.n_bones:
            raise ValueError(
                f"The space has {space.n_bones} bones, but there are metric parameters for {parameters.n_joints}."
            )
        super().__init__(space)
        self.parameters = parameters
        self._matrices = parameters.matrices
        self._scale = np.ones(space.n_bones)
        self._instantiate_solvers()

    def __repr__(self) -> str:
        """Say how many joints there are, on which side, and the range of alpha and beta."""
        return f"PoseMetric({self.parameters})"
