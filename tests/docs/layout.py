"""The layout that CONTRIBUTING.md draws, as paths."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
UNLISTED = {"__init__.py", "__pycache__", "py.typed", "clips", "papers_experiment"}  # the last two are made by examples


def drawn(text):
    """Return {path: description} of the indented lines below the heading Layout; a folder ends in a slash."""
    block = re.search(r"^## Layout\n.*?^```text\n(.*?)^```", text, re.DOTALL | re.MULTILINE)[1]
    above, found = [], {}
    for line in block.splitlines():
        indent = len(line) - len(line.lstrip())
        name, _, words = line.strip().partition(" ")
        above[indent // 2 :] = [name]
        found["".join(above)] = words.strip()
    return found


def standing(folder):
    """Return the names in a folder, a slash after those of folders, as the layout would list them."""
    names = {f"{path.name}/" if path.is_dir() else path.name for path in (ROOT / folder).iterdir()}
    return {name for name in names if name.rstrip("/") not in UNLISTED and not name.startswith(".")}
