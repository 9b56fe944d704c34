r"""Exact derivatives of exponential, logarithm and squared distance, pulled back onto their arguments.

Arrays are rotation matrices and tangent vectors, shape=[..., B, 3, 3], as NumPy has them; automatic differentiation is
in `autograd_functions` and `torch_functions`. A tangent vector V at R has the velocity w, with :math:`V = R \hat w` for
a left-invariant joint and :math:`V = \hat w R` for a right-invariant one. What of an argument leaves the group or its
tangent space is projected away, so a derivative has no part across them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.exponential import left_jacobian
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.riemannian import matrices as mat
from geomstats_anim.riemannian.matrices import PoseMatrices
from geomstats_anim.rotations import Array


class Gradients(NamedTuple):
    """Derivatives of a scalar by arguments.

    Attributes
    ----------
    vector : array-like, shape=[..., B, 3, 3]
        By the tangent vector of an exponential, or the point of a logarithm or a distance.
    base_point : array-like, shape=[..., B, 3, 3]
    alpha, beta : array-like, shape=[B]
    axes : array-like, shape=[B, 3]
    """

    vector: Array
    base_point: Array
    alpha: Array
    beta: Array
    axes: Array


def pull_back_exp(cotangent: Array, tangent_vec: Array, base_point: Array, parameters: MetricParameters) -> Gradients:
    """Pull the derivative of a scalar by exp(tangent_vec, base_point) back.

    Parameters
    ----------
    cotangent : array-like, shape=[..., B, 3, 3]
    tangent_vec, base_point : array-like, shape=[..., B, 3, 3]
    parameters : MetricParameters

    Returns
    -------
    gradients : Gradients
    """
    frame = _Frame(tangent_vec, base_point, parameters)
    index = np.arange(len(frame.base))
    by = frame.geodesics.variations(index, np.ones(len(index)))
    end = quat.to_matrix(frame.geodesics(index, np.ones(len(index))))
    by_end = frame.by_variation(frame.flat(cotangent), end)
    by_velocity = _transposed(by.by_velocity, by_end)
    by_initial = _transposed(by.by_initial, by_end) + frame.by_fixed_vector(by_velocity)
    return frame.gradients(
        0.5 * frame.matrices(by_velocity, frame.base_matrices),
        by_initial,
        _transposed(by.by_metric, by_end),
        tangent_vec.shape,
        base_point.shape,
    )


def pull_back_log(
    cotangent: Array, tangent_vec: Array, point: Array, base_point: Array, parameters: MetricParameters
) -> Gradients:
    """Pull the derivative of a scalar by a logarithm back, without a search for it.

    Parameters
    ----------
    cotangent : array-like, shape=[..., B, 3, 3]
    tangent_vec : array-like, shape=[..., B, 3, 3]
        The logarithm of point.
    point, base_point : array-like, shape=[..., B, 3, 3]
    parameters : MetricParameters

    Returns
    -------
    gradients : Gradients
        Not finite, or huge, where the ends are conjugate.
    """
    frame = _Frame(tangent_vec, base_point, parameters)
    index = np.arange(len(frame.base))
    by = frame.geodesics.variations(index, np.ones(len(index)))
    by_vector = frame.flat(cotangent)
    by_velocity = frame.by_variation(by_vector, frame.base_matrices)
    by_end = _solved(np.moveaxis(by.by_velocity, -1, -2), by_velocity)
    by_initial = frame.by_carried_vector(by_vector) - _transposed(by.by_initial, by_end)
    return frame.gradients(
        0.5 * frame.matrices(by_end, frame.flat(point)),
        by_initial,
        -_transposed(by.by_metric, by_end),
        point.shape,
        base_point.shape,
    )


def pull_back_squared_dist(
    cotangent: Array, tangent_vec: Array, point: Array, base_point: Array, parameters: MetricParameters
) -> Gradients:
    """Pull the derivative of a scalar by the squared distance, shape=[...], back; see `pull_back_log`.

    By Gauss' lemma nothing is inverted, so that it is finite even where the ends are conjugate.
    """
    frame = _Frame(tangent_vec, base_point, parameters)
    index = np.arange(len(frame.base))
    by = frame.geodesics.variations(index, np.ones(len(index)))
    weight = np.broadcast_to(cotangent, frame.batch).reshape(-1, 1, 1)
    momentum = (parameters.matrices @ frame.velocity[..., None])[..., 0]
    by_end = 4.0 * weight * (by.by_initial @ momentum[..., None])[..., 0]
    # at a fixed velocity, by the moments and by a turn of the axes
    along = parameters.along_axes(frame.velocity)
    energy = parameters.moments * along
    explicit = np.concatenate([2.0 * (energy * along)[..., 1:], 4.0 * quat.cross(along, energy)], axis=-1)
    return frame.gradients(
        0.5 * frame.matrices(by_end, frame.flat(point)),
        -4.0 * weight * momentum,
        weight * explicit - _transposed(by.by_metric, by_end),
        point.shape,
        base_point.shape,
    )


class _Frame:
    """Tangent vectors at base points, as one batch of velocities in the frame where the metric is constant."""

    def __init__(self, tangent_vec: Array, base_point: Array, parameters: MetricParameters) -> None:
        self.parameters = parameters
        self.is_right = parameters.is_right[:, None, None]
        arrays = PoseMatrices((parameters.n_joints, 3, 3), parameters)
        base = arrays.read_points(base_point, "base_point")
        velocity = arrays.read_velocities(tangent_vec, base, "tangent_vec")
        self.batch = velocity.shape[:-2]
        self.base, self.velocity = mat.flat(base, self.batch, 2), mat.flat(velocity, self.batch, 2)
        self.base_matrices = quat.to_matrix(self.base)
        self.geodesics = PoseGeodesics(self.base, self.velocity, parameters)

    def flat(self, values: Array) -> Array:
        """Broadcast matrices, and make one axis of those of the batch."""
        return mat.flat(np.asarray(values, dtype=np.float64), self.batch, 3)

    def matrices(self, vectors: Array, points: Array) -> Array:
        """Return R hat(x) or hat(x) R."""
        hat = -np.cross(vectors[..., None, :], np.eye(3))
        return np.where(self.is_right, hat @ points, points @ hat)

    def by_variation(self, by_matrix: Array, points: Array) -> Array:
        """Return the derivative by x of a matrix that changes by R hat(x) or hat(x) R."""
        seen = self._seen(by_matrix, points)
        return seen[..., [2, 0, 1], [1, 2, 0]] - seen[..., [1, 2, 0], [2, 0, 1]]

    def by_fixed_vector(self, by_velocity: Array) -> Array:
        """Return the derivative by the variation of the base point, where the matrix of the vector stays."""
        inward = np.where(self.is_right[..., 0], -0.5, 0.5)
        return inward * quat.cross(by_velocity, self.velocity)

    def by_carried_vector(self, by_vector: Array) -> Array:
        """Return the derivative by the variation of the base point, where the velocity of the vector stays."""
        seen = self._seen(by_vector, self.base_matrices)
        turned = np.where(self.is_right, seen, np.moveaxis(seen, -1, -2)) @ self.velocity[..., None]
        return turned[..., 0] - np.trace(seen, axis1=-2, axis2=-1)[..., None] * self.velocity

    def gradients(
        self,
        by_vector: Array,
        by_initial: Array,
        by_metric: Array,
        vector_shape: tuple[int, ...],
        base_shape: tuple[int, ...],
    ) -> Gradients:
        """Sum over what was broadcast, and take the derivatives by alpha, beta and axes of those by their logarithms.

        Parameters
        ----------
        by_vector : array-like, shape=[n, B, 3, 3]
        by_initial : array-like, shape=[n, B, 3]
            By the variation of the base point.
        by_metric : array-like, shape=[n, B, 5]
        vector_shape, base_shape : tuple of int
        """
        total, parameters = by_metric.sum(axis=0), self.parameters
        by_axes = total[:, 2:]
        if parameters.axes is not None:
            by_axes = _transposed(left_jacobian(parameters.axes), by_axes)
        by_base = 0.5 * self.matrices(by_initial, self.base_matrices)
        whole = self.batch + by_base.shape[1:]
        return Gradients(
            _reduced(by_vector.reshape(whole), vector_shape),
            _reduced(by_base.reshape(whole), base_shape),
            total[:, 0] / parameters.alpha,
            total[:, 1] / parameters.beta,
            by_axes,
        )

    def _seen(self, by_matrix: Array, points: Array) -> Array:
        """See the derivative by a matrix in the frame where the metric is constant."""
        back = np.moveaxis(points, -1, -2)
        return np.where(self.is_right, by_matrix @ back, back @ by_matrix)


def _transposed(matrices: Array, vectors: Array) -> Array:
    """Return A^T x."""
    return (vectors[..., None, :] @ matrices)[..., 0, :]


def _solved(matrices: Array, vectors: Array) -> Array:
    """Return A^-1 x."""
    return np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0], dtype=np.float64)


def _reduced(values: Array, shape: tuple[int, ...]) -> Array:
    """Sum over the axes along which an array of a shape was broadcast."""
    extra = values.ndim - len(shape)
    repeated = [extra + i for i, size in enumerate(shape) if size == 1 and values.shape[extra + i] != 1]
    return values.sum(axis=(*range(extra), *repeated), keepdims=True).reshape(shape)
