"""Set a metric by hand: for all joints, or for the joints whose names match a pattern."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from geomstats_anim.names import INVARIANCES, MAX_TENSION
from usd_tools.console.arguments import positive_number
from usd_tools.console.text import did_you_mean

if TYPE_CHECKING:
    from geomstats_anim import LearnedMetric

_EXAMPLE = "'PATTERN:alpha=4,beta=.5,invariance=right,tension=0'"


@dataclass(frozen=True)
class Style:
    """Settings of the joints that match a pattern; None leaves what is there.

    Parameters
    ----------
    pattern : str
        Glob, matched against a joint's path token and against the last part of it.
    alpha, beta : float or None
        Second and third principal moment; the first is 1.
    invariance : str or None
        "left" or "right".
    tension, translation_tension : float or None
        Of geodesic-spline, for turns and for translations: 0 as geodesic, 1 continuous velocity, 2 continuous
        acceleration.
    axes : tuple of float or None
        Rotation vector of the principal axes, degrees.
    """

    pattern: str
    alpha: float | None = None
    beta: float | None = None
    invariance: str | None = None
    tension: float | None = None
    translation_tension: float | None = None
    axes: tuple[float, ...] | None = None

    @property
    def settings(self) -> dict[str, Any]:
        """The settings that are made, by name."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "pattern"}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def has_tension(self) -> bool:
        """True if it sets a tension."""
        return self.tension is not None or self.translation_tension is not None

    def matches(self, joint: str) -> bool:
        """Return whether a joint's name matches."""
        return fnmatchcase(joint, self.pattern) or fnmatchcase(joint.rsplit("/", 1)[-1], self.pattern)

    def __str__(self) -> str:
        """Write it as it is written on the command line."""
        words = (f"{_word(name)}={_written(value)}" for name, value in self.settings.items())
        return f"{self.pattern}:{','.join(words)}"


def _word(name: str) -> str:
    return name.replace("_", "-")


def _written(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_written, value))
    if not isinstance(value, float):
        return str(value)
    short = f"{value:g}"
    return short if float(short) == value else repr(value)


def tension_number(text: str) -> float:
    """Parse a tension."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 <= number <= MAX_TENSION:
        raise argparse.ArgumentTypeError(f"must be a number from 0 to {MAX_TENSION:g}, not {text!r}")
    return number


def _side(text: str) -> str:
    if text not in INVARIANCES:
        raise argparse.ArgumentTypeError(f"must be left or right, not {text!r}{did_you_mean(text, INVARIANCES)}")
    return text


def _axes(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise argparse.ArgumentTypeError(f"must be three numbers with spaces between them, not {text!r}")
    return numbers


_PARSED: dict[str, Callable[[str], Any]] = {
    "alpha": positive_number,
    "beta": positive_number,
    "invariance": _side,
    "tension": tension_number,
    "translation-tension": tension_number,
    "axes": _axes,
}
"""Fields that a style may set, and how their values are read."""


def parse_style(text: str) -> Style:
    """Parse `PATTERN:alpha=4,invariance=right,axes=0 0 45`; the last colon counts, for Maya has colons in names."""
    pattern, colon, settings = text.rpartition(":")
    if not colon or not pattern:
        raise argparse.ArgumentTypeError(f"must look like {_EXAMPLE}, not {text!r}")
    found = {}
    for setting in settings.split(","):
        name, _, value = (part.strip() for part in setting.partition("="))
        if name not in _PARSED:
            words = list(_PARSED)
            raise argparse.ArgumentTypeError(
                f"{setting!r} in {text!r} must set {', '.join(words[:-1])} or {words[-1]}{did_you_mean(name, words)}"
            )
        try:
            found[name.replace("-", "_")] = _PARSED[name](value)
        except argparse.ArgumentTypeError as error:
            raise argparse.ArgumentTypeError(f"{name} in {text!r} {error}") from None
    return Style(pattern, **found)


def as_style(pattern: str, **settings: Any) -> Style:
    """Check the settings of a style that come as plain values, not as text.

    Raises
    ------
    ValueError
        If there is no such setting, or a value is not allowed.
    """
    if not isinstance(pattern, str):
        raise ValueError(f"a pattern must be text, not {pattern!r}")
    found = {}
    for name, value in settings.items():
        parse = _PARSED.get(_word(name))
        if parse is None or name != name.replace("-", "_"):
            raise ValueError(
                f"there is no setting {name!r}{did_you_mean(name, [word.replace('-', '_') for word in _PARSED])}"
            )
        if not isinstance(value, list | tuple if name == "axes" else str | int | float):
            raise ValueError(f"{name} cannot be {value!r}")
        try:
            found[name] = parse(_written(tuple(value) if isinstance(value, list) else value))
        except argparse.ArgumentTypeError as error:
            raise ValueError(f"{name} {error}") from None
    return Style(pattern, **found)


def styled(metric: LearnedMetric, styles: Sequence[Style]) -> LearnedMetric:
    """Apply styles to a metric, later ones over earlier ones.

    Parameters
    ----------
    metric : LearnedMetric
    styles : sequence of Style

    Returns
    -------
    metric : LearnedMetric
        The same metric where nothing matches; otherwise one that no longer claims to minimise a quality, and says in
        its provenance how it was styled.
    """
    import numpy as np

    from geomstats_anim import MetricParameters

    old = metric.parameters
    values: dict[str, Any] = {
        "alpha": old.alpha.copy(),
        "beta": old.beta.copy(),
        "invariance": np.array(old.invariance, dtype=object),
        "tension": metric.tension.copy(),
        "translation_tension": metric.translation_tension.copy(),
        "axes": np.zeros((len(metric.joints), 3)) if old.axes is None else old.axes.copy(),
    }
    used = []
    for style in styles:
        places = [i for i, joint in enumerate(metric.joints) if style.matches(joint)]
        if places:
            used.append(str(style))
        for name, value in style.settings.items():
            values[name][places] = np.radians(value) if name == "axes" else value
    if not used:
        return metric
    axes = None if old.axes is None and not values["axes"].any() else values["axes"]
    parameters = MetricParameters(values["alpha"], values["beta"], axes, tuple(values["invariance"]))
    before = metric.provenance.get("styles")
    provenance = {**metric.provenance, "styles": [*(before if isinstance(before, list) else []), *used]}
    return replace(
        metric,
        parameters=parameters,
        tension=values["tension"],
        translation_tension=values["translation_tension"],
        quality="",
        provenance=provenance,
    )


def unmatched(styles: Sequence[Style], joints: Sequence[str]) -> Style | None:
    """Return the first style that matches no joint; "*" is for all, even if there are none."""
    return next((style for style in styles if style.pattern != "*" and not any(map(style.matches, joints))), None)
