"""Contents of the script elements of a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

STAGE = tuple(Path(__file__).with_name(name) for name in ("character.js", "stage.js"))
"""Scripts that draw characters; those of a page come after them."""


def read_scripts(*paths: Path) -> list[str]:
    """Read scripts, those of `STAGE` first."""
    return [path.read_text(encoding="utf-8") for path in (*STAGE, *paths)]


def script_json(value: Any) -> str:
    """Write JSON that may stand in a script element: no name in it can end that."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")
