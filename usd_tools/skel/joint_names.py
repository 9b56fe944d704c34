"""Names of joints: those that USD takes, from names that are free text, and short ones for tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from pxr import Sdf, Tf


def joint_paths(names: Sequence[str], parents: Sequence[int]) -> list[str]:
    """Make the full path tokens of joints.

    Parameters
    ----------
    names : sequence of str, shape=[B]
    parents : sequence of int, shape=[B]
        Index of each joint's parent, -1 for a root. Parents come before their children.

    Returns
    -------
    paths : list of str, shape=[B]
        Their last parts are identifiers, none of them twice.
    """
    valid = [name if Sdf.Path.IsValidIdentifier(name) else Tf.MakeValidIdentifier(name) for name in names]
    paths: list[str] = []
    for identifier, parent in zip(unique(valid), parents, strict=True):
        paths.append(f"{paths[parent]}/{identifier}" if parent >= 0 else identifier)
    return paths


def unique(names: Sequence[str]) -> list[str]:
    """Tell names apart that repeat: the second ends in _1, the third in _2; names that are taken are passed over."""
    taken, told_apart = set(names), []
    seen: set[str] = set()
    for name in names:
        new, number = name, 0
        while new in seen or (number and new in taken):
            number += 1
            new = f"{name}_{number}"
        seen.add(new)
        told_apart.append(new)
    return told_apart


def short_names(joints: Sequence[str]) -> dict[str, str]:
    """Take as much from the end of each joint's path as tells it from the others.

    Parameters
    ----------
    joints : sequence of str
        Full paths.

    Returns
    -------
    names : dict
        By path.
    """
    ends = {joint: _ends(joint) for joint in joints}
    counts = Counter(end for each in ends.values() for end in each)
    return {joint: next((end for end in each if counts[end] == 1), joint) for joint, each in ends.items()}


def _ends(joint: str) -> list[str]:
    """All ends of a path, the shortest first."""
    parts = joint.split("/")
    return ["/".join(parts[start:]) for start in reversed(range(len(parts)))]
