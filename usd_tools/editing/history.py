"""Steps of edits that can be undone and redone, and a session's form in JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from geomstats_anim.strict_json import dump_json, parse_json, read_text
from usd_tools.console.errors import ToolError
from usd_tools.editing.edits import Edit, as_dict, from_dict
from usd_tools.files.atomic import written_beside

FORMAT, VERSION = "geomstatsAnimSession", 1

Step = tuple[Edit, ...]
"""Edits that are undone together."""


@dataclass(frozen=True)
class LibraryOrigin:
    """Library that a session uses.

    Parameters
    ----------
    file : str
        Its name.
    sha256 : str
        Of the file, in hexadecimal digits.
    """

    file: str
    sha256: str

    def __str__(self) -> str:
        """Name the file, and begin its sum."""
        return f"{self.file} (sha256 {self.sha256[:12]})"


@dataclass(frozen=True)
class SessionFile:
    """Stored form of a session.

    Parameters
    ----------
    source : str
        Name of the file that was edited.
    sha256 : str
        Of the file, in hexadecimal digits.
    prim : str
        Path of the SkelAnimation.
    steps : tuple of Step
    library : LibraryOrigin or None
    """

    source: str
    sha256: str
    prim: str
    steps: tuple[Step, ...]
    library: LibraryOrigin | None = None

    def to_json(self) -> str:
        """Return the session as JSON."""
        document: dict[str, Any] = {
            "format": FORMAT,
            "version": VERSION,
            "source": self.source,
            "sha256": self.sha256,
            "prim": self.prim,
            **({} if self.library is None else {"library": asdict(self.library)}),
            "steps": [[as_dict(edit) for edit in step] for step in self.steps],
        }
        return dump_json(document, indent=2) + "\n"

    @classmethod
    def from_json(cls, text: str) -> SessionFile:
        """Read what `to_json` wrote.

        Raises
        ------
        ToolError
            If the text is no session.
        """
        try:
            document = parse_json(text)
        except ValueError as error:
            raise ToolError(f"The session cannot be read: {error}") from error
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise ToolError(f'This JSON is no session: its "format" is not "{FORMAT}".')
        if document.get("version") != VERSION:
            raise ToolError(f"This session has version {document.get('version')}, but this program reads {VERSION}.")
        steps, words = document.get("steps"), [document.get(name) for name in ("source", "sha256", "prim")]
        if not isinstance(steps, list) or not all(isinstance(step, list) for step in steps):
            raise ToolError("This session has no list of steps.")
        if not all(isinstance(word, str) for word in words):
            raise ToolError("This session does not name its source, sha256 and prim.")
        source, sha256, prim = map(str, words)
        library = _library(document.get("library"))
        return cls(source, sha256, prim, tuple(tuple(map(from_dict, step)) for step in steps), library)


def _library(document: Any) -> LibraryOrigin | None:
    if document is None:
        return None
    file, sha256 = (document.get(name) if isinstance(document, dict) else None for name in ("file", "sha256"))
    if not isinstance(file, str) or not isinstance(sha256, str):
        raise ToolError("This session does not name the file and sha256 of its library.")
    return LibraryOrigin(file, sha256)


def autosave_path(out: Path) -> Path:
    """Return where the edits that lead to an output are saved while it is not written yet."""
    return out.with_name(f"{out.name}.edits.json")


def write_session(path: Path, text: str) -> None:
    """Write a session as JSON, beside and renamed.

    Raises
    ------
    ToolError
        If it cannot be written.
    """
    with written_beside(path) as beside:
        beside.write_text(text, encoding="utf-8")


def read_session(path: Path) -> str:
    """Read the JSON of a session.

    Raises
    ------
    ToolError
        If it cannot be read.
    """
    try:
        return read_text(path)
    except (OSError, ValueError) as error:
        raise ToolError(f"{path} cannot be read as a session: {error}") from error
