"""Colours and markers of schemes in figures and on the page: the papers' colours, and others that differ from them."""

from __future__ import annotations

from dataclasses import dataclass

INK, FAINT, PAPER, TRUTH = "#2b2d42", "#85879a", "#ffffff", "#b9bac4"


@dataclass(frozen=True)
class Look:
    """Colour and marker of a scheme, and whether its lines are dashed."""

    color: str
    marker: str
    dashed: bool = False


_LOOKS = {
    "constant": Look("#1d9a8a", "s"),
    "linear": Look("#f07f1b", "v"),
    "slerp": Look("#e8b400", "D"),
    "squad": Look("#3d8bd9", "^"),
    "rotation-spline": Look("#7d5a44", "P"),
    "geodesic": Look("#7b3fb5", "o"),
    "geodesic-spline": Look("#d81b60", "o"),
    "learned": Look("#4f9d2f", "*"),
}
_FAMILIES = {"geodesic": "#4a2177", "geodesic-spline": "#8c0f3c"}
_OTHER = Look("#5c6b73", "X")


def look(word: str) -> Look:
    """Look up a scheme, by its word: a family after a colon is a darker shade, dashed."""
    scheme, _, family = word.partition(":")
    plain = _LOOKS.get(scheme, _OTHER)
    return Look(_FAMILIES.get(scheme, plain.color), plain.marker, dashed=True) if family else plain


def percent(share: float) -> str:
    """Write a share as percent."""
    return f"{100.0 * share:g} %"
