"""Presets: named lists of edits, those that come with the program and those in a folder of the user's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from geomstats_anim.strict_json import dump_json, parse_json, read_text
from usd_tools.console.errors import ToolError
from usd_tools.editing.edits import Edit, Reset, UseScheme, as_dict, from_dict
from usd_tools.files.atomic import written_beside
from usd_tools.upsampling.joint_styles import Style

_FORMAT = "geomstatsAnimPreset"

PRESETS: dict[str, tuple[Edit, ...]] = {
    "slerp": (UseScheme("geodesic"), Reset()),
    "smooth": (UseScheme("geodesic-spline"), Reset()),
    "soft": (UseScheme("geodesic-spline"), Reset(), Style("*", tension=2.0, translation_tension=2.0)),
    "snappy": (UseScheme("geodesic-spline"), Reset(), Style("*", tension=0.3, translation_tension=0.3)),
}
"""Those that come with the program.

"slerp": geodesics of the bi-invariant metric, on which alpha and beta act at once. "smooth": the plain spline, with
continuous velocity. "soft": with continuous acceleration. "snappy": bent little, so that motion changes at the keys.
None has what the papers learned: they publish no values of alpha and beta.
"""


def read_presets(folder: Path) -> dict[str, tuple[Edit, ...]]:
    """Read the presets in a folder, every file that ends in .json; by the names of the files, without the ending.

    Raises
    ------
    ToolError
        If a file is no preset.
    """
    return {path.stem: read_preset(path) for path in sorted(folder.glob("*.json"))}


def write_preset(path: Path, edits: Sequence[Edit]) -> None:
    """Write edits as a preset.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    document = {"format": _FORMAT, "version": 1, "edits": [as_dict(edit) for edit in edits]}
    with written_beside(path) as beside:
        beside.write_text(dump_json(document, indent=2) + "\n", encoding="utf-8")


def read_preset(path: Path) -> tuple[Edit, ...]:
    """Read what `write_preset` has written.

    Raises
    ------
    ToolError
        If it is no preset.
    """
    try:
        document = parse_json(read_text(path))
    except (OSError, ValueError) as error:
        raise ToolError(f"{path} cannot be read as a preset: {error}") from error
    if not isinstance(document, dict) or document.get("format") != _FORMAT or document.get("version") != 1:
        raise ToolError(f'{path} is no preset; its "format" is not "{_FORMAT}", or its version is another.')
    edits = document.get("edits")
    if not isinstance(edits, list):
        raise ToolError(f"{path} is no preset; it has no list of edits.")
    return tuple(map(from_dict, edits))
