"""Help of a library for a clip, in words and as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geomstats_anim.interpolation.learned_scheme import Help
from usd_tools.console.text import short_names


def shares(helps: Sequence[Help]) -> list[dict[str, Any]]:
    """Return the share of each part of the body, the mean over the stretches of a clip."""
    found = [each.parts for each in helps if each.parts]
    if not found:
        return []
    names = short_names([part.joint for part in found[0]])
    return [
        {"part": part.part, "joint": names[part.joint], "share": round(float(np.mean(column)), 3)}
        for part, column in zip(found[0], np.transpose([[p.share for p in parts] for parts in found]), strict=True)
    ]


def help_sentence(library: Mapping[str, Any]) -> str:
    """Say what a library does for a clip: "RIG.inbetween helps ...: arms 1, legs .8, torso 0"."""
    by_part: dict[str, list[str]] = {}
    for each in library["shares"]:
        share = f"{each['share']:.2f}".rstrip("0").rstrip(".").removeprefix("0") or "0"
        known = by_part.setdefault(each["part"], [])
        if share not in known:
            known.append(share)
    if not any(each["share"] for each in library["shares"]):
        return f"the library {library['file']} does not help this clip; the spline is used."
    words = (f"{part if part == 'torso' else part + 's'} {' and '.join(known)}" for part, known in by_part.items())
    return f"the library {library['file']} helps, for motions like those in it: {', '.join(words)}."
