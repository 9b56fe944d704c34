"""The parameters of a metric on the pose Lie group, one matrix and one side a joint."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.names import INVARIANCES
from geomstats_anim.rotations import Array

MAX_CONDITION = 1e4
"""Largest ratio of principal moments: beyond, a body tumbles so fast that its geodesics take seconds each."""

MAX_TENSION = 2.0
"""Tension of a curve with continuous acceleration; see `tangents`."""

FORMAT_VERSION = 1
"""Version of the stored form of a metric, in JSON and in USD."""


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
        "left" or "right", for all joints or one a joint.
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
            raise ValueError(f"alpha has shape {alpha.shape} and beta {beta.shape}; one number a joint is needed.")
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
        """Bi-invariant metric, whose geodesics are slerp."""
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

    @property
    def n_joints(self) -> int:
        """Number of joints, B."""
        return len(self.alpha)

    @property
    def moments(self) -> Array:
        """Principal moments (1, alpha, beta), shape=[B, 3]."""
        return np.stack([np.ones_like(self.alpha), self.alpha, self.beta], axis=-1)

    @property
    def axes_quaternions(self) -> Array:
        """Rotations P as unit quaternions, shape=[B, 4]."""
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

    @property
    def matrices(self) -> Array:
        """Matrices Z at the identity, shape=[B, 3, 3]."""
        if self.axes is None:
            return self.moments[:, :, None] * np.eye(3)
        rotation = quat.to_matrix(self.axes_quaternions)
        return np.moveaxis(rotation, -1, -2) @ (self.moments[:, :, None] * rotation)

    @property
    def is_right(self) -> np.ndarray:
        """Whether each joint's metric is right-invariant, shape=[B]."""
        return np.array([side == "right" for side in self.invariance], dtype=bool)


@dataclass(frozen=True, eq=False)
class CurveParameters:
    """What a curve through keys depends on: a metric, and how far it is bent towards a smooth one.

    Parameters
    ----------
    metric : MetricParameters
    tension, translation_tension : array-like, shape=[B]
        Of the rotation and of the translation of each joint: 0 no bending, 1 continuous velocity, `MAX_TENSION`
        continuous acceleration.

    Raises
    ------
    ValueError
        If there is not one tension for each joint, or it is not in [0, `MAX_TENSION`].
    """

    metric: MetricParameters
    tension: Array
    translation_tension: Array

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

    @classmethod
    def geodesic(cls, metric: MetricParameters) -> CurveParameters:
        """Bend nothing."""
        return cls(metric, np.zeros(metric.n_joints), np.zeros(metric.n_joints))

    @classmethod
    def spline(cls, metric: MetricParameters) -> CurveParameters:
        """Let velocities be continuous."""
        return cls(metric, np.ones(metric.n_joints), np.ones(metric.n_joints))

    @classmethod
    def plain(cls, scheme: str, n_joints: int) -> CurveParameters:
        """Curve of a scheme with the bi-invariant metric: slerp, or the spline that is its like."""
        make = cls.spline if scheme == "geodesic-spline" else cls.geodesic
        return make(MetricParameters.identity(n_joints))

    def at(self, joints: np.ndarray) -> CurveParameters:
        """Take some joints, by their indices, shape=[J]."""
        return CurveParameters(self.metric.at(joints), self.tension[joints], self.translation_tension[joints])


@dataclass(frozen=True, eq=False)
class LearnedMetric:
    """Metric parameters that know their joints' names, and where they come from.

    Parameters
    ----------
    joints : sequence of str, shape=[B]
        Full path tokens, unique.
    parameters : MetricParameters
    tension : array-like, shape=[B]
        How far each joint's curve is bent: 0 the geodesic, 1 continuous velocity, 2 continuous acceleration.
        Optional, default: 1 everywhere for the scheme "geodesic-spline", else 0.
    scheme : str
        Interpolation scheme that the parameters were made for.
        Optional, default: "geodesic".
    quality : str
        Quality that they minimise: loc, rot, hyb, or "" if they were set by hand.
        Optional, default: "".
    provenance : mapping
        Plain strings, numbers and lists: source, sha256, rate, search, seed, trials, version, scores.
        Optional, default: empty.
    translation_tension : array-like, shape=[B]
        The same for the joint's translation, which goes along a straight line or a cubic.
        Optional, default: as for `tension`.

    Raises
    ------
    ValueError
        If the sizes do not fit, a tension is not a number, or provenance holds what JSON cannot.
    """

    joints: tuple[str, ...]
    parameters: MetricParameters
    tension: Array = None  # type: ignore[assignment]
    scheme: str = "geodesic"
    quality: str = ""
    provenance: Mapping[str, Any] = field(default_factory=dict)
    translation_tension: Array = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        joints = tuple(str(joint) for joint in self.joints)
        if len(set(joints)) != len(joints):
            twice = next(joint for i, joint in enumerate(joints) if joint in joints[:i])
            raise ValueError(f"Joint names must be unique, but {twice!r} is there twice.")
        if self.parameters.n_joints != len(joints):
            raise ValueError(f"There are {len(joints)} joints, but metric parameters for {self.parameters.n_joints}.")
        usual = CurveParameters.plain(self.scheme, len(joints)).tension
        tensions = (usual if values is None else values for values in (self.tension, self.translation_tension))
        curve = CurveParameters(self.parameters, *tensions)
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "tension", curve.tension)
        object.__setattr__(self, "translation_tension", curve.translation_tension)
        try:
            json.dumps(dict(self.provenance), allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ValueError(f"provenance holds what JSON cannot: {error}.") from error
        object.__setattr__(self, "provenance", dict(self.provenance))

    @classmethod
    def plain(cls, joints: Sequence[str], scheme: str, tension: float | None = None) -> LearnedMetric:
        """Make the metric for which nothing was learned: bi-invariant, with the scheme's usual tension or another."""
        tensions = None if tension is None else np.full(len(joints), tension)
        metric = MetricParameters.identity(len(joints))
        return cls(tuple(joints), metric, tensions, scheme, translation_tension=tensions)  # type: ignore[arg-type]

    @property
    def curve(self) -> CurveParameters:
        """Its parameters without the names."""
        return CurveParameters(self.parameters, self.tension, self.translation_tension)

    def for_scheme(self, scheme: str) -> LearnedMetric:
        """Take the metric for another scheme; its tension is the usual one, as what was learned says nothing of it."""
        usual = CurveParameters.plain(scheme, len(self.joints)).tension
        return self if scheme == self.scheme else replace(self, scheme=scheme, tension=usual, translation_tension=usual)

    def for_joints(self, joints: Sequence[str]) -> tuple[LearnedMetric, tuple[str, ...]]:
        """Match the metric to other joints, by name.

        Parameters
        ----------
        joints : sequence of str, shape=[B]

        Returns
        -------
        metric : LearnedMetric
            In the order of `joints`; those that are not known have the identity metric, and the usual tension of the
            scheme.
        missing : tuple of str
            The joints that are not known.
        """
        place = {joint: i for i, joint in enumerate(self.joints)}
        missing = tuple(joint for joint in joints if joint not in place)
        known = np.array([joint in place for joint in joints], dtype=bool)
        index = np.array([place[joint] for joint in joints if joint in place], dtype=np.intp)

        def pick(values: Array, default: float) -> Array:
            picked = np.full((len(joints), *values.shape[1:]), default)
            picked[known] = values[index]
            return picked

        source, usual = self.parameters, CurveParameters.plain(self.scheme, 1)
        parameters = MetricParameters(
            pick(source.alpha, 1.0),
            pick(source.beta, 1.0),
            None if source.axes is None else pick(source.axes, 0.0),
            tuple(source.invariance[place[joint]] if joint in place else "left" for joint in joints),
        )
        tension = pick(self.tension, usual.tension[0])
        translation_tension = pick(self.translation_tension, usual.translation_tension[0])
        matched = replace(
            self,
            joints=tuple(joints),
            parameters=parameters,
            tension=tension,
            translation_tension=translation_tension,
        )
        return matched, missing

    def to_json(self) -> str:
        """Write as JSON, the same text for the same metric."""
        document = {
            "format": "geodesicMetric",
            "version": FORMAT_VERSION,
            "joints": list(self.joints),
            "alpha": self.parameters.alpha.tolist(),
            "beta": self.parameters.beta.tolist(),
            "axes": None if self.parameters.axes is None else self.parameters.axes.tolist(),
            "invariance": list(self.parameters.invariance),
            "tension": self.tension.tolist(),
            "translationTension": self.translation_tension.tolist(),
            "scheme": self.scheme,
            "quality": self.quality,
            "provenance": dict(self.provenance),
        }
        return json.dumps(document, indent=2) + "\n"

    @classmethod
    def from_json(cls, text: str) -> LearnedMetric:
        """Read what `to_json` wrote.

        Parameters
        ----------
        text : str

        Returns
        -------
        metric : LearnedMetric

        Raises
        ------
        ValueError
            If the text is not JSON, not a metric, of a newer version, or holds values that make no metric.
        """
        try:
            document = json.loads(text)
        except json.JSONDecodeError as error:
            raise ValueError(f"This is not JSON: {error}.") from error
        if not isinstance(document, dict) or document.get("format") != "geodesicMetric":
            raise ValueError('This JSON is not a metric: its "format" is not "geodesicMetric".')
        if document.get("version") != FORMAT_VERSION:
            raise ValueError(
                f"This metric has format version {document.get('version')}, but this program reads {FORMAT_VERSION}."
            )
        try:
            parameters = MetricParameters(
                document["alpha"], document["beta"], document["axes"], tuple(document["invariance"])
            )
            names = ("joints", "tension", "scheme", "quality", "provenance")
            rest = {name: document[name] for name in names}
            return cls(parameters=parameters, translation_tension=document.get("translationTension"), **rest)  # type: ignore[arg-type]
        except KeyError as error:
            raise ValueError(f"This metric has no {error}.") from error
        except TypeError as error:
            raise ValueError(f"This metric has a value of the wrong type: {error}.") from error
