"""Files: what may be read, what may be written, and writing beside and renaming."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Tf, Usd, UsdUtils

from usd_tools.console.errors import TEMPORARY, Messages, ToolError, commentary, usd_unheard

EXTENSIONS = (".usd", ".usda", ".usdc", ".usdz")


def open_stage(path: Path) -> Usd.Stage:
    """Open a USD file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    stage : Usd.Stage
        Keep it as long as anything on it is used.

    Raises
    ------
    ToolError
        If there is no such file, or it is not a USD file that can be read.
    """
    check_input(path, "a USD file")
    if path.suffix.lower() not in EXTENSIONS:
        raise ToolError(f"{path} is not a USD file; its name must end in {', '.join(EXTENSIONS)}.")
    with reading(path):
        return Usd.Stage.Open(str(path))


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what OpenUSD says of a broken file into an error: much of a file is read only when it is asked for.

    Raises
    ------
    ToolError
        If something in it cannot be read.
    """
    try:
        yield
    except Tf.ErrorException as error:
        raise ToolError(f"{path} cannot be read as USD: {commentary(error).rstrip('.')}.") from error
    except UnicodeDecodeError as error:
        raise ToolError(f"{path} cannot be read as USD: it has names that are not UTF-8.") from error


def check_input(path: Path, what: str) -> None:
    """Check that a file can be read.

    Parameters
    ----------
    path : Path
    what : str
        What it should be, for the message.

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
        raise ToolError(f"{path} may not be read; change its permissions.")


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
        raise ToolError(f"{argument} {path}: the folder {path.parent} may not be written; choose another.")


def check_usd_output(path: Path, usd_format: str | None) -> None:
    """Check the name of a USD file to be written, and `check_output`.

    Raises
    ------
    ToolError
        If the extension is not one of USD's, or `--usdFormat` does not go with it.
    """
    if path.suffix not in EXTENSIONS:
        raise ToolError(f"--out {path}: the name must end in {', '.join(EXTENSIONS)}.")
    if usd_format is not None and path.suffix != ".usd":
        raise ToolError(f"--usdFormat {usd_format} goes with a name that ends in .usd only, but --out is {path}.")
    check_output(path, "--out")


def same_file(path: Path, others: Iterable[str | Path]) -> bool:
    """Whether a path leads to one of the others, however they are spelled, links included."""
    # Asking the system and not comparing names: some disks do not tell capital letters from small ones.
    return path.exists() and any(os.path.exists(other) and os.path.samefile(path, other) for other in others)


def missing_files(path: Path) -> list[str]:
    """Name the files that a USD file is made of, but which are nowhere."""
    return _innermost(_dependencies(path)[2])


def standing(path: Path, messages: Messages) -> str:
    """Tell in a sentence without its dot which other files a USD file needs; warn of those that are nowhere."""
    layers, assets, missing = _dependencies(path)
    if missing:
        messages.warn(f"{path} needs what is nowhere: {', '.join(_innermost(missing))}.")
    names = [layer.realPath for layer in layers] + assets + missing
    files = {Path(Ar.SplitPackageRelativePathOuter(name)[0]).resolve() for name in names}  # of packages, the packages
    others = sorted({file.name for file in files if file != path.resolve()})
    return f"It needs {', '.join(others)} too" if others else "It stands alone"


def _innermost(names: Iterable[str]) -> list[str]:
    """Names of files without their folders, and without the packages that they are in."""
    return sorted({Path(Ar.SplitPackageRelativePathInner(name)[1] or name).name for name in names})


def _dependencies(path: Path) -> tuple[list[Sdf.Layer], list[str], list[str]]:
    """Call `UsdUtils.ComputeAllDependencies`, and keep it from printing what it does not find."""
    with usd_unheard():
        held = Sdf.Layer.Find(str(path))
        if held:
            held.Reload()  # OpenUSD may still hold what the file was before
        layers, assets, missing = UsdUtils.ComputeAllDependencies(str(path))
    return list(layers), list(assets), list(missing)


def relative_asset_path(target: Path, folder: Path) -> str:
    """Path of a file as seen from a folder, the way USD writes it: `./` or `../` first, forward slashes.

    Links are not followed: USD resolves `..` in names, not on the disk.
    """
    relative = os.path.relpath(os.path.abspath(target), os.path.abspath(folder)).replace(os.sep, "/")
    return relative if relative.startswith("../") else f"./{relative}"


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Give a folder that is gone afterwards.

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
    """Give a path to write to, and rename what is there afterwards; on an error nothing is left behind.

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
