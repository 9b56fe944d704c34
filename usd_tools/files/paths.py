"""Check paths before any work is done: what may be read, and what may be written."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from usd_tools.console.errors import ToolError

EXTENSIONS = (".usd", ".usda", ".usdc", ".usdz")


def extension(path: Path) -> str:
    """Return the end of a file's name by which OpenUSD knows its format, in small letters."""
    return path.suffix.lower()


def files_below(folder: Path, extensions: Sequence[str], leave_out: Path | None = None) -> list[Path]:
    """Find the files with some extensions in a folder and in folders within it, hidden ones left out.

    Parameters
    ----------
    folder : Path
    extensions : sequence of str
        Such as ".usda", in small letters.
    leave_out : Path
        Folder that is not searched.
        Optional, default: none.

    Returns
    -------
    files : list of Path
        In the order of their names.
    """
    elsewhere = None if leave_out is None else leave_out.resolve()
    return [
        path
        for path in sorted(folder.rglob("*"))
        if extension(path) in extensions
        and not any(part.startswith(".") for part in path.relative_to(folder).parts)
        and path.is_file()
        and not (elsewhere is not None and path.resolve().is_relative_to(elsewhere))
    ]


def check_input(path: Path, what: str) -> None:
    """Check that a file can be read.

    Parameters
    ----------
    path : Path
    what : str
        Description of what it should be, for the message.

    Raises
    ------
    ToolError
        If there is no such file, it is a folder, or it may not be read.
    """
    if not path.exists():
        raise ToolError(f"{path}: there is no such file.")
    if not path.is_file():
        raise ToolError(f"{path} is not a file; name {what}.")
    if not os.access(path, os.R_OK):
        raise ToolError(f"{path} cannot be read; change its permissions.")


def check_output(path: Path, argument: str) -> None:
    """Check that a file can be written, before any work is done.

    Parameters
    ----------
    path : Path
    argument : str
        Argument that names it, for the message.

    Raises
    ------
    ToolError
        If it is a folder, a device or read-only, or its folder is missing or may not be written.
    """
    if path.is_dir():
        raise ToolError(f"{argument} {path} is a folder; name a file in it.")
    if path.exists() and not path.is_file():
        raise ToolError(f"{argument} {path} is not a file, but a device or a pipe; name a file.")
    if not path.parent.is_dir():
        raise ToolError(f"{argument} {path}: there is no folder {path.parent}; make it first.")
    if path.exists() and not os.access(path, os.W_OK):
        raise ToolError(f"{argument} {path} is read-only; change its permissions, or choose another name.")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise ToolError(f"{argument} {path}: the folder {path.parent} cannot be written; choose another.")


def check_usd_output(path: Path, usd_format: str | None) -> None:
    """Check the name of a USD file to be written, and `check_output`.

    Raises
    ------
    ToolError
        If the extension is not one of USD's, or `--usdFormat` does not go with it.
    """
    if extension(path) not in EXTENSIONS:
        raise ToolError(f"--out {path}: the name must end in {', '.join(EXTENSIONS)}.")
    if usd_format is not None and extension(path) != ".usd":
        raise ToolError(f"--usdFormat {usd_format} needs an --out that ends in .usd, not {path}.")
    check_output(path, "--out")


def same_file(path: Path, others: Iterable[str | Path]) -> bool:
    """Return whether a path leads to one of the others, however they are spelled, links included."""
    # Asking the system and not comparing names: some disks do not tell capital letters from small ones.
    return path.exists() and any(os.path.exists(other) and os.path.samefile(path, other) for other in others)


def relative_asset_path(target: Path, folder: Path) -> str:
    """Path of a file as seen from a folder, the way USD writes it: `./` or `../` first, forward slashes.

    Links are not followed: USD resolves `..` in names, not on the disk.
    """
    relative = os.path.relpath(os.path.abspath(target), os.path.abspath(folder)).replace(os.sep, "/")
    return relative if relative.startswith("../") else f"./{relative}"
