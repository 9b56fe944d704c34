"""Explain a metric to an artist: about which axes each joint is stiff, in whose frame, and what it gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim import rotations as quat
from geomstats_anim.learned_metric import Score
from geomstats_anim.rotations import Array
from usd_tools.console.text import short_names

BY_JOINT = "by_joint"
"""Entry of the provenance with one list a column: joints by name, since metrics are reordered and provenance is not."""

AS_SLERP = 1.02
"""A joint whose largest moment is not this many times its smallest moves as slerp does."""

NOTICEABLE = 5e-4
"""Degrees of gain below which a metric makes no difference to a joint."""

UNTILTED = 1.0
"""Degrees by which a principal axis may be off the joint's own."""

HEADER = ("joint", "stiff about", "free about", "ratio", "x, y, z", "frame", "gain over slerp")

FRAMES = {"left": "own (left)", "right": "parent (right)"}

EXPLANATION = (
    "In-betweens avoid turning about the stiff axis and prefer the free one; ratio 1 is slerp. Axes in a joint's own "
    "frame turn with it, axes in its parent's do not. Gains are in degrees, in-sample."
)


@dataclass(frozen=True)
class JointMeaning:
    """Meaning of the metric of one joint.

    Parameters
    ----------
    joint : str
    moments : tuple of float
        About the three principal axes, as shares of the least.
    axes : tuple of str
        The joint's own axis that is nearest to each of them.
    tilts : tuple of float
        How far each is from it, degrees; 0 in a diagonal metric.
    invariance : str
        "left": judged in the joint's own frame; "right": in its parent's.
    gain, slerp_error : float or None
        Mean rotation error in degrees where the metric was learned: how far it is below slerp's, and slerp's.
        None where nobody has stored it, or the joint does not turn.
    turns : bool
        False if it is known that the joint does not turn.
    """

    joint: str
    moments: tuple[float, ...]
    axes: tuple[str, ...]
    tilts: tuple[float, ...]
    invariance: str
    gain: float | None
    slerp_error: float | None
    turns: bool

    @property
    def ratio(self) -> float:
        """Condition number: 1 is slerp."""
        return max(self.moments)

    @property
    def is_slerp(self) -> bool:
        """Return whether the joint moves as with slerp."""
        return self.ratio < AS_SLERP

    @property
    def matters(self) -> bool:
        """Return whether the metric makes a difference, as far as is known."""
        return not self.is_slerp and self.turns and (self.gain is None or abs(self.gain) >= NOTICEABLE)

    @property
    def why_not(self) -> str:
        """Reason why the metric makes no difference."""
        if not self.turns:
            return "do not turn"
        return "as slerp" if self.is_slerp else "no difference, as they turn about one axis or hardly at all"

    def axis(self, place: int) -> str:
        """Return the name of a principal axis."""
        tilt = self.tilts[place]
        return self.axes[place] if tilt <= UNTILTED else f"{self.axes[place]} ({tilt:.0f}° off)"

    @property
    def stiff(self) -> str:
        """Axis about which turns are dearest."""
        return self.axis(int(np.argmax(self.moments)))

    @property
    def free(self) -> str:
        """Axis about which turns are cheapest."""
        return self.axis(int(np.argmin(self.moments)))


def joint_meanings(metric: LearnedMetric) -> list[JointMeaning]:
    """Explain the metric of each joint.

    Parameters
    ----------
    metric : LearnedMetric

    Returns
    -------
    meanings : list of JointMeaning
        What matters most comes first: by the gain over slerp, and where that is not known by the ratio.
    """
    parameters = metric.parameters
    moments = parameters.moments / parameters.moments.min(axis=-1, keepdims=True)
    # the rows of P are the principal axes, as the joint sees them
    rows = quat.to_matrix(parameters.axes_quaternions)
    nearest = np.abs(rows).argmax(axis=-1)
    cosines = np.take_along_axis(np.abs(rows), nearest[..., None], axis=-1)[..., 0]
    tilts = np.degrees(np.arccos(np.clip(cosines, 0.0, 1.0)))
    known = _known_errors(metric.provenance)
    meanings = []
    for i, joint in enumerate(metric.joints):
        gain, slerp = known.get(joint, (None, None))
        meanings.append(
            JointMeaning(
                joint,
                tuple(moments[i].tolist()),
                tuple("xyz"[axis] for axis in nearest[i]),
                tuple(tilts[i].tolist()),
                parameters.invariance[i],
                None if gain is None else round(gain, 4),
                slerp,
                not known or joint in known,
            )
        )
    return sorted(meanings, key=lambda one: (not one.matters, -(one.gain or 0.0), -one.ratio))


def errors_by_joint(joints: Sequence[str], degrees: Array, slerp_degrees: Array) -> dict[str, list[Any]]:
    """Return the entry `BY_JOINT` of a metric's provenance: mean rotation errors of the joints that slerp misses.

    Parameters
    ----------
    joints : sequence of str
    degrees, slerp_degrees : array-like, shape=[B]
        With the metric, and by slerp between the same samples.
    """
    degrees, slerp_degrees = np.round(degrees, 4), np.round(slerp_degrees, 4)
    off = np.flatnonzero(slerp_degrees)
    return {
        "joints": [joints[joint] for joint in off],
        "degrees": degrees[off].tolist(),
        "slerp_degrees": slerp_degrees[off].tolist(),
    }


def _known_errors(provenance: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Return gain and slerp's error of each joint; empty if they are not stored as `errors_by_joint` makes them."""
    try:
        stored = provenance[BY_JOINT]
        columns = (stored[name] for name in ("joints", "degrees", "slerp_degrees"))
        rows = zip(*columns, strict=True)
        return {str(joint): (float(slerp) - float(learned), float(slerp)) for joint, learned, slerp in rows}
    except (KeyError, TypeError, ValueError):
        return {}


def table_rows(meanings: Sequence[JointMeaning]) -> list[tuple[str, ...]]:
    """Return the rows of a table with `HEADER`; joints for which the metric does not matter share the last rows."""
    names = short_names([one.joint for one in meanings])
    rows = [_row(one, names[one.joint]) for one in meanings if one.matters]
    groups: dict[str, int] = {}
    for one in meanings:
        if not one.matters:
            groups[one.why_not] = groups.get(one.why_not, 0) + 1
    rows += [(f"{count} joint{'s' if count > 1 else ''}: {words}",) for words, count in groups.items()]
    return rows


def _row(meaning: JointMeaning, name: str) -> tuple[str, ...]:
    by_axis = sorted(zip(meaning.axes, meaning.moments, strict=True))
    gain = "not stored"
    if meaning.gain is not None and meaning.slerp_error is not None:
        gain = f"{meaning.gain:+.3f} of {meaning.slerp_error:.3f}"
    return (
        name,
        meaning.stiff,
        meaning.free,
        f"{meaning.ratio:.3g}",
        ", ".join(f"{moment:.3g}" for _, moment in by_axis),
        FRAMES[meaning.invariance],
        gain,
    )


def as_dict(meaning: JointMeaning) -> dict[str, Any]:
    """Return plain values: the fields of `JointMeaning`, and stiff, free, ratio, matters."""
    names = ("stiff", "free", "ratio", "matters")
    return asdict(meaning) | {name: getattr(meaning, name) for name in names}


def describe_scores(provenance: Mapping[str, Any]) -> list[str]:
    """Describe the scores of a stored metric where it was learned, and where it was not.

    Parameters
    ----------
    provenance : mapping
        Of a metric that `learn` made; for others there are no sentences.

    Returns
    -------
    sentences : list of str
    """
    try:
        unseen = provenance["out_of_sample"]
        columns = (unseen[name] for name in ("scores", "slerp_scores", "plain_scores"))
        rows = [("in-sample", provenance["score"], provenance["slerp_score"], provenance["plain_score"])]
        rows += [(f"out-of-sample, {what}", *values) for what, *values in zip(unseen["what"], *columns, strict=True)]
        scores = [Score(what, False, *map(float, values)) for what, *values in rows]
    except (KeyError, TypeError, ValueError):
        return []
    return [f"{one.what[0].upper()}{one.what[1:]}: {100.0 * one.gain:+z.1f} %, {one.verdict}." for one in scores]
