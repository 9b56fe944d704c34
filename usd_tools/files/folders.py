"""Make a folder as a whole: fill it beside, and rename it when everything is in it."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from usd_tools.console.errors import ToolError

MARK = "results.json"
"""File of which the entry `tool` says what made the folder."""


def check_folder(folder: Path, tool: str, contents: Collection[str], sources: Iterable[str | Path]) -> None:
    """Check that a folder can be made or replaced, before any work is done.

    Parameters
    ----------
    folder : Path
        Value of `--out`.
    tool : str
        What makes it.
    contents : collection of str
        Names of what it makes there; a folder with anything else is not replaced.
    sources : iterable of paths
        Files that are read, which must not be in it.

    Raises
    ------
    ToolError
        If something is in the way.
    """
    parent = Path(os.path.abspath(folder)).parent
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        what = "a link" if folder.is_symlink() else "a file"
        raise ToolError(f"--out {folder} is {what}; name a folder.")
    if not parent.is_dir():
        raise ToolError(f"--out {folder}: there is no folder {parent}; make it first.")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise ToolError(f"--out {folder}: the folder {parent} cannot be written; choose another.")
    there = os.path.realpath(folder)
    for source in sources:
        if os.path.commonpath([there, os.path.realpath(source)]) == there:
            raise ToolError(f"--out {folder} holds the input {source} and would be replaced; choose another name.")
    found = sorted(entry.name for entry in folder.iterdir()) if folder.exists() else []
    foreign = [name for name in found if name not in contents]
    if not foreign and found and not _is_made_by(folder, tool):
        foreign = found
    if foreign:
        raise ToolError(f"--out {folder} holds {foreign[0]}, which {tool} did not write; choose another name.")


def _is_made_by(folder: Path, tool: str) -> bool:
    try:
        document = json.loads((folder / MARK).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and document.get("tool") == tool


@contextmanager
def made_beside(folder: Path) -> Iterator[Path]:
    """Yield a new folder to fill, and rename it afterwards; on an error nothing is left behind.

    Parameters
    ----------
    folder : Path
        To be made or replaced.

    Yields
    ------
    beside : Path
        In the same parent folder, so that relative paths from within stay true.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    folder = Path(os.path.abspath(folder))
    try:
        with tempfile.TemporaryDirectory(
            prefix=f".{folder.name}.", dir=folder.parent, ignore_cleanup_errors=True
        ) as name:
            beside = Path(name)
            yield beside
            mask = os.umask(0)
            os.umask(mask)
            beside.chmod(0o777 & ~mask)  # a temporary folder is closed to others
            if folder.exists():
                with tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent) as old:
                    aside = Path(old, folder.name)
                    os.replace(folder, aside)
                    try:
                        os.replace(beside, folder)
                    except OSError:
                        os.replace(aside, folder)
                        raise
            else:
                os.replace(beside, folder)
    except OSError as error:
        raise ToolError(f"{folder} cannot be written: {error.strerror}.") from error
