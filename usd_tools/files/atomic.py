"""Write files beside and rename them, so that a half-made file is never left behind."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pxr import Tf

from usd_tools.console.errors import ToolError
from usd_tools.files.openusd_errors import TEMPORARY, commentary


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
            f"{tempfile.gettempdir()} has no room for a temporary file: {error.strerror}; make room there, or name "
            "another folder in the environment variable TMPDIR."
        ) from error


@contextmanager
def written_beside(path: Path) -> Iterator[Path]:
    """Yield a path to write to, and rename what is there afterwards; on an error nothing is left behind.

    A process that is killed leaves the new folder, which is hidden, named after the file, and may be deleted.

    Parameters
    ----------
    path : Path
        File to be made or replaced.

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
            os.replace(beside, path)
    except OSError as error:
        raise ToolError(f"{path} cannot be written: {error.strerror}.") from error
    except Tf.ErrorException as error:
        raise ToolError(f"{path} cannot be written: {commentary(error).rstrip('.')}.") from error


def write_json(path: Path, value: Any) -> None:
    """Write plain values as JSON, beside and renamed."""
    with written_beside(path) as beside:
        beside.write_text(json.dumps(value, indent=2) + "\n", encoding="utf-8")
