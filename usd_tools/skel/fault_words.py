"""Faults in words and as rows of a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geomstats_anim.names import DROPOUT, GAP, SPIKE
from usd_tools.console.text import counted

SIGN_FLIP = "sign flip"
"""Quaternions with the other sign than their neighbours: the same rotations, on which editors of components stumble."""

KINDS = (GAP, SPIKE, DROPOUT, SIGN_FLIP)

HEADER = ("fault", "joint", "time codes", "samples", "size")

_A_FEW = 2
"""Joints that are named where many have the same fault at the same time."""


def count_kinds(faults: Sequence[dict[str, Any]]) -> str:
    """Count faults by kind, such as "1 gap, 2 spikes"; "" for none."""
    counts = {kind: sum(fault["kind"] == kind for fault in faults) for kind in KINDS}
    return ", ".join(counted(count, kind) for kind, count in counts.items() if count)


def fault_rows(faults: Sequence[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Return rows for `HEADER`, in order of time; what joints have together is one row, with the largest size.

    Parameters
    ----------
    faults : sequence of dict
        See `ClipFault.as_dict`.
    """
    together: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for fault in sorted(faults, key=lambda fault: (fault["start"], KINDS.index(fault["kind"]))):
        place = fault["kind"], fault["channel"], fault["start"], fault["end"], fault.get("repaired", True)
        together.setdefault(place, []).append(fault)
    return [
        (
            kind if repaired else f"{kind}, left",
            _joints(channel, alike),
            f"{start:g}" if start == end else f"{start:g} to {end:g}",
            str(alike[0]["samples"]),
            _size(alike),
        )
        for (kind, channel, start, end, repaired), alike in together.items()
    ]


def _joints(channel: str, faults: Sequence[dict[str, Any]]) -> str:
    names = [fault["joint_name"] for fault in faults]
    more = f" and {len(names) - _A_FEW} more" if len(names) > _A_FEW else ""
    of = "" if channel == "rotations" else f" ({channel})"
    return ", ".join(names[:_A_FEW]) + more + of


def _size(faults: Sequence[dict[str, Any]]) -> str:
    for unit, word in (("degrees", "degrees"), ("centimetres", "cm")):
        sizes = [fault[unit] for fault in faults if fault[unit] is not None]
        if sizes:
            return f"{max(sizes):.1f} {word}"
    return ""
