"""Make a folder as a whole: fill it beside, and rename it when everything is in it."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from usd_tools.console.errors import ToolError

MANIFEST = "manifest.json"
"""File that names what made the folder, and every file that it made there."""


def check_folder(folder: Path, tool: str, sources: Iterable[str | Path]) -> None:
    """Check that a folder can be made or replaced, before any work is done.

    Parameters
    ----------
    folder : Path
        Value of `--out`.
    tool : str
        What makes it; a folder with any file that is not in its manifest is not replaced.
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
        raise ToolError(f"--out {folder}: the folder {parent} may not be written; choose another.")
    there = os.path.realpath(folder)
    for source in sources:
        if os.path.commonpath([there, os.path.realpath(source)]) == there:
            raise ToolError(f"--out {folder} holds the input {source} and would be replaced; choose another name.")
    foreign = _foreign_files(folder, tool)
    if foreign:
        raise ToolError(f"--out {folder} holds {foreign[0]}, which {tool} did not write; choose another name.")


def _foreign_files(folder: Path, tool: str) -> list[str]:
    """Return the files in a folder, in any depth, that its manifest does not name."""
    files = _files_in(folder)
    try:
        document = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        ours = set(document["files"]) if document["tool"] == tool else set()
    except (OSError, ValueError, LookupError, TypeError):
        ours = set()
    return [file for file in files if file not in ours]


def _files_in(folder: Path) -> list[str]:
    """Return the files and links in a folder, in any depth, as seen from it."""
    found = (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())
    return sorted(path.relative_to(folder).as_posix() for path in found)


@contextmanager
def made_beside(folder: Path, tool: str) -> Iterator[Path]:
    """Yield a new folder to fill, and rename it afterwards; on an error nothing is left behind.

    Parameters
    ----------
    folder : Path
        To be made or replaced.
    tool : str
        What makes it.

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
            manifest = {"tool": tool, "files": sorted([MANIFEST, *_files_in(beside)])}
            (beside / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
            mask = os.umask(0)
            os.umask(mask)
            beside.chmod(0o777 & ~mask)  # a temporary folder is closed to others
            if folder.exists():
                _swap(beside, folder, tool)
            else:
                os.replace(beside, folder)
    except OSError as error:
        raise ToolError(f"{folder} cannot be written: {error.strerror}.") from error


def _swap(beside: Path, folder: Path, tool: str) -> None:
    """Put a new folder in the place of an older one, whose files the manifest names; others move to the new one."""
    with tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent) as old:
        aside = Path(old, folder.name)
        os.replace(folder, aside)
        try:
            for file in _foreign_files(aside, tool):  # they came while the new folder was filled
                kept = beside / file
                kept.parent.mkdir(parents=True, exist_ok=True)
                os.replace(aside / file, kept.with_name(f"{kept.name}.kept") if kept.exists() else kept)
            os.replace(beside, folder)
        except OSError:
            os.replace(aside, folder)
            raise
