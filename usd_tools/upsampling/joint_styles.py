"""How artists bend a metric by hand: numbers for all joints, or for the joints whose names match a pattern."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from geomstats_anim.names import INVARIANCES
from usd_tools.console.arguments import positive_number
from usd_tools.console.text import did_you_mean

if TYPE_CHECKING:
    from geomstats_anim import LearnedMetric


@dataclass(frozen=True)
class Style:
    """Numbers for the joints that match a pattern; None leaves what is there.

    Parameters
    ----------
    pattern : str
        Glob, matched against a joint's path token and against the last part of it.
    alpha, beta : float or None
    invariance : str or None
    """

    pattern: str
    alpha: float | None = None
    beta: float | None = None
    invariance: str | None = None

    def matches(self, joint: str) -> bool:
        """Whether a joint's name matches."""
        return fnmatchcase(joint, self.pattern) or fnmatchcase(joint.rsplit("/", 1)[-1], self.pattern)

    def __str__(self) -> str:
        """Write it as it is written on the command line."""
        settings = {"alpha": self.alpha, "beta": self.beta, "invariance": self.invariance}
        words = (
            f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}"
            for name, value in settings.items()
            if value is not None
        )
        return f"{self.pattern}:{','.join(words)}"


def parse_style(text: str) -> Style:
    """Parse `PATTERN:alpha=4,beta=.5,invariance=right`; the last colon counts, for Maya has colons in names."""
    pattern, colon, settings = text.rpartition(":")
    if not colon or not pattern:
        raise argparse.ArgumentTypeError(f"must look like 'PATTERN:alpha=4,beta=.5,invariance=right', not {text!r}")
    style = Style(pattern)
    for setting in settings.split(","):
        name, _, value = (part.strip() for part in setting.partition("="))
        if name in ("alpha", "beta"):
            try:
                number = positive_number(value)
            except argparse.ArgumentTypeError as error:
                raise argparse.ArgumentTypeError(f"{name} in {text!r} {error}") from None
            style = replace(style, alpha=number) if name == "alpha" else replace(style, beta=number)
        elif name == "invariance":
            if value not in INVARIANCES:
                raise argparse.ArgumentTypeError(
                    f"invariance in {text!r} must be left or right, not {value!r}{did_you_mean(value, INVARIANCES)}"
                )
            style = replace(style, invariance=value)
        else:
            raise argparse.ArgumentTypeError(
                f"{setting!r} in {text!r} must set alpha, beta or invariance"
                f"{did_you_mean(name, ('alpha', 'beta', 'invariance'))}"
            )
    return style


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
    from geomstats_anim import MetricParameters

    alpha, beta = metric.parameters.alpha.copy(), metric.parameters.beta.copy()
    invariance = list(metric.parameters.invariance)
    used = []
    for style in styles:
        places = [i for i, joint in enumerate(metric.joints) if style.matches(joint)]
        if places:
            used.append(str(style))
        if style.alpha is not None:
            alpha[places] = style.alpha
        if style.beta is not None:
            beta[places] = style.beta
        if style.invariance is not None:
            for i in places:
                invariance[i] = style.invariance
    if not used:
        return metric
    parameters = MetricParameters(alpha, beta, metric.parameters.axes, tuple(invariance))
    before = metric.provenance.get("styles")
    provenance = {**metric.provenance, "styles": [*(before if isinstance(before, list) else []), *used]}
    return replace(metric, parameters=parameters, quality="", provenance=provenance)


def unmatched(styles: Sequence[Style], joints: Sequence[str]) -> Style | None:
    """Find the first style that matches no joint; "*" is for all, even if there are none."""
    return next((style for style in styles if style.pattern != "*" and not any(map(style.matches, joints))), None)
