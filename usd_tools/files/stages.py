"""Open stages, write layers, and list the files that they depend on."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

from pxr import Ar, Sdf, Tf, Usd, UsdUtils

from usd_tools.console.errors import Messages, ToolError
from usd_tools.files.openusd_errors import commentary, reading, usd_unheard
from usd_tools.files.paths import EXTENSIONS, check_input, extension


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
    if extension(path) not in EXTENSIONS:
        raise ToolError(f"{path} is not a USD file; its name must end in {', '.join(EXTENSIONS)}.")
    with reading(path):
        return Usd.Stage.Open(str(path))


def is_binary(path: Path) -> bool:
    """Return whether a file is a usdc, whatever its name says."""
    with path.open("rb") as file:
        return file.read(8) == b"PXR-USDC"


def export_layer(layer: Sdf.Layer, path: Path, usd_format: str | None = None, check: bool = False) -> None:
    """Write a layer to a file.

    Parameters
    ----------
    layer : Sdf.Layer
    path : Path
    usd_format : str
        "usda" or "usdc" for a file that ends in .usd.
        Optional, default: "usdc".
    check : bool
        Whether to read it again: of damaged files OpenUSD may write what it cannot read.
        Optional, default: False.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    arguments = {"format": usd_format or "usdc"} if extension(path) == ".usd" else {}
    if not layer.Export(str(path), args=arguments):
        raise ToolError(f"{path.name} cannot be written; check that the disk has space.")
    if check:
        try:
            Sdf.Layer.OpenAsAnonymous(str(path))
        except Tf.ErrorException as error:
            raise ToolError(f"{path.name} could not be read back: {commentary(error).rstrip('.')}.") from error


def stage_path(stage: Usd.Stage) -> Path:
    """Return the file of a stage's root layer; of a stage that is in no file, its name."""
    root = stage.GetRootLayer()
    return Path(root.realPath or root.GetDisplayName() or "stage")


def stage_sha256(stage: Usd.Stage) -> str:
    """Hash the file of a stage's root layer, or the layer's text where it is not what the file is; hexadecimal."""
    root = stage.GetRootLayer()
    if root.realPath and not root.dirty:
        return hashlib.sha256(Path(root.realPath).read_bytes()).hexdigest()
    return hashlib.sha256(root.ExportToString().encode()).hexdigest()


def missing_files(path: Path) -> list[str]:
    """Return the names of the files that a USD file references but that cannot be found."""
    return _innermost(_dependencies(path)[2])


def files_outside(path: Path) -> list[str]:
    """Return the files that a USD file needs and that are not in its folder, or below it, as seen from there."""
    layers, assets, _ = _dependencies(path)
    folder = path.resolve().parent
    names = [layer.realPath for layer in layers] + assets
    needed = {Path(Ar.SplitPackageRelativePathOuter(name)[0]).resolve() for name in names}
    return sorted(os.path.relpath(file, folder) for file in needed if not file.is_relative_to(folder))


def describe_dependencies(path: Path, messages: Messages) -> str:
    """Return a sentence, without its dot, on the other files that a USD file needs; warn of those that are missing."""
    layers, assets, missing = _dependencies(path)
    if missing:
        messages.warn(f"{path} references files that cannot be found: {', '.join(_innermost(missing))}.")
    names = [layer.realPath for layer in layers] + assets + missing
    files = {Path(Ar.SplitPackageRelativePathOuter(name)[0]).resolve() for name in names}  # of packages, the packages
    others = sorted({file.name for file in files if file != path.resolve()})
    return f"It also needs {', '.join(others)}" if others else "It needs no other file"


def _innermost(names: Iterable[str]) -> list[str]:
    """Return names of files without their folders, and without the packages that they are in."""
    return sorted({Path(Ar.SplitPackageRelativePathInner(name)[1] or name).name for name in names})


def _dependencies(path: Path) -> tuple[list[Sdf.Layer], list[str], list[str]]:
    """Call `UsdUtils.ComputeAllDependencies`, and keep it from printing what it does not find."""
    with usd_unheard():
        held = Sdf.Layer.Find(str(path))
        if held:
            held.Reload()  # OpenUSD may still hold what the file was before
        layers, assets, missing = UsdUtils.ComputeAllDependencies(str(path))
    return list(layers), list(assets), list(missing)
