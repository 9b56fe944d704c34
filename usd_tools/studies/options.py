"""Options of `study`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from usd_tools.comparison.options import SchemeChoice
from usd_tools.console.arguments import seed, share
from usd_tools.console.errors import UsageError
from usd_tools.console.options import PrimOptions, option

SCHEMES = tuple(map(SchemeChoice.parse, ("slerp", "geodesic-spline:plain", "geodesic-spline")))
"""Schemes that are shown unless others are asked for."""


def _schemes(values: Iterable[str | SchemeChoice]) -> tuple[SchemeChoice, ...]:
    chosen = (value if isinstance(value, SchemeChoice) else SchemeChoice.parse(value) for value in values)
    return tuple(dict.fromkeys(chosen))


@dataclass(frozen=True, kw_only=True)
class StudyOptions(PrimOptions):
    """Options of `study`.

    Parameters
    ----------
    rate : float
        Share of the samples kept as uniform keys.
        Optional, default: .1.
    schemes : tuple of str or SchemeChoice
        At least two; every pair of them is shown.
        Optional, default: slerp, geodesic-spline:plain and geodesic-spline.
    seed : int
        Of the order of the pairs, and of their sides.
        Optional, default: 0.
    """

    rate: float = option(0.1, lambda value: share(str(value)))
    schemes: tuple[SchemeChoice, ...] = option(SCHEMES, _schemes)
    seed: int = option(0, lambda value: seed(str(value)))

    def check(self) -> None:
        """Refuse fewer schemes than make a pair.

        Raises
        ------
        UsageError
        """
        if len(self.schemes) < 2:
            raise UsageError("--schemes must name at least two, for pairs are compared")
