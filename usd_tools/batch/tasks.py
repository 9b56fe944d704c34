"""Choice of the files that are read and of where the output of each goes: the tree of a folder is kept."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from usd_tools.console.errors import ToolError, UsageError
from usd_tools.console.text import listed
from usd_tools.files.paths import EXTENSIONS, extension, files_below, same_file


@dataclass(frozen=True)
class FileTask:
    """One file to work on.

    Parameters
    ----------
    source : Path
    name : str
        As seen from the folder that it was found in, forward slashes.
    out : Path or None
        File to write; None where the source is changed in place, or nothing is written.
    """

    source: Path
    name: str
    out: Path | None


def is_batch(args: argparse.Namespace) -> bool:
    """Return whether several files, or a folder, are named on a command line.

    Raises
    ------
    UsageError
        If there is one file only, and an option for several.
    """
    if len(args.input) > 1 or args.input[0].is_dir():
        return True
    given = next((word for word in ("jobs", "skip_existing", "address", "cpus") if getattr(args, word)), None)
    if given is not None:
        raise UsageError(f"--{given.replace('_', '-')} is for several files or a folder; leave it out")
    return False


def find_tasks(
    inputs: Sequence[Path], out: Path | None, extensions: Sequence[str], suffix: str | None
) -> list[FileTask]:
    """Find the files that are named, and those in folders and in folders within them.

    Parameters
    ----------
    inputs : sequence of Path
        Files and folders. Of a folder, hidden files are left out, and what is in the output folder.
    out : Path or None
        Output folder, made where it is not there.
    extensions : sequence of str
        Of the files that are read.
    suffix : str or None
        Extension of the outputs; None for that of each source.

    Returns
    -------
    tasks : list of FileTask
        In the order named; those of a folder in the order of their names.

    Raises
    ------
    ToolError
        If a folder has no file to read, two outputs would be one file, or the output folder cannot be made.
    """
    if out is not None:
        _check_out(inputs, out)
    tasks: list[FileTask] = []
    for path in inputs:
        found = files_below(path, extensions, leave_out=out) if path.is_dir() else [path]
        if not found:
            raise ToolError(f"{path} contains no file that ends in {listed(extensions)}, nor do its subfolders.")
        for file in found:
            name = file.relative_to(path) if path.is_dir() else Path(file.name)
            target = None if out is None else out / (name if suffix is None else name.with_suffix(suffix))
            tasks.append(FileTask(file, name.as_posix(), target))
    _check_distinct(tasks)
    return tasks


def _check_out(inputs: Sequence[Path], out: Path) -> None:
    if not out.is_dir() and (out.exists() or extension(out) in (*EXTENSIONS, ".bvh")):
        raise ToolError(f"--out {out} is a file; name a folder, for IN is a folder or several files.")
    parent = Path(os.path.abspath(out)).parent
    if not parent.is_dir():
        raise ToolError(f"--out {out}: there is no folder {parent}; make it first.")
    if not os.access(out if out.exists() else parent, os.W_OK | os.X_OK):
        raise ToolError(f"--out {out} cannot be written; change its permissions, or choose another folder.")
    for path in inputs:
        if same_file(out, [path if path.is_dir() else path.parent]):
            raise ToolError(f"--out {out} is the folder of the input {path}; choose another folder.")


def _check_distinct(tasks: Sequence[FileTask]) -> None:
    """Refuse tasks of which one would write over the output of another, or read a file twice."""
    seen: dict[Path, FileTask] = {}
    for task in tasks:
        target = Path(os.path.abspath(task.out or task.source))
        if target in seen:
            raise ToolError(
                f"{seen[target].source} and {task.source} have the same output {task.out or task.source}; call the "
                "command once for each folder."
            )
        seen[target] = task
