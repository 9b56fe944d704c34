r"""The kinetic energy of a rigid body as a metric on SE(3), for Geomstats.

With the rotation R, the position p of the body's origin, its body angular velocity w and the center of mass c in the
body, the squared length is :math:`w^T J w + m |\dot p + R \hat w c|^2`: left-invariant, with geodesics that are the
motions of a free body (Zefran, Kumar and Croke, "On the generation of smooth three-dimensional rigid body motions",
1998). The center of mass goes straight, the rotation along the geodesic of J, and the origin bends with it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import geomstats.backend as gs
import numpy as np
from geomstats.geometry.riemannian_metric import RiemannianMetric
from geomstats.geometry.special_euclidean import SpecialEuclidean
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.numerics.geodesic import ExpSolver, LogSolver
from numpy.typing import ArrayLike

from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.so3 import SO3InvariantMetric
from geomstats_anim.rotations import Array

_POINT = (4, 4)


class RigidMotionMetric(RiemannianMetric):
    """Kinetic energy on SE(3): translation and rotation bend together where the origin is not the center of mass.

    Parameters
    ----------
    space : SpecialEuclidean
        SE(3), as matrices.
    inertia : array-like, shape=[3, 3]
        About the center of mass, along the body's axes: symmetric positive definite.
        Optional, default: identity.
    mass : float
        Positive: what a metre costs beside a radian.
        Optional, default: 1.
    center : array-like, shape=[3]
        Center of mass, in the body.
        Optional, default: the origin.

    Raises
    ------
    ValueError
        If the space is not SE(3) as matrices, or a number is not as it must be.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats.geometry.special_euclidean import SpecialEuclidean
    >>> from geomstats_anim.riemannian.rigid_motion import RigidMotionMetric
    >>> space = SpecialEuclidean(3, equip=False)
    >>> space = space.equip_with_metric(RigidMotionMetric, inertia=np.diag([1.0, 2.0, 2.5]), center=[0.0, 0.3, 0.0])
    >>> base_point, point = space.random_point(2)
    >>> tangent_vec = space.metric.log(point, base_point)
    >>> bool(np.allclose(space.metric.exp(tangent_vec, base_point), point, rtol=0.0, atol=1e-9))
    True
    """

    def __init__(self, space: Any, inertia: Any = None, mass: float = 1.0, center: Any = None) -> None:
        if tuple(space.shape) != _POINT or not isinstance(space, type(SpecialEuclidean(3, equip=False))):
            raise ValueError("RigidMotionMetric needs SpecialEuclidean(3), with matrices as points.")
        if not (np.isfinite(mass) and mass > 0.0):
            raise ValueError(f"mass is {mass}, but it must be a positive number.")
        super().__init__(space)
        self.mass = float(mass)
        self.center = mat.read(np.zeros(3) if center is None else center, (3,), "center")
        rotations = SpecialOrthogonal(3, equip=False)
        matrix = np.eye(3) if inertia is None else np.asarray(inertia, dtype=np.float64)
        # half, since the inner product of Geomstats is twice that of axis vectors
        rotations.equip_with_metric(SO3InvariantMetric, metric_mat_at_identity=0.5 * matrix, left=True)
        self.rotation_metric: SO3InvariantMetric = rotations.metric
        self.exp_solver = _RigidExpSolver(self)
        self.log_solver = _RigidLogSolver(self)

    def __repr__(self) -> str:
        """Say the mass, the center of mass and the inertia."""
        rows = np.array2string(2.0 * self.rotation_metric._matrices[0], precision=4, separator=", ").replace("\n", "")
        return f"RigidMotionMetric(mass {self.mass:g}, center {self.center.tolist()}, inertia {rows})"

    def inner_product(self, tangent_vec_a: Any, tangent_vec_b: Any, base_point: Any = None) -> Any:
        """Compute the inner product, shape=[...], of tangent vectors, shape=[..., 4, 4]: twice the kinetic energy."""
        base = self.read(base_point, "base_point")
        a, b = mat.read(tangent_vec_a, _POINT, "tangent_vec_a"), mat.read(tangent_vec_b, _POINT, "tangent_vec_b")
        turning = self.rotation_metric.inner_product(*(gs.from_numpy(_turn(x)) for x in (a, b, base)))
        moving = self.mass * (self.carried(a) * self.carried(b)).sum(axis=-1)
        return gs.from_numpy(np.asarray(gs.to_numpy(turning) + moving))

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Compute the Riemannian exponential, shape=[..., 4, 4], of tangent vectors; the base is the identity."""
        return self.exp_solver.exp(tangent_vec, base_point)

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Compute the Riemannian logarithm, shape=[..., 4, 4].

        Raises
        ------
        RuntimeError
            If no geodesic of the rotation was found for an element.
        """
        return self.log_solver.log(point, base_point)

    def read(self, point: Any, name: str) -> Array:
        """Read points, shape=[..., 4, 4]; None is the identity."""
        return np.eye(4) if point is None else mat.read(point, _POINT, name)

    def carried(self, vectors: Array) -> Array:
        """Return the place of the center of mass of points, or its velocity of tangent vectors, shape=[..., 3]."""
        return vectors[..., :3, 3] + _turn(vectors) @ self.center

    def joined(self, turn: Array, center: Array, last: float) -> Any:
        """Join rotations, shape=[..., 3, 3], and centers of mass, shape=[..., 3], or their velocities; undo both."""
        batch = np.broadcast_shapes(turn.shape[:-2], center.shape[:-1])
        result = np.zeros((*batch, 4, 4))
        result[..., :3, :3] = turn
        result[..., :3, 3] = center - turn @ self.center
        result[..., 3, 3] = last
        return gs.from_numpy(result)

    def path(self, turns: Callable[[Any], Any], start: Array, velocity: Array) -> Callable[[Any], Any]:
        """Return the function of time of geodesics, whose rotations and centers of mass at the start are known."""

        def path(t: ArrayLike) -> Any:
            times = np.atleast_1d(mat.read(t, (), "t"))
            centers = start[..., None, :] + times[:, None] * velocity[..., None, :]
            return self.joined(gs.to_numpy(turns(times)), centers, 1.0)

        return path


def _turn(vectors: Array) -> Array:
    return vectors[..., :3, :3]


class _RigidExpSolver(ExpSolver):
    """Exponential in closed form, but for the rotation."""

    def __init__(self, metric: RigidMotionMetric) -> None:
        super().__init__(solves_ivp=True)
        self._metric = metric

    def exp(self, tangent_vec: Any, base_point: Any = None) -> Any:
        """Return the ends of geodesics."""
        metric = self._metric
        base, vector = metric.read(base_point, "base_point"), mat.read(tangent_vec, _POINT, "tangent_vec")
        turn = metric.rotation_metric.exp(gs.from_numpy(_turn(vector)), gs.from_numpy(_turn(base)))
        return metric.joined(gs.to_numpy(turn), metric.carried(base) + metric.carried(vector), 1.0)

    def geodesic_ivp(self, tangent_vec: Any, base_point: Any) -> Callable[[Any], Any]:
        """Return the function of time of geodesics that leave points with given velocities."""
        metric = self._metric
        base, vector = metric.read(base_point, "initial_point"), mat.read(tangent_vec, _POINT, "initial_tangent_vec")
        batch = np.broadcast_shapes(base.shape, vector.shape)
        base, vector = np.broadcast_to(base, batch), np.broadcast_to(vector, batch)
        turns = metric.rotation_metric.geodesic(
            gs.from_numpy(_turn(base).copy()), initial_tangent_vec=gs.from_numpy(_turn(vector).copy())
        )
        return metric.path(turns, metric.carried(base), metric.carried(vector))


class _RigidLogSolver(LogSolver):
    """Logarithm in closed form, but for the rotation."""

    def __init__(self, metric: RigidMotionMetric) -> None:
        super().__init__(solves_bvp=True)
        self._metric = metric

    def log(self, point: Any, base_point: Any = None) -> Any:
        """Return logarithms, or raise."""
        metric = self._metric
        base, end = metric.read(base_point, "base_point"), metric.read(point, "point")
        turn = metric.rotation_metric.log(gs.from_numpy(_turn(end)), gs.from_numpy(_turn(base)))
        return metric.joined(gs.to_numpy(turn), metric.carried(end) - metric.carried(base), 0.0)

    def geodesic_bvp(self, point: Any, base_point: Any) -> Callable[[Any], Any]:
        """Return the function of time of geodesics that join points, or raise."""
        return self._metric.exp_solver.geodesic_ivp(self.log(point, base_point), base_point)
