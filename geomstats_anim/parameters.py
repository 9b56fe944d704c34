"""The parameters of a metric on the pose Lie group, one matrix and one side per joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.names import BENT, INVARIANCES, MAX_TENSION
from geomstats_anim.rotations import Array

MAX_CONDITION = 1e4
"""Largest ratio of principal moments: beyond, a body tumbles so fast that its geodesics take seconds each."""


@dataclass(frozen=True, eq=False)
class MetricParameters:
    r"""An invariant metric on SO(3)^B.

    The metric of joint b has the matrix :math:`Z_b = P_b^T diag(1, \alpha_b, \beta_b) P_b` at the identity (Kushner,
    Modi, Miolane, "Learning Riemannian metrics for interpolating animations", eq. 4; P is the identity there), moved
    around by left or by right translations. Geodesics do not depend on the scale of a matrix, so the first entry is 1.

    Parameters
    ----------
    alpha, beta : array-like, shape=[B]
        Positive. One number each makes a metric of one joint.
    axes : array-like, shape=[B, 3]
        Rotation vectors of P, radians.
        Optional, default: None, all matrices diagonal.
    invariance : str or sequence of str, shape=[B]
        "left" or "right", for all joints or one per joint.
        Optional, default: "left".

    Raises
    ------
    ValueError
        If alpha or beta is not positive, the condition number is above `MAX_CONDITION`, the sizes do not fit, or a
        side is neither left nor right.

    Examples
    --------
    >>> from geomstats_anim import MetricParameters
    >>> MetricParameters(alpha=[2.0, 1.0], beta=[0.5, 1.0], invariance=["left", "right"]).matrices[0]
    array([[1. , 0. , 0. ],
           [0. , 2. , 0. ],
           [0. , 0. , 0.5]])
    """

    alpha: Array
    beta: Array
    axes: Array | None = None
    invariance: tuple[str, ...] = ("left",)

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        alpha = np.atleast_1d(np.array(self.alpha, dtype=np.float64))
        beta = np.atleast_1d(np.array(self.beta, dtype=np.float64))
        if alpha.ndim != 1 or alpha.shape != beta.shape:
            raise ValueError(f"alpha has shape {alpha.shape} and beta {beta.shape}; one number per joint is needed.")
        for name, values in (("alpha", alpha), ("beta", beta)):
            bad = np.flatnonzero(~(np.isfinite(values) & (values > 0.0)))
            if len(bad):
                raise ValueError(f"{name} of joint {bad[0]} is {values[bad[0]]}, but it must be a positive number.")
        moments = np.stack([np.ones_like(alpha), alpha, beta])
        with np.errstate(over="ignore"):  # infinite is too large as well
            condition = moments.max(axis=0) / moments.min(axis=0)
        bad = np.flatnonzero(condition > MAX_CONDITION)
        if len(bad):
            raise ValueError(
                f"The metric of joint {bad[0]} has the condition number {condition[bad[0]]:.4g}, but geodesics are "
                f"found up to {MAX_CONDITION:g}; bring alpha and beta nearer to 1."
            )
        sides = (self.invariance,) * len(alpha) if isinstance(self.invariance, str) else tuple(self.invariance)
        sides = sides * len(alpha) if len(sides) == 1 else sides
        if len(sides) != len(alpha):
            raise ValueError(f"invariance has {len(sides)} words, but there are {len(alpha)} joints.")
        for joint, side in enumerate(sides):
            if side not in INVARIANCES:
                raise ValueError(f'invariance of joint {joint} is {side!r}, but it must be "left" or "right".')
        axes = None
        if self.axes is not None:
            axes = np.array(self.axes, dtype=np.float64)
            if axes.shape != (len(alpha), 3) or not np.isfinite(axes).all():
                raise ValueError(f"axes has shape {axes.shape}; finite numbers of shape ({len(alpha)}, 3) are needed.")
            axes.setflags(write=False)
        alpha.setflags(write=False)
        beta.setflags(write=False)
        for name, value in (("alpha", alpha), ("beta", beta), ("axes", axes), ("invariance", sides)):
            object.__setattr__(self, name, value)

    @classmethod
    def identity(cls, n_joints: int) -> MetricParameters:
        """Return the bi-invariant metric, whose geodesics are slerp."""
        return cls(np.ones(n_joints), np.ones(n_joints))

    @classmethod
    def from_matrices(cls, matrices: ArrayLike, invariance: str | Sequence[str] = "left") -> MetricParameters:
        """Find the parameters whose matrices are multiples of the given ones, and whose geodesics are theirs.

        Parameters
        ----------
        matrices : array-like, shape=[B, 3, 3]
            Symmetric positive definite.
        invariance : str or sequence of str
            Optional, default: "left".

        Returns
        -------
        parameters : MetricParameters

        Raises
        ------
        ValueError
            If a matrix is not symmetric positive definite.
        """
        matrices = np.array(matrices, dtype=np.float64)
        if matrices.ndim != 3 or matrices.shape[1:] != (3, 3):
            raise ValueError(f"matrices has shape {matrices.shape}, but (B, 3, 3) is needed.")
        if not np.isfinite(matrices).all():
            raise ValueError("matrices has a value that is not finite.")
        scale = np.abs(matrices).max(axis=(-2, -1), initial=0.0)[:, None, None]
        skewed = np.flatnonzero((np.abs(matrices - np.moveaxis(matrices, -1, -2)) > 1e-8 * scale).any(axis=(-2, -1)))
        if len(skewed):
            raise ValueError(f"The matrix of joint {skewed[0]} is not symmetric.")
        off_diagonal = matrices[:, [0, 0, 1], [1, 2, 2]]
        if not off_diagonal.any():
            moments, axes = matrices[:, [0, 1, 2], [0, 1, 2]], None
        else:
            moments, columns = np.linalg.eigh(matrices)
            # P must be a rotation: its rows are the eigenvectors, one of them turned round where it is a reflection.
            columns[np.linalg.det(columns) < 0.0, :, 0] *= -1.0
            axes = quat.log(quat.from_matrix(np.moveaxis(columns, -1, -2)))
        bad = np.flatnonzero((moments <= 0.0).any(axis=-1))
        if len(bad):
            raise ValueError(
                f"The matrix of joint {bad[0]} has the eigenvalue {moments[bad[0]].min():.6g}; it must be positive."
            )
        return cls(moments[:, 1] / moments[:, 0], moments[:, 2] / moments[:, 0], axes, tuple(np.atleast_1d(invariance)))

    def __str__(self) -> str:
        """Say how many joints there are, on which side, the range of alpha and beta, and whether axes are turned."""
        n_right = int(self.is_right.sum())
        sides = {0: "left", self.n_joints: "right"}.get(n_right, f"{self.n_joints - n_right} left, {n_right} right")
        words = [f"{self.n_joints} joint{'s' * (self.n_joints != 1)}", sides]
        for name, values in (("alpha", self.alpha), ("beta", self.beta)):
            low, high = f"{values.min(initial=np.inf):.3g}", f"{values.max(initial=0.0):.3g}"
            words.append(f"{name} {low}" if low == high else f"{name} {low} to {high}")
        if self.axes is not None:
            words.append("turned axes")
        return ", ".join(words)

    @property
    def n_joints(self) -> int:
        """Return the number of joints, B."""
        return len(self.alpha)

    @cached_property
    def moments(self) -> Array:
        """Return the principal moments (1, alpha, beta), shape=[B, 3]."""
        return np.stack([np.ones_like(self.alpha), self.alpha, self.beta], axis=-1)

    @cached_property
    def axes_quaternions(self) -> Array:
        """Return the rotations P as unit quaternions, shape=[B, 4]."""
        if self.axes is None:
            return np.tile(quat.IDENTITY, (self.n_joints, 1))
        return quat.exp(self.axes)

    def along_axes(self, vectors: Array) -> Array:
        """See vectors of the joints, shape=[..., B, 3], along the principal axes."""
        return vectors if self.axes is None else quat.rotate(self.axes_quaternions, vectors)

    def from_axes(self, vectors: Array) -> Array:
        """Undo `along_axes`."""
        return vectors if self.axes is None else quat.rotate(quat.conjugate(self.axes_quaternions), vectors)

    def at(self, joints: np.ndarray) -> MetricParameters:
        """Take some joints, by their indices, shape=[J]."""
        axes = None if self.axes is None else self.axes[joints]
        sides = tuple(self.invariance[joint] for joint in joints)
        return MetricParameters(self.alpha[joints], self.beta[joints], axes, sides)

    def differs(self, other: MetricParameters) -> np.ndarray:
        """Return which joints have another metric in other parameters for as many joints, shape=[B]."""
        axes = (np.zeros((self.n_joints, 3)) if each.axes is None else each.axes for each in (self, other))
        changed = (self.moments != other.moments) | np.not_equal(*axes)
        return changed.any(axis=-1) | (self.is_right != other.is_right)

    @property
    def matrices(self) -> Array:
        """Return the matrices Z at the identity, shape=[B, 3, 3]."""
        if self.axes is None:
            return self.moments[:, :, None] * np.eye(3)
        rotation = quat.to_matrix(self.axes_quaternions)
        return np.moveaxis(rotation, -1, -2) @ (self.moments[:, :, None] * rotation)

    @cached_property
    def is_right(self) -> np.ndarray:
        """Return whether each joint's metric is right-invariant, shape=[B]."""
        return np.array([side == "right" for side in self.invariance], dtype=bool)


@dataclass(frozen=True, eq=False)
class CurveParameters:
    r"""Parameters of a curve through keys: a metric, and how far the curve is bent towards a smooth one.

    Parameters
    ----------
    metric : MetricParameters
    tension, translation_tension : array-like, shape=[B]
        Of the rotation and of the translation of each joint: 0 no bending, 1 continuous velocity, `MAX_TENSION`
        continuous acceleration.
    coupling : array-like, shape=[B, 3, r]
        Velocities of all joints that come together cheaply, the bodies' where the metric is left-invariant: V in the
        inverse :math:`diag(Z_b^{-1}) + V V^T` of the matrix over the whole pose.
        Optional, default: None, joints are not coupled.

    Raises
    ------
    ValueError
        If there is not one tension for each joint, or it is not in [0, `MAX_TENSION`], or the coupling has another
        shape or numbers that are not finite.
    """

    metric: MetricParameters
    tension: Array
    translation_tension: Array
    coupling: Array | None = None

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        for name in ("tension", "translation_tension"):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.shape != (self.metric.n_joints,):
                raise ValueError(f"{name} has shape {values.shape}, but there are {self.metric.n_joints} joints.")
            bad = np.flatnonzero(~((values >= 0.0) & (values <= MAX_TENSION)))
            if len(bad):
                raise ValueError(f"{name} of joint {bad[0]} is {values[bad[0]]}; it must be from 0 to {MAX_TENSION:g}.")
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.coupling is not None:
            coupling = np.array(self.coupling, dtype=np.float64)
            if coupling.ndim != 3 or coupling.shape[:2] != (self.metric.n_joints, 3) or not np.isfinite(coupling).all():
                raise ValueError(
                    f"coupling has shape {coupling.shape}; finite numbers of shape ({self.metric.n_joints}, 3, r) are "
                    "needed."
                )
            size = np.linalg.norm(coupling.reshape(-1, coupling.shape[2]), 2) ** 2 if coupling.size else 0.0
            if size > MAX_CONDITION:
                raise ValueError(f"coupling has the squared norm {size:.4g}, above {MAX_CONDITION:g}.")
            coupling.setflags(write=False)
            object.__setattr__(self, "coupling", coupling)

    @classmethod
    def geodesic(cls, metric: MetricParameters) -> CurveParameters:
        """Return the curve that is not bent: the geodesics themselves."""
        return cls(metric, np.zeros(metric.n_joints), np.zeros(metric.n_joints))

    @classmethod
    def spline(cls, metric: MetricParameters) -> CurveParameters:
        """Return the curve with continuous velocity."""
        return cls(metric, np.ones(metric.n_joints), np.ones(metric.n_joints))

    @classmethod
    def plain(cls, scheme: str, n_joints: int) -> CurveParameters:
        """Return the curve of a scheme with the bi-invariant metric: slerp, or the plain spline."""
        make = cls.spline if scheme in BENT else cls.geodesic
        return make(MetricParameters.identity(n_joints))

    def at(self, joints: np.ndarray) -> CurveParameters:
        """Take some joints, by their indices, shape=[J]; what they share with the others is left."""
        coupling = None if self.coupling is None else self.coupling[joints]
        return CurveParameters(self.metric.at(joints), self.tension[joints], self.translation_tension[joints], coupling)
