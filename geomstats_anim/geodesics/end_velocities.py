"""Velocities and accelerations of geodesics at both ends, which a spline bends to meet those of its neighbours."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array


class EndVelocities:
    r"""Velocities and accelerations of geodesics from the identity at both ends, and their derivative by the metric.

    With the inverse moments :math:`D^{-1}`, the spatial momentum m and the body momentum M, which is m at the start and
    :math:`g(1)^T m` at the end, :math:`w = D^{-1} M` and by Euler's equation :math:`w' = D^{-1} (M \times w)`.

    Attributes
    ----------
    start, end : array-like, shape=[n, B, 3]
        Along the principal axes, radians per unit of the parameter.
    start_acceleration, end_acceleration : array-like, shape=[n, B, 3]
    """

    def __init__(self, inverse_moments: Array, momentum: Array, turn: Array) -> None:
        self._inverse, self._momentum, self._turn = inverse_moments, momentum, turn
        self._end_momentum = quat.rotate(quat.conjugate(turn), momentum)
        self.start, self.end = inverse_moments * momentum, inverse_moments * self._end_momentum
        self.start_acceleration = inverse_moments * quat.cross(momentum, self.start)
        self.end_acceleration = inverse_moments * quat.cross(self._end_momentum, self.end)

    def pull_back(self, start: Array, end: Array, start_acceleration: Array, end_acceleration: Array) -> Array:
        """Pull a derivative by the attributes back; see `partial` of `PoseGeodesics.pull_back_turns`."""
        by_momentum, by_moments = self._by_body_momentum(self._momentum, self.start, start, start_acceleration)
        by_end, by_moments_at_end = self._by_body_momentum(self._end_momentum, self.end, end, end_acceleration)
        by_end_in_space = quat.rotate(self._turn, by_end)
        # a turn of the axes turns the target, so that the end momentum changes at fixed m
        by_axes = quat.cross(self._end_momentum, by_end) - quat.cross(self._momentum, by_end_in_space)
        by_moments = by_moments + by_moments_at_end
        return np.concatenate([by_momentum + by_end_in_space, by_moments[..., 1:], by_axes], axis=-1)

    def _by_body_momentum(
        self, momentum: Array, velocity: Array, by_velocity: Array, by_acceleration: Array
    ) -> tuple[Array, Array]:
        """Derive by the body momentum, and by the logarithms of the moments at fixed momentum."""
        scaled = self._inverse * by_acceleration
        # (M x w) . n = M . (w x n) = w . (n x M)
        by_velocity = by_velocity + quat.cross(scaled, momentum)
        by_momentum = quat.cross(velocity, scaled) + self._inverse * by_velocity
        return by_momentum, -(velocity * by_velocity + quat.cross(momentum, velocity) * scaled)
