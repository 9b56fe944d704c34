"""Geodesics of invariant metrics on SO(3)^B between given poses, or from a pose with a given velocity.

Every metric comes down to one problem, which the compiled kernels solve: a left-invariant metric with a diagonal
matrix, and a geodesic that starts at the identity.

* Left translations are isometries, so a segment from A to B is A times the one from the identity to A^-1 B.
* The right-invariant geodesic from A to B is the inverse of the left-invariant one from A^-1 to B^-1.
* For Z = P^T D P, conjugation R -> P R P^T carries the geodesics of Z to those of D.

Geodesics found by shooting need not be the shortest. One is certified when it is shorter than the injectivity radius,
which the largest sectional curvature bounds from below, or when it ends before its cut point. Otherwise its images
under the symmetries of the metric, and shots in all directions that a shortest one may take, lead to a certified one.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.end_velocities import EndVelocities
from geomstats_anim.geodesics.shortest import Effort, shortest_momenta
from geomstats_anim.kernels import frames as normal_form
from geomstats_anim.kernels import shooting as boundary_value
from geomstats_anim.kernels.rigid_body import playback
from geomstats_anim.kernels.sensitivity import pull_back
from geomstats_anim.kernels.threads import in_threads
from geomstats_anim.kernels.variations import vary
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array


class LogStatus(IntEnum):
    """Outcome of the search for a geodesic."""

    CONVERGED = boundary_value.CONVERGED
    STALLED = boundary_value.STALLED
    MAX_ITERATIONS = boundary_value.MAX_ITERATIONS

    def __str__(self) -> str:
        """Say what it means, and what to do."""
        return _SENTENCES[self]


_SENTENCES = {
    LogStatus.CONVERGED: "The geodesic was found; its end point is exact to rounding.",
    LogStatus.STALLED: (
        "No geodesic was found, because no step from any start came nearer to the end point; "
        "bring alpha and beta nearer to 1, or set a key in between."
    ),
    LogStatus.MAX_ITERATIONS: (
        "No geodesic was found in the number of shots allowed; bring alpha and beta nearer to 1, "
        "or set a key in between."
    ),
}


_REACH = 1e5
"""Largest angle, in radians, that a geodesic is followed: beyond, it takes seconds, and its end is lost in rounding."""


_BY_JOINT = ("initial", "velocity", "_momentum", "_inverse_moments", "_vector", "status", "residual", "iterations")
"""Attributes of `PoseGeodesics`, shape=[n, B, ...]; the vectors of targets are None where only velocities are given."""


class LogResult(NamedTuple):
    """Logarithms of a batch, each with its outcome.

    Attributes
    ----------
    tangent_vec : array-like, shape=[..., 3, 3]
        Initial velocities, at the base points; zero where none was found.
    status : array-like of int, shape=[...]
        `LogStatus` of each.
    residual : array-like, shape=[...]
        Miss of the end point in radians.
    length : array-like, shape=[...]
        Length of the geodesic in the metric; infinite where none was found.
    iterations : array-like of int, shape=[...]
        Shots taken in all.
    """

    tangent_vec: Array
    status: np.ndarray
    residual: Array
    length: Array
    iterations: np.ndarray


class Variations(NamedTuple):
    """Derivatives of poses along geodesics.

    Variations of poses are angular velocities in the frame where the metric is constant: the body's for a
    left-invariant joint, the parent's for a right-invariant one.

    Attributes
    ----------
    by_initial : array-like, shape=[F, B, 3, 3]
        By the variation of the initial pose, with the same velocity.
    by_velocity : array-like, shape=[F, B, 3, 3]
        By the velocity at parameter 0.
    by_metric : array-like, shape=[F, B, 3, 5]
        By log alpha, log beta, and a rotation vector that turns the axes from the left, P -> exp(v) P, at fixed
        velocity.
    """

    by_initial: Array
    by_velocity: Array
    by_metric: Array


class PoseGeodesics:
    """Batch of geodesics of one metric on SO(3)^B.

    Attributes
    ----------
    initial : array-like, shape=[n, B, 4]
        Unit quaternions at parameter 0.
    velocity : array-like, shape=[n, B, 3]
        Angular velocities at parameter 0, radians per unit of the parameter: in the body frame for a left-invariant
        joint, in the parent's frame for a right-invariant one.
    status : array-like of int, shape=[n, B]
        `LogStatus` of each; where none was found, it is the bi-invariant geodesic.
    residual : array-like, shape=[n, B]
        Miss of the end point in radians.
    iterations : array-like of int, shape=[n, B]
        Shots taken.
    """

    def __init__(self, initial: Array, velocity: Array, parameters: MetricParameters) -> None:
        """Start geodesics at `initial` with `velocity`; `between` joins two poses."""
        _refuse_beyond_reach(velocity, np.ones(1))
        self.initial, self.velocity, self.parameters = initial, velocity, parameters
        shape = initial.shape[:-1]
        self._vector: Array | None = None
        self.status = np.zeros(shape, dtype=np.intp)
        self.residual, self.iterations = np.zeros(shape), np.zeros(shape, dtype=np.intp)

    @cached_property
    def _inverse_moments(self) -> Array:
        return np.broadcast_to(1.0 / self.parameters.moments, self.velocity.shape)

    @cached_property
    def _momentum(self) -> Array:
        outward = np.where(self.parameters.is_right, -1.0, 1.0)[:, None]
        return self.parameters.along_axes(outward * self.velocity) / self._inverse_moments

    @cached_property
    def length(self) -> Array:
        """Return the length in the metric, shape=[n, B]; infinite where none was found."""
        length = np.sqrt((self._momentum**2 * self._inverse_moments).sum(axis=-1))
        return np.where(self.status == LogStatus.CONVERGED, length, np.inf)

    @classmethod
    def between(
        cls,
        initial: Array,
        end: Array,
        parameters: MetricParameters,
        near: Array | None = None,
        effort: Effort = "thorough",
    ) -> PoseGeodesics:
        """Find the shortest geodesics between poses.

        Parameters
        ----------
        initial, end : array-like, shape=[n, B, 4]
            Unit quaternions.
        parameters : MetricParameters
        near : array-like, shape=[n, B, 3]
            Velocities, as in the attribute, of those of a similar metric on the same side; not a number where none is
            known. They help where a guess is not enough.
            Optional, default: None.
        effort : str
            "thorough", or "quick", for learning: see `shortest_momenta`.
            Optional, default: "thorough".

        Returns
        -------
        geodesics : PoseGeodesics
            The end is at parameter 1.
        """
        outward = np.where(parameters.is_right, -1.0, 1.0)[:, None]
        vector = np.empty((*initial.shape[:2], 3))
        normal_form.targets(
            quat.plain(initial), quat.plain(end), parameters.is_right, parameters.axes_quaternions, vector
        )
        moments = np.broadcast_to(parameters.moments, vector.shape)
        start = None
        if near is not None:
            start = (moments * parameters.along_axes(outward * near)).reshape(-1, 3)
        found = shortest_momenta(moments.reshape(-1, 3), vector.reshape(-1, 3), start, effort)

        shape = vector.shape[:-1]
        converged = (found.status == boundary_value.CONVERGED).reshape(*shape, 1)
        momentum = np.where(converged, found.momentum.reshape(vector.shape), vector)
        inverse_moments = np.where(converged, 1.0 / moments, 1.0)
        geodesics = cls(initial, outward * parameters.from_axes(momentum * inverse_moments), parameters)
        geodesics._momentum, geodesics._inverse_moments = momentum, inverse_moments
        geodesics._vector = vector
        geodesics.status = found.status.reshape(shape)
        geodesics.residual, geodesics.iterations = found.residual.reshape(shape), found.shots.reshape(shape)
        return geodesics

    def at_joints(self, joints: np.ndarray) -> PoseGeodesics:
        """Take some joints, by their indices, shape=[J]."""
        other = copy(self)
        other.parameters = self.parameters.at(joints)
        for name in _BY_JOINT:
            values = getattr(self, name)
            setattr(other, name, None if values is None else values[:, joints])
        other.__dict__.pop("length", None)
        return other

    def with_joints(self, joints: np.ndarray, those: PoseGeodesics, parameters: MetricParameters) -> PoseGeodesics:
        """Replace some joints, by their indices, shape=[J], between the same poses; all together have the metric."""
        other = copy(self)
        other.parameters = parameters
        for name in _BY_JOINT:
            values = getattr(self, name)
            if values is not None:
                values = np.array(values)
                values[:, joints] = getattr(those, name)
            setattr(other, name, values)
        other.__dict__.pop("length", None)
        return other

    def __call__(self, index: np.ndarray, parameter: Array) -> Array:
        """Evaluate poses along the geodesics.

        Parameters
        ----------
        index : array-like of int, shape=[F]
            Which geodesic; must not decrease.
        parameter : array-like, shape=[F]
            Where on it, from 0 on; must not decrease within one geodesic.

        Returns
        -------
        rotations : array-like, shape=[F, B, 4]
            Unit quaternions.
        """
        return self.poses(index, self.turns(index, parameter))

    def turns(self, index: np.ndarray, parameter: Array) -> Array:
        """Evaluate the geodesics from the identity that stand for these, shape=[F, B, 4].

        They are those of the left-invariant metric with the diagonal matrix, seen along its principal axes.
        """
        turned = np.empty((len(parameter), self.initial.shape[1], 4))
        self._for_samples(playback, index, parameter, turned)
        return turned

    def poses(self, index: np.ndarray, turned: Array) -> Array:
        """Turn the geodesics' initial poses by what `turns` returns."""
        rotations = np.empty(turned.shape)
        parameters = self.parameters
        normal_form.poses(
            quat.plain(self.initial),
            np.array(index),
            quat.plain(turned),
            parameters.is_right,
            parameters.axes_quaternions,
            rotations,
        )
        return rotations

    def turn_rates(self, index: np.ndarray, turned: Array) -> tuple[Array, Array]:
        """Return the velocities and accelerations of what `turns` returned, along the principal axes.

        They are the body's, shape=[F, B, 3], per unit of the parameter and its square; see `EndVelocities`.
        """
        inverse = self._inverse_moments[index]
        momentum = quat.rotate(quat.conjugate(turned), self._momentum[index])
        velocity = inverse * momentum
        return velocity, inverse * quat.cross(momentum, velocity)

    def pose_rates(self, rotations: Array, rates: Array) -> Array:
        """See body velocities or accelerations of turns, shape=[F, B, 3], as those of the poses, shape=[F, B, 4]."""
        outward = self.parameters.from_axes(rates)
        # the inverse of a turn with the body velocity x moves a pose R with the body velocity -R^T x
        inward = -quat.rotate(quat.conjugate(rotations), outward)
        return np.where(self.parameters.is_right[:, None], inward, outward)

    def variations(self, index: np.ndarray, parameter: Array) -> Variations:
        """Differentiate poses along the geodesics by where they start, how fast, and by the metric.

        Parameters
        ----------
        index, parameter : array-like, shape=[F]
            As in a call.

        Returns
        -------
        variations : Variations
        """
        turned = self.turns(index, parameter)
        varied = np.zeros((*turned.shape[:2], 5, 3))
        self._for_samples(vary, index, parameter, varied)
        parameters, moments = self.parameters, self.parameters.moments
        by_momentum, by_moments = np.moveaxis(varied[:, :, :3], -1, -2), np.moveaxis(varied[:, :, 3:], -1, -2)
        velocity = parameters.along_axes(np.where(parameters.is_right, -1.0, 1.0)[:, None] * self.velocity)[index]
        by_velocity = by_momentum * moments[:, None]
        # at fixed velocity, the momentum grows with the moments
        by_moments = by_moments + by_velocity[..., 1:] * velocity[..., None, 1:]
        # a turn of the axes by v turns the velocity along them by v, and the turn itself from both sides
        hat = -np.cross(np.eye(3), velocity[..., None, :])
        by_axes = by_velocity @ hat + np.eye(3) - quat.to_matrix(quat.conjugate(turned))
        by_metric = np.concatenate([by_moments, by_axes], axis=-1)

        axes = quat.to_matrix(parameters.axes_quaternions)
        back = np.moveaxis(axes, -1, -2)
        outward = np.where(parameters.is_right, -1.0, 1.0)[:, None, None]
        turn = quat.multiply(quat.conjugate(parameters.axes_quaternions), turned)
        turn = quat.multiply(turn, np.broadcast_to(parameters.axes_quaternions, turn.shape))
        return Variations(quat.to_matrix(quat.conjugate(turn)), back @ by_velocity @ axes, outward * (back @ by_metric))

    def pull_back(self, index: np.ndarray, parameter: Array, rotations: Array, cotangent: Array) -> Array:
        """Pull the derivative of a scalar by poses back to one by the metric, the end poses fixed.

        Parameters
        ----------
        index, parameter : array-like, shape=[F]
            As in a call.
        rotations : array-like, shape=[F, B, 4]
            What the call returned.
        cotangent : array-like, shape=[F, B, 3]
            Derivative of the scalar by the body variation of the rotations.

        Returns
        -------
        gradient : array-like, shape=[B, 5]
            By log alpha, log beta, and a rotation vector that turns the axes from the left, P -> exp(v) P.
        """
        return self.pull_back_turns(index, parameter, self.pull_back_poses(rotations, cotangent))

    def pull_back_poses(self, rotations: Array, cotangent: Array) -> Array:
        """Pull a derivative by what `poses` returned, at fixed axes, back to one by what it was given."""
        out = np.empty(cotangent.shape)
        parameters = self.parameters
        normal_form.inward(
            quat.plain(rotations), quat.plain(cotangent), parameters.is_right, parameters.axes_quaternions, out
        )
        return out

    def pull_back_turns(
        self, index: np.ndarray, parameter: Array, cotangent: Array, partial: Array | None = None
    ) -> Array:
        """Pull a derivative by what `turns` returned back to one by the metric, shape=[B, 5], as in `pull_back`.

        Parameters
        ----------
        index, parameter : array-like, shape=[F]
        cotangent : array-like, shape=[F, B, 3]
            Derivative by the body variation of the turns, along the principal axes.
        partial : array-like, shape=[n, B, 8]
            Derivatives of other parts of the scalar by the initial momentum, by log alpha and log beta at fixed
            momentum, and by a turn of the axes at fixed momentum.
            Optional, default: None, there are no other parts.
        """
        sums = np.zeros((*self.initial.shape[:2], 8)) if partial is None else partial
        gradient = np.zeros((*self.initial.shape[:2], 5))
        self._for_samples(pull_back, index, parameter, cotangent, sums.reshape(-1, 8), gradient.reshape(-1, 5))
        # a fallback is the bi-invariant geodesic, which does not depend on the metric
        return np.where((self.status == LogStatus.CONVERGED)[..., None], gradient, 0.0).sum(axis=0)

    @property
    def end_velocities(self) -> EndVelocities:
        """Return the velocities of what `turns` returns, at parameters 0 and 1."""
        n = len(self.initial)
        turn = self.turns(np.arange(n), np.ones(n)) if self._vector is None else quat.exp(self._vector)
        return EndVelocities(self._inverse_moments, self._momentum, turn)

    def _for_samples(
        self,
        kernel: Callable[..., None],
        index: np.ndarray,
        parameter: Array,
        samples: Array,
        *geodesics: Array,
    ) -> None:
        """Run a compiled kernel over all geodesics, with the samples that lie on each, in threads."""
        _refuse_beyond_reach(self.velocity, parameter)
        n, n_joints = self.initial.shape[:2]
        first = np.searchsorted(index, np.arange(n), side="left").repeat(n_joints)
        last = np.searchsorted(index, np.arange(n), side="right").repeat(n_joints)
        column = np.tile(np.arange(n_joints), n)
        # copies: for arrays that are read-only or of another type, the kernel would be compiled once more
        inverse, momentum, parameter = (
            np.array(values, dtype=np.float64, order="C")
            for values in (self._inverse_moments, self._momentum, parameter)
        )
        inverse, momentum = inverse.reshape(-1, 3), momentum.reshape(-1, 3)

        def run(part: slice) -> None:
            own = (values[part] for values in geodesics)
            kernel(inverse[part], momentum[part], first[part], last[part], parameter, column[part], samples, *own)

        in_threads(run, n * n_joints)


def _refuse_beyond_reach(velocity: Array, parameter: Array) -> None:
    """Raise if geodesics of these velocities, shape=[..., 3], turn too far, or are not finite."""
    angle = float(np.abs(velocity).max(initial=0.0)) * float(np.max(parameter, initial=0.0))
    if not angle <= _REACH:
        raise ValueError(f"A geodesic turns by {angle:.3g} radians, but at most {_REACH:g} can be followed.")
