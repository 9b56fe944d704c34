"""Read names of joints from a file, and make them from free text."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Tf, Usd, Vt

from usd_tools.console.errors import ToolError
from usd_tools.console.text import counted


def read_names(prim: Usd.Prim, name: str) -> tuple[str, ...]:
    """Read an attribute of tokens; empty if it has no value.

    Raises
    ------
    ToolError
        If it holds something else.
    """
    value = prim.GetAttribute(name).Get()
    if value is not None and not isinstance(value, Vt.TokenArray):
        raise ToolError(f"{prim.GetPath()}: {name} is not of type token[]; repair the file.")
    return tuple(value or ())


def names_note(prim: Usd.Prim) -> str | None:
    """Return a warning if names of joints are no paths, so that OpenUSD takes every such joint for a root."""
    bad = [name for name in read_names(prim, "joints") if not _is_path(name)]
    if not bad:
        return None
    return (
        f"{prim.GetPath()}: {counted(len(bad), 'joint name')} with spaces or dots, such as {bad[0]!r}, cannot be "
        "paths, so USD makes these joints roots; rename them, with underscores instead."
    )


def _is_path(name: str) -> bool:
    return Sdf.Path.IsValidPathString(name) and Sdf.Path(name).IsPrimPath()


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
    """Make names unique: the second ends in _1, the third in _2; names that are taken are passed over."""
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
