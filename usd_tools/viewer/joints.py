"""Joints as the page names them: a tree in a list, one line each."""

from __future__ import annotations

from collections.abc import Sequence

from usd_tools.console.text import printable, short_names

EVERY = "all joints"
"""Line for all of them."""


def joint_lines(joints: Sequence[str], depths: Sequence[int]) -> list[str]:
    """Name joints by their short names, indented as in a tree; every line differs.

    Parameters
    ----------
    joints : sequence of str, shape=[B]
        Full path tokens.
    depths : sequence of int, shape=[B]
        1 for a root.
    """
    names = short_names(joints)
    lines: dict[str, None] = {}
    for joint, depth in zip(joints, depths, strict=True):
        line = f"{'· ' * (int(depth) - 1)}{printable(names[joint])}"
        while line in lines or line == EVERY:
            line += "'"  # names that differ only in what cannot be seen
        lines[line] = None
    return list(lines)
