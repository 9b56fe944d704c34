"""Write and unpack usdz packages; the same input makes the same bytes, and packages from strangers do no harm."""

from __future__ import annotations

import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePath, PurePosixPath, PureWindowsPath

import numpy as np
from pxr import Sdf, UsdUtils

from usd_tools.console.errors import ToolError
from usd_tools.files.openusd_gaps import lost_by_packing
from usd_tools.files.stages import export_layer, missing_files

_LARGEST_RATIO = 100
"""Unpacked bytes per byte of a package: members of valid usdz are not compressed at all."""


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


def check_package(package: Path, largest: float) -> None:
    """Check that a usdz package can be unpacked without harm; only its directory is read.

    Parameters
    ----------
    package : Path
    largest : float
        Bytes that it may unpack to.

    Raises
    ------
    ToolError
        If it is broken, has a member that is absolute, climbs out of its folder or is listed twice, or is too large.
    """
    with _opened(package) as archive:
        members = archive.infolist()
    for name, count in Counter(member.filename for member in members).items():
        if any(_leaves_folder(path) for path in (PurePosixPath(name), PureWindowsPath(name))):
            raise ToolError(f"{package} has the member {name!r}, which lies outside the package; do not trust it.")
        if count > 1:
            raise ToolError(f"{package} lists the member {name!r} twice; pack it again.")
    size = sum(member.file_size for member in members)
    if size > _LARGEST_RATIO * package.stat().st_size:
        raise ToolError(
            f"{package} would unpack to {size / package.stat().st_size:.0f} times its size, which no valid usdz does; "
            "do not trust it."
        )
    if size > largest:
        raise ToolError(
            f"{package} would unpack to {size / 1e9:.3g} GB; if you trust it, allow that with --max-unpacked."
        )


def unpack(package: Path, folder: Path) -> Path:
    """Unpack a usdz package, and return its first file, which is the one that counts; see `check_package`.

    Raises
    ------
    ToolError
        If it is broken.
    """
    with _opened(package) as archive:
        # whatever a member is called, zipfile writes it below the folder, and returns where
        return [Path(archive.extract(member, folder)) for member in archive.infolist()][0]


@contextmanager
def _opened(package: Path) -> Iterator[zipfile.ZipFile]:
    """Open a package, and turn what is wrong with it into an error."""
    try:
        # OpenUSD writes names as UTF-8, but does not say so in the file.
        with zipfile.ZipFile(package, metadata_encoding="utf-8") as archive:
            if not archive.infolist():
                raise zipfile.BadZipFile("it is empty")
            yield archive
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as error:
        raise ToolError(f"{package} is broken: {str(error).rstrip('.')}; pack it again.") from error
    except UnicodeDecodeError as error:
        raise ToolError(f"{package} has names that are not UTF-8; pack it again.") from error


def _leaves_folder(path: PurePath) -> bool:
    return bool(path.anchor) or ".." in path.parts


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
