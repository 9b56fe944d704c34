"""Options of `compare`."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geomstats_anim.names import DEFAULT_SCHEME, FAMILIES, KINDS, LEARNABLE, LEARNED, OWN_SCHEMES, PURPOSES
from usd_tools.console.arguments import positive_number, share, whole_number
from usd_tools.console.options import PrimOptions, one_of, option
from usd_tools.console.parser import listed
from usd_tools.console.text import did_you_mean

RATES = (0.5, 0.3, 0.2, 0.1, 0.05)
"""Shares of samples kept, where nothing else is asked for."""

PLAIN = "plain"
"""Family of a scheme with the identity metric: nothing is learned."""

DEFAULT_CHOICES = (*OWN_SCHEMES, f"{DEFAULT_SCHEME}:{PLAIN}")
"""All schemes, and what `upsample` does without a metric."""


@dataclass(frozen=True)
class SchemeChoice:
    """A scheme, and for one that learns, the family of its metric; "plain" learns nothing, and has the identity.

    Parameters
    ----------
    word : str
        How it is named on the command line, and in the results.
    scheme : str
        A name in `SCHEMES`.
    family : str or None
        None for a scheme that learns nothing.
    """

    word: str
    scheme: str
    family: str | None

    @classmethod
    def parse(cls, text: str) -> SchemeChoice:
        """Parse a word of the command line, such as `slerp`, `geodesic:spd` or `geodesic-spline:plain`.

        Raises
        ------
        argparse.ArgumentTypeError
            If there is no such scheme or family, or the scheme learns nothing.
        """
        scheme, colon, family = text.partition(":")
        if scheme == LEARNED:
            raise argparse.ArgumentTypeError(f"{LEARNED} needs a library: give compare --library FILE instead")
        if scheme not in OWN_SCHEMES:
            raise argparse.ArgumentTypeError(
                f"must be {listed(OWN_SCHEMES)}, not {scheme!r}{did_you_mean(scheme, OWN_SCHEMES)}"
            )
        if scheme not in LEARNABLE:
            if colon:
                raise argparse.ArgumentTypeError(f"{scheme} has no metric, so it has no family; write {scheme} alone")
            return cls(scheme, scheme, None)
        if family == PLAIN:
            return cls(text, scheme, None)
        family = family if colon else FAMILIES[0]
        if family not in FAMILIES:
            words = (*FAMILIES, PLAIN)
            raise argparse.ArgumentTypeError(
                f"the family of {scheme} must be {listed(words)}, as in {scheme}:{FAMILIES[-1]}, not {family!r}"
                f"{did_you_mean(family, words)}"
            )
        return cls(scheme if family == FAMILIES[0] else f"{scheme}:{family}", scheme, family)

    @property
    def purposes(self) -> tuple[str | None, ...]:
        """Purposes that it may be learned for; None alone for a scheme that learns nothing."""
        return (None,) if self.family is None else tuple(reversed(PURPOSES))


def _rates(values: Iterable[float]) -> tuple[float, ...]:
    return tuple(dict.fromkeys(map(share, values)))  # type: ignore[arg-type]


def _tolerances(values: Iterable[float]) -> tuple[float, ...]:
    return tuple(dict.fromkeys(map(positive_number, values)))  # type: ignore[arg-type]


def _schemes(values: Iterable[str | SchemeChoice]) -> tuple[SchemeChoice, ...]:
    chosen = (value if isinstance(value, SchemeChoice) else SchemeChoice.parse(value) for value in values)
    return tuple(dict.fromkeys(chosen))


@dataclass(frozen=True, kw_only=True)
class CompareOptions(PrimOptions):
    """Options of `compare`, in the words of its command line.

    Parameters
    ----------
    rates : tuple of float
        Shares of the samples kept as uniform keys.
        Optional, default: .5, .3, .2, .1 and .05.
    schemes : tuple of str or SchemeChoice
        Interpolation schemes; one that learns may carry its family, as in "geodesic:spd".
        Optional, default: all, and "geodesic-spline:plain", which is what `upsample` does without a metric.
    kind : str
        Quality that learning minimises: "loc", "rot" or "hyb".
        Optional, default: "hyb".
    tolerances : tuple of float
        Centimetres: how many bytes `pack`, `downsample`, slerp and plain rounding need to stay within each.
        Optional, default: none, which takes no time.
    library : Path
        File that `learn` made of clips of the same rig: its scheme "learned" is compared, too. A clip that it has
        learned from is scored by a library of its other clips.
    address : str
        HOST:PORT of a Ray cluster.
    cpus : int
        Workers; more than one starts Ray.
        Optional, default: 1.
    """

    rates: tuple[float, ...] = option(RATES, _rates)
    schemes: tuple[SchemeChoice, ...] = option(DEFAULT_CHOICES, _schemes)
    kind: str = option("hyb", one_of(KINDS))
    tolerances: tuple[float, ...] = option((), _tolerances)
    library: Path | None = option(None, Path)
    address: str | None = option(None, str, recorded=False)
    cpus: int | None = option(None, whole_number, recorded=False)

    @property
    def choices(self) -> tuple[SchemeChoice, ...]:
        """The schemes, and the one that a library is for."""
        own = () if self.library is None else (SchemeChoice(LEARNED, LEARNED, None),)
        return tuple(dict.fromkeys((*self.schemes, *own)))

    def settings(self) -> dict[str, Any]:
        """Return what was asked for, lists as they are."""
        schemes = list(dict.fromkeys(choice.word for choice in self.choices))
        settings = {"rates": list(self.rates), "schemes": schemes, "kind": self.kind, "prim": list(self.prim)}
        if self.tolerances:
            settings["tolerances"] = list(self.tolerances)
        if self.library is not None:
            settings["library"] = self.library.name
        return settings
