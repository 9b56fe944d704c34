"""Summary that `repair` prints."""

from __future__ import annotations

from usd_tools.console.tables import show
from usd_tools.console.text import counted, say
from usd_tools.repairing.result import RepairedAnimation, RepairResult
from usd_tools.skel.fault_words import HEADER, SIGN_FLIP, count_kinds, fault_rows


def print_summary(result: RepairResult) -> None:
    """Print the faults of each animation, and a line on what was written."""
    for animation in result.animations:
        _print_animation(animation)
    if result.path is None:
        say("Dry run: nothing was written.")
    else:
        say(" ".join(filter(None, (f"Wrote {result.path}.", result.dependencies))))


def _print_animation(animation: RepairedAnimation) -> None:
    faults = animation.faults
    filtered = f"; filtered: {', '.join(animation.smoothed)}" if animation.smoothed else ""
    size = f"{counted(animation.samples, 'sample')}, {counted(animation.joints, 'joint')}"
    say(f"{animation.prim}: {size}; {count_kinds(faults) or 'no faults'}{filtered}")
    listed = [fault for fault in faults if fault["kind"] != SIGN_FLIP]
    if listed:
        show("Faults", fault_rows(listed), HEADER)
    flipped = sorted({fault["joint_name"] for fault in faults if fault["kind"] == SIGN_FLIP})
    if flipped:
        say(f"Signs made continuous: {', '.join(flipped)}.")
