"""A learned metric: parameters that know their joints and where they come from, their JSON form, and their scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from geomstats_anim.names import BENT, repeated_name
from geomstats_anim.parameters import CurveParameters, MetricParameters
from geomstats_anim.rotations import Array
from geomstats_anim.strict_json import dump_json, parse_json

FORMAT_VERSION = 1
"""Version of the stored form of a metric, in JSON and in USD."""

_TIE = 0.005
"""Relative difference that is called a tie."""

_PERFECT = 1e-9
"""Quality at which nothing is left to gain: rounding is all that differs below."""


@dataclass(frozen=True, eq=False)
class LearnedMetric:
    """Metric parameters with the names of their joints and their provenance.

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
    coupling : array-like, shape=[B, 3, r]
        What couples the joints, as in `CurveParameters`; only in Python and JSON.
        Optional, default: None, nothing.

    Raises
    ------
    ValueError
        If the sizes do not fit, a tension is not a number, or provenance has a value that JSON cannot store.
    """

    joints: tuple[str, ...]
    parameters: MetricParameters
    tension: Array = None  # type: ignore[assignment]
    scheme: str = "geodesic"
    quality: str = ""
    provenance: Mapping[str, Any] = field(default_factory=dict)
    translation_tension: Array = None  # type: ignore[assignment]
    coupling: Array | None = None

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        joints = tuple(str(joint) for joint in self.joints)
        twice = repeated_name(joints)
        if twice is not None:
            raise ValueError(f"Joint names must be unique, but {twice!r} is there twice.")
        if self.parameters.n_joints != len(joints):
            raise ValueError(f"There are {len(joints)} joints, but metric parameters for {self.parameters.n_joints}.")
        usual = CurveParameters.plain(self.scheme, len(joints)).tension
        bend, path = (usual if values is None else values for values in (self.tension, self.translation_tension))
        curve = CurveParameters(self.parameters, bend, path, self.coupling)
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "tension", curve.tension)
        object.__setattr__(self, "translation_tension", curve.translation_tension)
        object.__setattr__(self, "coupling", curve.coupling)
        try:
            dump_json(dict(self.provenance))
        except ValueError as error:
            raise ValueError(f"provenance has a value that JSON cannot store: {error}") from error
        object.__setattr__(self, "provenance", dict(self.provenance))

    @classmethod
    def plain(cls, joints: Sequence[str], scheme: str, tension: float | None = None) -> LearnedMetric:
        """Return the bi-invariant metric, with the scheme's usual tension or another."""
        tensions = None if tension is None else np.full(len(joints), tension)
        metric = MetricParameters.identity(len(joints))
        return cls(tuple(joints), metric, tensions, scheme, translation_tension=tensions)  # type: ignore[arg-type]

    @property
    def curve(self) -> CurveParameters:
        """Return the parameters without the names."""
        return CurveParameters(self.parameters, self.tension, self.translation_tension, self.coupling)

    def for_scheme(self, scheme: str) -> LearnedMetric:
        """Return the metric for another scheme, with its usual tension; schemes that are bent share their tension."""
        if scheme == self.scheme or {scheme, self.scheme} <= set(BENT):
            return replace(self, scheme=scheme)
        usual = CurveParameters.plain(scheme, len(self.joints)).tension
        return replace(self, scheme=scheme, tension=usual, translation_tension=usual)

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
        if tuple(joints) == self.joints:
            return self, ()
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
            coupling=None if self.coupling is None else pick(self.coupling, 0.0),
        )
        return matched, missing

    def to_json(self, indent: int | None = 2) -> str:
        """Return the metric as JSON, the same text for the same metric; in one line if the indent is None."""
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
        if self.coupling is not None:
            document["coupling"] = self.coupling.tolist()
        return dump_json(document, indent) + "\n"

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
        document = parse_json(text)
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
            rest: dict[str, Any] = {name: document[name] for name in names}
            for name, key in (("translation_tension", "translationTension"), ("coupling", "coupling")):
                rest[name] = document.get(key)
            return cls(parameters=parameters, **rest)
        except KeyError as error:
            raise ValueError(f"This metric has no {error}.") from error
        except TypeError as error:
            raise ValueError(f"This metric has a value of the wrong type: {error}.") from error


@dataclass(frozen=True)
class Score:
    """One comparison with what is done without learning: the plain spline, and slerp.

    Parameters
    ----------
    what : str
        What was learned from, and what was scored.
    in_sample : bool
        Whether the scored frames are those it was learned from.
    learned, slerp, plain : float
        Quality; lower is better. The plain curve is that of the default scheme, geodesic-spline, with the bi-invariant
        metric, whatever scheme was learned for.
    """

    what: str
    in_sample: bool
    learned: float
    slerp: float
    plain: float

    @property
    def rival(self) -> str:
        """Return the better of what needs no learning: "slerp" or "the plain spline"."""
        return "slerp" if self.slerp <= self.plain + _PERFECT else "the plain spline"

    @property
    def beside_rival(self) -> str:
        """Return how it compares with the rival, in words."""
        return f"{100.0 * abs(self.gain):.1f} % {'better' if self.gain >= 0.0 else 'worse'} than {self.rival}"

    @property
    def gain(self) -> float:
        """Return the share of the rival's error that is saved; negative where it loses."""
        least = min(self.slerp, self.plain)
        return (least - self.learned) / max(least, _PERFECT)

    @property
    def ties(self) -> bool:
        """Return whether the difference is too small to matter."""
        return abs(self.gain) <= _TIE

    @property
    def loses(self) -> bool:
        """Return whether it is worse than its rival."""
        return self.gain < -_TIE

    @property
    def verdict(self) -> str:
        """Return the comparison in words, such as "loses to slerp"."""
        return f"{'ties with' if self.ties else 'loses to' if self.loses else 'beats'} {self.rival}"
