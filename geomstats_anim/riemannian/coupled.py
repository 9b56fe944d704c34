"""Invariant metrics that couple the bones of a pose, for Geomstats."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geomstats.geometry.riemannian_metric import RiemannianMetric
from geomstats.numerics.geodesic import ExpSolver, LogSolver
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics import coupled
from geomstats_anim.geodesics.pose_geodesics import LogResult
from geomstats_anim.kernels.shooting import CONVERGED
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.failures import raise_failures
from geomstats_anim.riemannian.matrices import PoseMatrices
from geomstats_anim.riemannian.pose import PoseSpace
from geomstats_anim.rotations import Array

_STILL = 1e-12
"""Turn from frame to frame, in radians, that is rounding."""


class CoupledPoseMetric(RiemannianMetric):
    """Invariant metric on the pose Lie group with one matrix over all bones: a turn of one may ask for turns of others.

    Where the matrix is block diagonal, it is a `PoseMetric`, which is much faster. Logarithms are the geodesics that
    Newton's method finds from the bi-invariant one, or else continuation in the metric; they are the shortest near the
    base point. Bones that are not coupled, not even through others, are solved apart.

    Parameters
    ----------
    space : PoseSpace
    metric_mat_at_identity : array-like, shape=[3B, 3B]
        Symmetric positive definite, in the basis of rotations about x, y and z, bone after bone.
    left : bool
        Whether the metric is left-invariant, and not right-invariant.
        Optional, default: True.

    Raises
    ------
    ValueError
        If the space is not a PoseSpace, or the matrix is not symmetric positive definite or of another size.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import PoseSpace
    >>> from geomstats_anim.riemannian.coupled import CoupledPoseMetric
    >>> matrix = np.eye(6)
    >>> matrix[0, 3] = matrix[3, 0] = -0.5  # turns about x of both bones come together
    >>> space = PoseSpace(2, equip=False)
    >>> space = space.equip_with_metric(CoupledPoseMetric, metric_mat_at_identity=matrix)
    >>> base_point, point = space.random_point(2)
    >>> tangent_vec = space.metric.log(point, base_point)
    >>> bool(np.allclose(space.metric.exp(tangent_vec, base_point), point, rtol=0.0, atol=1e-8))
    True
    """

    def __init__(self, space: PoseSpace, metric_mat_at_identity: ArrayLike, left: bool = True) -> None:
        if not isinstance(space, PoseSpace):
            raise ValueError("CoupledPoseMetric needs a PoseSpace.")
        matrix = np.array(metric_mat_at_identity, dtype=np.float64)
        if matrix.shape != (space.dim, space.dim):
            raise ValueError(
                f"metric_mat_at_identity has shape {matrix.shape}, but ({space.dim}, {space.dim}) is needed."
            )
        if not np.isfinite(matrix).all() or np.abs(matrix - matrix.T).max() > 1e-8 * np.abs(matrix).max():
            raise ValueError("metric_mat_at_identity must be symmetric, and its numbers finite.")
        matrix = 0.5 * (matrix + matrix.T)
        least = np.linalg.eigvalsh(matrix)[0]
        if least <= 0.0:
            raise ValueError(f"metric_mat_at_identity has the eigenvalue {least:.6g}; it must be positive.")
        super().__init__(space)
        self.metric_mat_at_identity, self.left = matrix, bool(left)
        sides = MetricParameters(np.ones(space.n_bones), np.ones(space.n_bones), None, _side(self.left))
        self._arrays = PoseMatrices(space.shape, sides)
        self.exp_solver = _CoupledExpSolver(self._arrays, matrix, self.left)
        self.log_solver = _CoupledLogSolver(self._arrays, matrix, self.left)

    def __repr__(self) -> str:
        """Say how many joints are coupled, on which side, and the condition of the matrix."""
        condition = np.linalg.cond(self.metric_mat_at_identity)
        return f"CoupledPoseMetric({self._space.n_bones} joints, {_side(self.left)[0]}, condition {condition:.3g})"

    def inner_product(self, tangent_vec_a: Any, tangent_vec_b: Any, base_point: Any = None) -> Any:
        """Compute the inner product of two tangent vectors at a base point.

        Parameters
        ----------
        tangent_vec_a, tangent_vec_b : array-like, shape=[..., B, 3, 3]
            Tangent vectors at base_point; what of them is not tangent is projected away.
        base_point : array-like, shape=[..., B, 3, 3]
            Optional, default: identity.

        Returns
        -------
        inner_product : array-like, shape=[...]
            2 a^T Z b, in Geomstats' scale.
        """
        base = self._arrays.read_points(base_point, "base_point")
        a = self._arrays.read_velocities(tangent_vec_a, base, "tangent_vec_a")
        b = self._arrays.read_velocities(tangent_vec_b, base, "tangent_vec_b")
        a, b = (values.reshape(*values.shape[:-2], -1) for values in (a, b))
        product = 2.0 * np.einsum("...i,ij,...j->...", a, self.metric_mat_at_identity, b)
        return self._arrays.write(product, np.shape(product))

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Compute the Riemannian exponential, shape=[..., B, 3, 3], of tangent vectors; the base is the identity."""
        return self.exp_solver.exp(tangent_vec, base_point)

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Compute the Riemannian logarithm, shape=[..., B, 3, 3]; see `CoupledPoseMetric` for which.

        Raises
        ------
        RuntimeError
            If no geodesic was found for an element; `log_solver.solve` returns every status instead.
        """
        return self.log_solver.log(point, base_point)


def matrix_of_motion(points: Any, shrinkage: float = 0.1, left: bool = True) -> Array:
    """Make the matrix to which the motion of a clip is cheap: the inverse of the shrunk covariance of its velocities.

    Its eigenvectors are the turns that come together, and their eigenvalues small where they are frequent.

    Parameters
    ----------
    points : array-like, shape=[F, B, 3, 3]
        Poses of equally spaced frames.
    shrinkage : float
        Positive: how much of the identity is added to the covariance, whose mean eigenvalue is 1.
        Optional, default: 0.1.
    left : bool
        Whether velocities are the bodies', for a left-invariant metric, and not the parents'.
        Optional, default: True.

    Returns
    -------
    matrix : array-like, shape=[3B, 3B]

    Raises
    ------
    ValueError
        If the shrinkage is not positive, or nothing moves.
    """
    if not shrinkage > 0.0:
        raise ValueError(f"The shrinkage is {shrinkage}; it must be positive.")
    points = mat.read(points, (3, 3), "points")
    n_joints = points.shape[-3]
    sides = MetricParameters(np.ones(n_joints), np.ones(n_joints), None, _side(left))
    rotations = PoseMatrices((n_joints, 3, 3), sides).read_points(points, "points")
    turns = quat.multiply(rotations[1:], quat.conjugate(rotations[:-1]))
    velocity = quat.log(turns) if not left else quat.difference(rotations[:-1], rotations[1:])
    velocity = velocity.reshape(len(velocity), -1)
    covariance = velocity.T @ velocity
    mean = np.trace(covariance) / len(covariance)
    if not mean > len(velocity) * _STILL**2:
        raise ValueError("Nothing moves in these poses, so that no turns come together.")
    return np.asarray(np.linalg.inv(covariance / mean + shrinkage * np.eye(len(covariance))), dtype=np.float64)


def _side(left: bool) -> tuple[str]:
    return ("left" if left else "right",)


def _cometric_of(matrix: Array) -> Array:
    """Invert a matrix group by group of joints that are coupled, so that zeros between groups stay exact."""
    cometric = np.zeros_like(matrix)
    for joints in coupled.components(matrix):
        rows = (3 * joints[:, None] + np.arange(3)).ravel()
        cometric[np.ix_(rows, rows)] = np.linalg.inv(matrix[np.ix_(rows, rows)])
    return 0.5 * (cometric + cometric.T)


class _Paths:
    """Geodesics of a batch, from base points with velocities in the frame where the metric is constant."""

    def __init__(self, arrays: PoseMatrices, matrix: Array, left: bool) -> None:
        self._arrays, self._matrix, self._left = arrays, matrix, left
        self._cometric = _cometric_of(matrix)

    def follow(self, base: Array, velocity: Array, times: Array) -> Array:
        """Return poses, shape=[n, T, B, 4]."""
        # right-invariant geodesics are inverses of left-invariant ones
        outward = 1.0 if self._left else -1.0
        momentum = outward * (velocity.reshape(len(velocity), -1) @ self._matrix).reshape(velocity.shape)
        turns = np.empty((*velocity.shape[:1], len(times), *velocity.shape[1:-1], 4))
        for sign, column in ((1.0, times >= 0.0), (-1.0, times < 0.0)):
            order = np.flatnonzero(column)[np.argsort(np.abs(times[column]), kind="stable")]
            turns[:, order] = coupled.flow(self._cometric, sign * momentum, np.abs(times[order]))
        if self._left:
            return quat.multiply(np.broadcast_to(base[:, None], turns.shape), turns)
        return quat.multiply(quat.conjugate(turns), np.broadcast_to(base[:, None], turns.shape))

    def path(self, base: Array, velocity: Array, batch: tuple[int, ...]) -> Callable[[Any], Any]:
        """Return the function of time of geodesics."""

        def path(t: ArrayLike) -> Any:
            times = np.atleast_1d(mat.read(t, (), "t"))
            if times.ndim > 1:
                raise ValueError(f"t has shape {times.shape}, but (n_times,) is needed.")
            return self._arrays.write_points(self.follow(base, velocity, times), (*batch, len(times)))

        return path


class _CoupledExpSolver(ExpSolver):
    """Exponential by integration."""

    def __init__(self, arrays: PoseMatrices, matrix: Array, left: bool) -> None:
        super().__init__(solves_ivp=True)
        self._arrays, self._paths = arrays, _Paths(arrays, matrix, left)

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Return the ends of geodesics."""
        base, velocity, batch = self._read(tangent_vec, base_point, "base_point", "tangent_vec")
        return self._arrays.write_points(self._paths.follow(base, velocity, np.ones(1))[:, 0], batch)

    def geodesic_ivp(self, tangent_vec: Any, base_point: Any) -> Callable[[Any], Any]:
        """Return the function of time of geodesics that leave points with given velocities."""
        return self._paths.path(*self._read(tangent_vec, base_point, "initial_point", "initial_tangent_vec"))

    def _read(
        self, tangent_vec: Any, base_point: Any, point_name: str, vec_name: str
    ) -> tuple[Array, Array, tuple[int, ...]]:
        base = self._arrays.read_points(base_point, point_name)
        velocity = self._arrays.read_velocities(tangent_vec, base, vec_name)
        batch = velocity.shape[:-2]
        return mat.flat(base, batch, 2), mat.flat(velocity, batch, 2), batch


class _CoupledLogSolver(LogSolver):
    """Logarithm by Newton's method, and by continuation in the metric where that fails."""

    def __init__(self, arrays: PoseMatrices, matrix: Array, left: bool) -> None:
        super().__init__(solves_bvp=True)
        self._arrays, self._matrix, self._left = arrays, matrix, left
        self._cometric = _cometric_of(matrix)
        self._paths = _Paths(arrays, matrix, left)

    def solve(self, point: Any, base_point: Any = None) -> LogResult:
        """Find logarithms, and return how each search ended; arrays besides the vectors have shape [...]."""
        base, shots, velocity, batch = self._join(point, base_point, "point", "base_point")
        status = shots.status.max(axis=-1)
        squares = 2.0 * np.einsum(
            "ni,ij,nj->n", velocity.reshape(len(base), -1), self._matrix, velocity.reshape(len(base), -1)
        )
        found = status == CONVERGED
        values = (
            status,
            shots.residual.max(axis=-1),
            np.where(found, np.sqrt(squares), np.inf),
            shots.shots.max(axis=-1),
        )
        vectors = self._arrays.write_tangent_vecs(np.where(found[:, None, None], velocity, 0.0), base, batch)
        return LogResult(vectors, *(self._arrays.write(value, batch) for value in values))

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Return logarithms, or raise."""
        base, shots, velocity, batch = self._join(point, base_point, "point", "base_point")
        raise_failures(shots.status.max(axis=-1), batch)
        return self._arrays.write_tangent_vecs(velocity, base, batch)

    def geodesic_bvp(self, point: Any, base_point: Any) -> Callable[[Any], Any]:
        """Return the function of time of geodesics that join points, or raise."""
        base, shots, velocity, batch = self._join(point, base_point, "end_point", "initial_point")
        raise_failures(shots.status.max(axis=-1), batch)
        return self._paths.path(base, velocity, batch)

    def _join(
        self, point: Any, base_point: Any, point_name: str, base_name: str
    ) -> tuple[Array, coupled.Shots, Array, tuple[int, ...]]:
        base = self._arrays.read_points(base_point, base_name)
        end = self._arrays.read_points(point, point_name)
        batch = np.broadcast_shapes(base.shape, end.shape)[:-2]
        base, end = mat.flat(base, batch, 2), mat.flat(end, batch, 2)
        if self._left:
            targets = quat.multiply(quat.conjugate(base), end)
        else:
            targets = quat.multiply(base, quat.conjugate(end))
        shots = coupled.shoot(self._cometric, targets)
        velocity = (shots.momentum.reshape(len(base), -1) @ self._cometric).reshape(*base.shape[:-1], 3)
        return base, shots, velocity if self._left else -velocity, batch
