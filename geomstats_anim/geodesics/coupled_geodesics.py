r"""Geodesics of metrics that couple joints, between key poses, and their derivative by the metric.

A right-invariant joint is seen by its inverse, as in `pose_geodesics`, so that all joints are left-invariant and start
at the identity. The cometric is :math:`C = diag(Z_b^{-1}) + V V^T`, of low rank beside a matrix for each joint.

Along a segment, what is smooth is known at Chebyshev's nodes. With the variations X by the momentum m, those by the
starting pose are :math:`\Phi = g^T + X \hat m`, since a turn of space is an isometry, and those by the metric are
:math:`x(t) = \Phi(t) \int_0^t \Phi^{-1} (dC\, M + C g^T dm)`, where M = g^T m. The end pose is fixed, which gives dm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from geomstats_anim import rotations as quat
from geomstats_anim.geodesics import coupled
from geomstats_anim.geodesics.pose_geodesics import LogStatus, PoseGeodesics
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.kernels import frames as normal_form
from geomstats_anim.parameters import MetricParameters
from geomstats_anim.rotations import Array

_FEWEST_NODES, _MOST_NODES = 24, 192
_RESOLVED = 1e-11
"""Largest last coefficients of a geodesic that is resolved by its nodes."""


class CoupledGeodesics:
    """Batch of geodesics between poses, from parameter 0 to 1.

    Parameters
    ----------
    initial, end : array-like, shape=[n, B, 4]
        Unit quaternions.
    parameters : MetricParameters
        The matrix of each joint by itself.
    coupling : array-like, shape=[B, 3, r]
        V: velocities of all joints that come together, the body's of left-invariant joints, and the parent's of
        right-invariant ones.
    near : array-like, shape=[n, B, 3]
        Velocities of geodesics of a similar metric; not a number where none is known.
        Optional, default: None, those of the shortest geodesics without the coupling.
    effort : str
        As in `coupled.shoot`.
        Optional, default: "thorough".

    Attributes
    ----------
    velocity : array-like, shape=[n, B, 3]
        At parameter 0, in the same frames.
    status : array-like of int, shape=[n, B]
        `LogStatus`; where none was found, joints that are coupled follow bi-invariant geodesics.
    """

    def __init__(
        self,
        initial: Array,
        end: Array,
        parameters: MetricParameters,
        coupling: Array,
        near: Array | None = None,
        effort: Effort = "thorough",
    ) -> None:
        self.initial, self.parameters = initial, parameters
        self._outward = np.where(parameters.is_right, -1.0, 1.0)[:, None]
        self._coupling = self._outward[:, None] * coupling
        self._cometric = cometric(parameters, self._coupling)
        self._target = np.where(
            parameters.is_right[:, None],
            quat.multiply(initial, quat.conjugate(end)),
            quat.multiply(quat.conjugate(initial), end),
        )
        found = self._shoot(initial, end, near, effort)
        self.status, self._momentum = found.status, found.momentum
        self._is_found = (found.status == LogStatus.CONVERGED)[..., None]
        self.velocity = self._outward * self._velocities(found.momentum, np.arange(len(initial)))

    def _shoot(self, initial: Array, end: Array, near: Array | None, effort: Effort) -> coupled.Shots:
        """Start from similar geodesics, and where that does not arrive from the shortest without the coupling."""
        left, found = np.arange(len(initial)), None
        if near is not None:
            found = coupled.shoot(self._cometric, self._target, self._outward * near, "quick")
            left = np.flatnonzero(found.status.any(axis=1))
            if not len(left):
                return found
        product = PoseGeodesics.between(initial[left], end[left], self.parameters).velocity
        again = coupled.shoot(self._cometric, self._target[left], self._outward * product, effort)
        if found is None:
            return again
        for values, mine in zip(found, again, strict=True):
            values[left] = mine
        return found

    @cached_property
    def _nodes(self) -> Nodes:
        """Return nodes, and the turns there, shape=[n, N, B, 4], as an attribute."""
        momentum = np.where(self._is_found, self._momentum, 0.0)
        vector = quat.log(self._target)
        nodes = Nodes(_FEWEST_NODES)
        while True:
            turns = coupled.flow(self._cometric, momentum, nodes.times)
            turns = np.where(self._is_found[:, None], turns, quat.exp(nodes.times[:, None, None] * vector[:, None]))
            turns[:, -1] = (
                np.where((turns[:, -1:] * self._target[:, None]).sum(-1, keepdims=True) < 0.0, -1.0, 1.0)[:, 0]
                * self._target
            )
            if nodes.size >= _MOST_NODES or nodes.roughness(turns) <= _RESOLVED:
                nodes.turns = turns
                return nodes
            nodes = Nodes(2 * nodes.size)

    def _velocities(self, body: Array, index: np.ndarray) -> Array:
        """Return velocities for body momenta, shape=[F, B, 3], of segments; of those not found, the bi-invariant."""
        velocity = (body.reshape(len(body), -1) @ self._cometric).reshape(body.shape)
        return np.where(self._is_found[index], velocity, quat.log(self._target)[index])

    def turns(self, index: np.ndarray, parameter: Array) -> Array:
        """Evaluate the geodesics from the identity that stand for these, shape=[F, B, 4]."""
        return quat.normalize(self._nodes.at(parameter, index, self._nodes.turns))

    def poses(self, index: np.ndarray, turned: Array) -> Array:
        """Turn the geodesics' initial poses by what `turns` returns."""
        start = self.initial[index]
        right = quat.multiply(quat.conjugate(turned), start)
        return np.where(self.parameters.is_right[:, None], right, quat.multiply(start, turned))

    def turn_rates(self, index: np.ndarray, turned: Array) -> tuple[Array, Array]:
        """Return body velocities and accelerations of what `turns` returned, shape=[F, B, 3]."""
        body = quat.rotate(quat.conjugate(turned), self._momentum[index])
        velocity = self._velocities(body, index)
        acceleration = (quat.cross(body, velocity).reshape(len(body), -1) @ self._cometric).reshape(body.shape)
        return velocity, np.where(self._is_found[index], acceleration, 0.0)

    def pose_rates(self, rotations: Array, rates: Array) -> Array:
        """See body velocities or accelerations of turns, shape=[F, B, 3], as those of the poses, shape=[F, B, 4]."""
        inward = -quat.rotate(quat.conjugate(rotations), rates)
        return np.where(self.parameters.is_right[:, None], inward, rates)

    @property
    def end_velocities(self) -> CoupledEndVelocities:
        """Return the velocities of what `turns` returns, at parameters 0 and 1."""
        return CoupledEndVelocities(self)

    def pull_back_poses(self, rotations: Array, cotangent: Array) -> Array:
        """Pull a derivative by what `poses` returned back to one by what it was given, shape=[F, B, 3]."""
        out = np.empty(cotangent.shape)
        axes = np.tile(quat.IDENTITY, (self.parameters.n_joints, 1))
        normal_form.inward(quat.plain(rotations), quat.plain(cotangent), self.parameters.is_right, axes, out)
        return out

    def pull_back_turns(
        self, index: np.ndarray, parameter: Array, cotangent: Array, partial: Partial | None = None
    ) -> Array:
        """Pull a derivative by what `turns` returned back to one by the metric, the end poses fixed.

        Parameters
        ----------
        index, parameter : array-like, shape=[F]
        cotangent : array-like, shape=[F, B, 3]
            Derivative by the body variation of the turns.
        partial : Partial
            Derivatives of other parts of the scalar.
            Optional, default: None, there are no other parts.

        Returns
        -------
        gradient : array-like, shape=[B, 5 + 3 r]
            By log alpha, log beta, a rotation vector that turns the axes from the left, and the coupling.
        """
        n, n_joints = self.initial.shape[:2]
        by_cometric, by_momentum = np.zeros((3 * n_joints,) * 2), np.zeros((n, n_joints, 3))
        if partial is not None:
            by_cometric += partial.cometric
            by_momentum += partial.momentum
        at_nodes = self._nodes.gather(parameter, index, cotangent, n)
        for joints in coupled.components(self._cometric):
            found = np.flatnonzero(self._is_found[:, joints[0], 0])
            rows = (3 * joints[:, None] + np.arange(3)).ravel()
            by_cometric[np.ix_(rows, rows)] += self._pull_back_together(
                joints, found, at_nodes[found][:, :, joints], by_momentum[found][:, joints]
            )
        return self._by_parameters(by_cometric)

    def _pull_back_together(self, joints: np.ndarray, found: np.ndarray, at_nodes: Array, by_momentum: Array) -> Array:
        """Return the derivative by the cometric of joints that are coupled; segments that were not found have none."""
        size, nodes = 3 * len(joints), self._nodes
        if not len(found) or not (at_nodes.any() or by_momentum.any()):
            return np.zeros((size, size))
        momentum = self._momentum[found][:, joints]
        cometric = coupled.block(self._cometric, joints)
        varied = coupled.variations(cometric, momentum, nodes.times)
        back = quat.conjugate(nodes.turns[found][:, :, joints])
        body = quat.rotate(back, momentum[:, None]).reshape(len(found), nodes.size, size)
        flat = at_nodes.reshape(len(found), nodes.size, size)
        # the end is fixed: its variation by the momentum undoes that by the metric
        by_momentum = by_momentum.reshape(len(found), size) + np.einsum("nqij,nqi->nj", varied, flat)
        flat = flat.copy()
        flat[:, -1] -= np.linalg.solve(np.swapaxes(varied[:, -1], -1, -2), by_momentum[..., None])[..., 0]
        by_start = varied @ _blocks(_hat(momentum))[:, None] + _blocks(quat.to_matrix(back))
        later = np.einsum("qp,nqji,nqj->npi", nodes.integral, by_start, flat)
        rates = np.linalg.solve(np.swapaxes(by_start, -1, -2), later[..., None])[..., 0]
        product = np.einsum("nqi,nqj->ij", rates, body)
        return 0.5 * (product + product.T)

    def _by_parameters(self, by_cometric: Array) -> Array:
        """Return the derivative by log alpha, log beta, a turn of the axes and the coupling, shape=[B, 5 + 3 r]."""
        parameters, (n_joints, _, rank) = self.parameters, self._coupling.shape
        joint = np.arange(n_joints)
        axes = quat.to_matrix(parameters.axes_quaternions)
        blocks = by_cometric.reshape(n_joints, 3, n_joints, 3)[joint, :, joint]
        along = axes @ blocks @ np.swapaxes(axes, -1, -2)
        inverse = 1.0 / parameters.moments
        by_moments = -inverse[:, 1:] * along[:, [1, 2], [1, 2]]
        # P -> exp(v) P turns the matrix along the axes by (D hat(v) - hat(v) D)
        skew = along * inverse[:, None, :] - inverse[:, :, None] * along
        by_axes = -2.0 * np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1)
        by_coupling = 2.0 * by_cometric @ self._coupling.reshape(3 * n_joints, rank)
        by_coupling = self._outward[:, None] * by_coupling.reshape(n_joints, 3, rank)
        return np.concatenate([by_moments, by_axes, by_coupling.reshape(n_joints, -1)], axis=-1)


@dataclass
class Partial:
    """Derivatives of a scalar by the cometric, shape=[3B, 3B], and by the initial momentum, shape=[n, B, 3]."""

    cometric: Array
    momentum: Array


class CoupledEndVelocities:
    """Velocities and accelerations of coupled geodesics at both ends; see `EndVelocities`, whose attributes it has."""

    def __init__(self, geodesics: CoupledGeodesics) -> None:
        n = len(geodesics.initial)
        self._geodesics, index = geodesics, np.arange(n)
        identity = np.broadcast_to(quat.IDENTITY, geodesics.initial.shape)
        self._end_turn = geodesics._target
        self.start, self.start_acceleration = geodesics.turn_rates(index, identity)
        self.end, self.end_acceleration = geodesics.turn_rates(index, self._end_turn)

    def pull_back(self, start: Array, end: Array, start_acceleration: Array, end_acceleration: Array) -> Partial:
        """Pull a derivative by the attributes, shape=[n, B, 3] each, back to one by the cometric and the momentum."""
        momentum = self._geodesics._momentum
        body = quat.rotate(quat.conjugate(self._end_turn), momentum)
        at_start = self._by_body_momentum(momentum, self.start, start, start_acceleration)
        at_end = self._by_body_momentum(body, self.end, end, end_acceleration)
        by_momentum = at_start.momentum + quat.rotate(self._end_turn, at_end.momentum)
        return Partial(at_start.cometric + at_end.cometric, by_momentum)

    def _by_body_momentum(self, body: Array, velocity: Array, by_velocity: Array, by_acceleration: Array) -> Partial:
        """Derive w = C M and w' = C (M x w) by the body momentum M and by C."""
        is_found, cometric = self._geodesics._is_found, self._geodesics._cometric
        by_velocity, by_acceleration = (np.where(is_found, values, 0.0) for values in (by_velocity, by_acceleration))

        def flat(values: Array) -> Array:
            return values.reshape(len(values), -1)

        scaled = (flat(by_acceleration) @ cometric).reshape(body.shape)
        # (M x w) . n = M . (w x n) = w . (n x M)
        by_velocity = by_velocity + quat.cross(scaled, body)
        by_body = quat.cross(velocity, scaled) + (flat(by_velocity) @ cometric).reshape(body.shape)
        product = flat(by_velocity).T @ flat(body) + flat(by_acceleration).T @ flat(quat.cross(body, velocity))
        return Partial(0.5 * (product + product.T), by_body)


class Nodes:
    """Chebyshev's nodes from 0 to 1, both ends included, and what is done with values there.

    Attributes
    ----------
    times : array-like, shape=[N]
    integral : array-like, shape=[N, N]
        From values to their integrals from 0 to each node.
    """

    turns: Array

    def __init__(self, size: int) -> None:
        self.size = size
        places = -np.cos(np.pi * np.arange(size) / (size - 1))
        self.times = 0.5 * (1.0 + places)
        values = chebyshev.chebvander(places, size - 1)
        self._coefficients = np.linalg.inv(values)
        antiderivatives = chebyshev.chebint(np.eye(size), lbnd=-1.0, axis=0)
        self.integral = 0.5 * chebyshev.chebvander(places, size) @ antiderivatives @ self._coefficients

    def roughness(self, values: Array) -> float:
        """Return the largest of the last two coefficients of values, shape=[n, N, ...]."""
        return float(np.abs(np.tensordot(self._coefficients[-2:], values, (1, 1))).max(initial=0.0))

    def at(self, parameter: Array, index: np.ndarray, values: Array) -> Array:
        """Interpolate values, shape=[n, N, B, k], of segments at parameters, shape=[F, B, k]."""
        weights, out = self._weights(parameter), np.empty((len(parameter), *values.shape[2:]))
        for k, span in _spans(index, len(values)):
            out[span] = np.tensordot(weights[span], values[k], 1)
        return out

    def gather(self, parameter: Array, index: np.ndarray, cotangent: Array, n: int) -> Array:
        """Pull the derivative by what `at` returned back to one by the values, shape=[n, N, B, k]."""
        weights, out = self._weights(parameter), np.zeros((n, self.size, *cotangent.shape[1:]))
        for k, span in _spans(index, n):
            out[k] = np.tensordot(weights[span].T, cotangent[span], 1)
        return out

    def _weights(self, parameter: Array) -> Array:
        return np.asarray(chebyshev.chebvander(2.0 * parameter - 1.0, self.size - 1) @ self._coefficients)


def cometric(parameters: MetricParameters, coupling: Array) -> Array:
    """Return the inverse, shape=[3B, 3B], of the matrix of a metric: a block for each joint, and the coupling's square.

    Parameters
    ----------
    parameters : MetricParameters
    coupling : array-like, shape=[B, 3, r]
    """
    axes = quat.to_matrix(parameters.axes_quaternions)
    blocks = np.swapaxes(axes, -1, -2) @ (axes / parameters.moments[:, :, None])
    flat = coupling.reshape(3 * len(coupling), -1)
    return np.asarray(_blocks(blocks) + flat @ flat.T)


def _spans(index: np.ndarray, n: int) -> Sequence[tuple[int, Any]]:
    """Return the segments that have samples, and the slices of these, as the index does not decrease."""
    bounds = np.searchsorted(index, np.arange(n + 1))
    return [(k, slice(bounds[k], bounds[k + 1])) for k in np.flatnonzero(np.diff(bounds))]


def _hat(vectors: Array) -> Array:
    """Return the matrices, shape=[..., 3, 3], of x -> v x x."""
    return np.swapaxes(quat.cross(vectors[..., None, :], np.eye(3)), -1, -2)


def _blocks(blocks: Array) -> Array:
    """Return block-diagonal matrices, shape=[..., 3B, 3B], of blocks, shape=[..., B, 3, 3]."""
    n = blocks.shape[-3]
    joint, whole = np.arange(n), np.zeros((*blocks.shape[:-3], n, 3, n, 3))
    whole[..., joint, :, joint, :] = np.moveaxis(blocks, -3, 0)
    return whole.reshape(*blocks.shape[:-3], 3 * n, 3 * n)
