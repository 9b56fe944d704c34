"""Write files beside and rename them, so that a half-made file is never left behind."""

from __future__ import annotations

import json
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from pxr import Tf

from usd_tools.console.errors import ToolError
from usd_tools.files.openusd_errors import TEMPORARY, commentary

Verify = Callable[[Path], None]
"""Raises if a file is not as it should be."""


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield a folder that is removed afterwards.

    Raises
    ------
    ToolError
        If the system has no room for what is written there.
    """
    try:
        with tempfile.TemporaryDirectory(prefix=TEMPORARY) as folder:
            yield Path(folder)
    except OSError as error:
        raise ToolError(
            f"{tempfile.gettempdir()} has no space for a temporary file: {error.strerror}; free some, or set TMPDIR "
            "to another folder."
        ) from error


@contextmanager
def written_beside(path: Path, verify: Verify | None = None) -> Iterator[Path]:
    """Yield a path to write to, and rename what is there afterwards; on an error nothing is left behind.

    A process that is killed leaves the new folder, which is hidden, named after the file, and may be deleted.

    Parameters
    ----------
    path : Path
        File to be made or replaced; its mode, owner and group stay, where the system allows.
    verify : callable
        Called before the renaming with another name of the new file, in the folder of `path`, from where the files
        that it names are found; what it raises keeps the old file.
        Optional, default: none.

    Yields
    ------
    beside : Path
        A file of the same name in a new folder beside it.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    try:
        # The folder's whole path, for `errors` takes it out of what OpenUSD says.
        with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent.absolute()) as folder:
            beside = Path(folder) / path.name
            yield beside
            if verify is not None:
                _verify_in(path.parent, beside, verify)
            _take_rights(beside, path)
            os.replace(beside, path)
    except OSError as error:
        raise ToolError(f"{path} cannot be written: {error.strerror}.") from error
    except Tf.ErrorException as error:
        raise ToolError(f"{path} cannot be written: {commentary(error).rstrip('.')}.") from error


def _verify_in(folder: Path, beside: Path, verify: Verify) -> None:
    name = folder / f"{beside.parent.name}{beside.suffix}"
    try:
        os.link(beside, name)
    except OSError:  # a file system without links
        shutil.copyfile(beside, name)
    try:
        verify(name)
    finally:
        name.unlink()


def _take_rights(beside: Path, path: Path) -> None:
    """Give a file the mode, owner and group of the one that it will replace, if there is one."""
    try:
        old = path.stat()
    except FileNotFoundError:
        return
    with suppress(OSError, AttributeError):  # only an administrator gives files away; Windows has no owners
        os.chown(beside, old.st_uid, old.st_gid)
    beside.chmod(stat.S_IMODE(old.st_mode))


def write_json(path: Path, value: Any) -> None:
    """Write plain values as JSON, beside and renamed."""
    with written_beside(path) as beside:
        beside.write_text(json.dumps(value, indent=2) + "\n", encoding="utf-8")
