"""Edits: small values, of which a session is a list, and their form in JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from geomstats_anim import LearnedMetric
from geomstats_anim.names import SCHEME_NAMES
from usd_tools.console.errors import ToolError
from usd_tools.console.text import did_you_mean, short_names
from usd_tools.upsampling.joint_styles import Style, as_style


@dataclass(frozen=True)
class UseScheme:
    """Interpolate by another scheme; a metric keeps its alpha, beta, axes and sides, and gets the scheme's tension."""

    scheme: str

    def __post_init__(self) -> None:
        """Refuse a scheme that does not exist."""
        if self.scheme not in SCHEME_NAMES:
            raise ValueError(f"there is no scheme {self.scheme!r}{did_you_mean(self.scheme, SCHEME_NAMES)}")


@dataclass(frozen=True, eq=False)
class UseMetric:
    """Take a whole metric, with its scheme: one that was learned, or is stored in a file.

    Parameters
    ----------
    metric : LearnedMetric
        Matched to joints by name.
    """

    metric: LearnedMetric


@dataclass(frozen=True)
class Reset:
    """Give joints the bi-invariant metric, from the left, and the usual tension of the scheme.

    Parameters
    ----------
    pattern : str
        Glob, as in `Style`.
    """

    pattern: str = "*"

    def __post_init__(self) -> None:
        """Refuse what is no text."""
        _check_text(self.pattern)


@dataclass(frozen=True)
class Mirror:
    """Give the joints of one side what their counterparts on the other side have: LeftArm to RightArm, arm_l to arm_r.

    Parameters
    ----------
    pattern : str
        Glob for the joints to copy from, as in `Style`; those without a counterpart are left out.
    """

    pattern: str

    def __post_init__(self) -> None:
        """Refuse what is no text."""
        _check_text(self.pattern)


@dataclass(frozen=True)
class EveryNth:
    """Take every n-th sample as a key, and the ends of stretches between cuts; 1 takes all: the file's own samples."""

    n: int

    def __post_init__(self) -> None:
        """Refuse what is no whole number."""
        _check_whole(self.n, 1)


@dataclass(frozen=True)
class ChooseKeys:
    """Take as many samples as keys as are asked for, those from which slerp rebuilds the others best."""

    count: int

    def __post_init__(self) -> None:
        """Refuse what is no whole number."""
        _check_whole(self.count, 2)


@dataclass(frozen=True)
class KeepOnly:
    """Take exactly these samples as keys, and the ends of stretches between cuts.

    Parameters
    ----------
    codes : tuple of float
        Time codes.
    """

    codes: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse what is no number."""
        object.__setattr__(self, "codes", tuple(map(_finite, self.codes)))


@dataclass(frozen=True)
class PinKey:
    """Make a key of the sample at a time code."""

    code: float

    def __post_init__(self) -> None:
        """Refuse what is no number."""
        object.__setattr__(self, "code", _finite(self.code))


@dataclass(frozen=True)
class FreeKey:
    """Make no key of the sample at a time code any more."""

    code: float

    def __post_init__(self) -> None:
        """Refuse what is no number."""
        object.__setattr__(self, "code", _finite(self.code))


def _check_text(pattern: object) -> None:
    if not isinstance(pattern, str):
        raise ValueError(f"a pattern must be text, not {pattern!r}")


def _check_whole(number: object, least: int) -> None:
    if type(number) is not int or number < least:
        raise ValueError(f"a whole number of at least {least} is needed, not {number!r}")


def _finite(code: object) -> float:
    if not isinstance(code, int | float) or not math.isfinite(code):
        raise ValueError(f"a time code must be a finite number, not {code!r}")
    return float(code)


KeyEdit = EveryNth | ChooseKeys | KeepOnly | PinKey | FreeKey
"""Edits of keys; the others are of the metric."""

Edit = Style | UseScheme | UseMetric | Reset | Mirror | KeyEdit
"""Whatever a session can be asked to change."""

_KINDS: dict[str, Callable[..., Edit]] = {
    "style": as_style,
    "scheme": UseScheme,
    "metric": lambda metric: UseMetric(LearnedMetric.from_json(json.dumps(metric))),
    "reset": Reset,
    "mirror": Mirror,
    "every-nth": EveryNth,
    "choose-keys": ChooseKeys,
    "keep-only": KeepOnly,
    "pin-key": PinKey,
    "free-key": FreeKey,
}
_TYPES = (Style, UseScheme, UseMetric, Reset, Mirror, EveryNth, ChooseKeys, KeepOnly, PinKey, FreeKey)
_WORDS = dict(zip(_TYPES, _KINDS, strict=True))


def as_dict(edit: Edit) -> dict[str, Any]:
    """Return an edit as plain values, for JSON."""
    kind = {"edit": _WORDS[type(edit)]}
    if isinstance(edit, UseMetric):
        return {**kind, "metric": json.loads(edit.metric.to_json())}
    values = {each.name: getattr(edit, each.name) for each in fields(edit)}
    plain = {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}
    return {**kind, **{name: value for name, value in plain.items() if value is not None}}


def from_dict(document: Any) -> Edit:
    """Make an edit of plain values that somebody else may have written: undo `as_dict`.

    Raises
    ------
    ToolError
        If they make no edit.
    """
    if not isinstance(document, Mapping) or document.get("edit") not in _KINDS:
        kind = document.get("edit") if isinstance(document, Mapping) else document
        raise ToolError(f"{str(kind)[:80]!r} is no edit; the edits are {', '.join(_KINDS)}.")
    values = {name: value for name, value in document.items() if name != "edit"}
    try:
        return _KINDS[document["edit"]](**values)
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise ToolError(f"the edit {document['edit']!r} cannot be read: {error}.") from error


def patterns(joints: Sequence[str]) -> dict[str, str]:
    """Return the shortest pattern that matches each of a skeleton's joints and no other, by path."""
    names = short_names(joints)
    return {joint: exactly(joint if "/" in names[joint] else names[joint]) for joint in joints}


def exactly(joint: str) -> str:
    """Return the pattern that matches a joint by its whole path."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in joint)
