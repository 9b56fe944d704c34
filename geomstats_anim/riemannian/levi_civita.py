r"""Levi-Civita connection and curvature of invariant metrics, on velocities in the frame where the metric is constant.

For a left-invariant metric Z, :math:`\nabla_a b = (a \times b + Z^{-1} (a \times Z b + b \times Z a)) / 2` (Arnold,
"Sur la geometrie differentielle des groupes de Lie de dimension infinie", 1966); inversion of the group carries it to a
right-invariant one, with the other sign. In three dimensions the principal axes diagonalize the curvature (Milnor,
"Curvatures of left invariant metrics on Lie groups", 1976, section 4). Every array is of velocities, shape=[..., B, 3].
"""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array


def connection(parameters: MetricParameters, first: Array, second: Array) -> Array:
    """Return the covariant derivative of an invariant field along another."""
    moments = parameters.moments
    a, b = parameters.along_axes(first), parameters.along_axes(second)
    inertial = (quat.cross(a, moments * b) + quat.cross(b, moments * a)) / moments
    outward = np.where(parameters.is_right, -0.5, 0.5)[:, None]
    return outward * parameters.from_axes(quat.cross(a, b) + inertial)


def principal_curvatures(parameters: MetricParameters) -> Array:
    """Return the sectional curvatures, shape=[B, 3], in Z, of the planes across the principal axes."""
    moments = parameters.moments
    structure = moments / np.sqrt(moments.prod(axis=-1, keepdims=True))
    mu = 0.5 * structure.sum(axis=-1, keepdims=True) - structure
    return structure * mu - np.roll(mu, -1, axis=-1) * np.roll(mu, -2, axis=-1)


def curvature(parameters: MetricParameters, first: Array, second: Array, third: Array) -> Array:
    r"""Return :math:`\nabla_{[a,b]} c - \nabla_a \nabla_b c + \nabla_b \nabla_a c`."""
    roots = np.sqrt(parameters.moments)
    a, b, c = (roots * parameters.along_axes(vector) for vector in (first, second, third))
    return parameters.from_axes(quat.cross(principal_curvatures(parameters) * quat.cross(a, b), c) / roots)


def curvature_derivative(
    parameters: MetricParameters, along: Array, first: Array, second: Array, third: Array
) -> Array:
    """Return the covariant derivative of the curvature, applied to three vectors."""

    def moved(vector: Array) -> Array:
        return connection(parameters, along, vector)

    return (
        moved(curvature(parameters, first, second, third))
        - curvature(parameters, moved(first), second, third)
        - curvature(parameters, first, moved(second), third)
        - curvature(parameters, first, second, moved(third))
    )


def ricci(parameters: MetricParameters) -> Array:
    """Return the matrices of the Ricci curvature of each joint, shape=[B, 3, 3]."""
    across = principal_curvatures(parameters)
    values = parameters.moments * (across.sum(axis=-1, keepdims=True) - across)
    axes = quat.to_matrix(parameters.axes_quaternions)
    return np.moveaxis(axes, -1, -2) @ (values[:, :, None] * axes)
