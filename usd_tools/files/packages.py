"""Write and unpack usdz packages; the same input makes the same bytes."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdUtils

from usd_tools.console.errors import ToolError
from usd_tools.files.openusd_gaps import lost_by_packing
from usd_tools.files.stages import export_layer, missing_files


def pack(layer: Sdf.Layer, root: Path, out: Path) -> None:
    """Write a layer to a file, and that with all that it needs to a usdz package.

    Parameters
    ----------
    layer : Sdf.Layer
    root : Path
        File to write the layer to.
    out : Path
        Package to write.

    Raises
    ------
    ToolError
        If something that it needs is missing or would be changed, or it cannot be written.
    """
    export_layer(layer, root)
    lost = lost_by_packing(root)
    if lost is not None:
        raise ToolError(
            f"{out.name} cannot be packed: OpenUSD drops the time offset of the sublayer {lost}; add --flatten, or "
            "choose a name that does not end in .usdz."
        )
    if not UsdUtils.CreateNewUsdzPackage(str(root), str(out)):
        missing = missing_files(root)
        if missing:
            raise ToolError(
                f"{out.name} cannot be packed, since it references files that cannot be found: {', '.join(missing)}."
            )
        raise ToolError(f"{out.name} cannot be packed; check that every file that the source needs exists.")
    try:
        _forget_times(out)
    except zipfile.BadZipFile as error:  # on a full disk OpenUSD says nothing
        raise ToolError(f"{out.name} cannot be written; check that the disk has space.") from error


def unpack(package: Path, folder: Path) -> Path:
    """Unpack a usdz package, and return its first file, which is the one that counts.

    Raises
    ------
    ToolError
        If it is broken.
    """
    try:
        # OpenUSD writes names as UTF-8, but does not say so in the file.
        with zipfile.ZipFile(package, metadata_encoding="utf-8") as archive:
            archive.extractall(folder)
            return folder / archive.namelist()[0]
    except zipfile.BadZipFile as error:
        raise ToolError(f"{package} is broken: {str(error).rstrip('.')}; pack it again.") from error
    except UnicodeDecodeError as error:
        raise ToolError(f"{package} has names that are not UTF-8; pack it again.") from error


def _forget_times(package: Path) -> None:
    """Set every file's time in a package to 1980, the oldest of zip's, so that the same input makes the same bytes."""
    date = b"\x00\x00\x21\x00"
    data = bytearray(package.read_bytes())
    with zipfile.ZipFile(package) as archive:
        entry = archive.start_dir
        for info in archive.infolist():
            data[info.header_offset + 10 : info.header_offset + 14] = date
            data[entry + 12 : entry + 16] = date
            sizes = np.frombuffer(data, dtype="<u2", count=3, offset=entry + 28)
            entry += 46 + int(sizes.sum())
    package.write_bytes(data)
