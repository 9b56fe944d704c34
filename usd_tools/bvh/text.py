"""The lines of a BVH file: whatever is wrong with them is told with its line, and pybvh can read what they come to.

pybvh passes over words that it does not know and braces that do not close, ends names at the first space, and refuses
position channels of joints other than the root, which Blender's exporter writes. So the lines are followed here first:
channels and numbers are taken from them, and the tree is put into a form that pybvh takes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NoReturn

import numpy as np

from usd_tools.console.errors import ToolError

CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
"""The channels that a joint may have, as they are spelled here; files may spell them in any case."""

LARGEST = float(np.finfo(np.float32).max)
"""Larger numbers do not fit into a USD file."""

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_IN_BLOCK = ("JOINT", "END", "}")
_SPELLED = {"END": "End Site"}


@dataclass
class BvhText:
    """What the lines of a BVH file say.

    Parameters
    ----------
    names : list of str, shape=[B]
        Of the joints, as in the file.
    channels : list of tuple of str, shape=[B]
        Of each joint, in the order of the file: names of `CHANNELS`.
    plain : list of str
        The tree as lines that pybvh reads: the same joints, offsets and end sites, but three rotations for each joint.
    frame_time : Decimal
        Seconds from frame to frame, with the digits of the file.
    table : array-like, shape=[F, C]
        The numbers, one column for each channel.
    """

    names: list[str] = field(default_factory=list)
    channels: list[tuple[str, ...]] = field(default_factory=list)
    plain: list[str] = field(default_factory=list)
    frame_time: Decimal = Decimal(0)
    table: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))


def read_text(path: Path) -> BvhText:
    """Read the lines of a BVH file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    text : BvhText

    Raises
    ------
    ToolError
        If they are not those of a BVH file with motion; the sentence has the number of the line.
    """
    data = path.read_bytes()
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        _fail(path, 1 + data.count(b"\n", 0, error.start), "this is not UTF-8; save the file as UTF-8 text.")
    tree = _Tree(path)
    number = tree.follow(lines)
    tree.text.frame_time, tree.text.table = _read_motion(path, lines, number, sum(map(len, tree.text.channels)))
    return tree.text


def _fail(path: Path, number: int, sentence: str) -> NoReturn:
    raise ToolError(f"{path}, line {number}: {sentence}")


class _Tree:
    """Follows the hierarchy, from HIERARCHY to MOTION."""

    def __init__(self, path: Path) -> None:
        self.text = BvhText()
        self._path, self._number = path, 0
        self._depth = 0
        self._block = ""
        self._expected: tuple[str, ...] = ("HIERARCHY",)

    def follow(self, lines: Sequence[str]) -> int:
        """Take the lines of the hierarchy, and return the number of that with MOTION."""
        for self._number, line in enumerate(lines, 1):
            for statement in re.split(r"([{}])", line):
                words = statement.split()
                if words:
                    self._take(words)
            if not self._expected:
                return self._number
        self._fail(f"the file ends where {self._wanted()} is expected; it is cut short.")

    def _fail(self, sentence: str) -> NoReturn:
        _fail(self._path, max(1, self._number), sentence)

    def _wanted(self) -> str:
        return " or ".join(_SPELLED.get(keyword, keyword) for keyword in self._expected)

    def _take(self, words: list[str]) -> None:
        keyword = words[0].upper()
        if keyword not in self._expected:
            if keyword == "ROOT" and self._depth == 0 and self.text.names:
                self._fail("a second skeleton begins; split the file into one for each ROOT.")
            self._fail(f"expected {self._wanted()}, but found {_short(words[0])}; repair the file.")
        match keyword:
            case "HIERARCHY":
                self._expected = ("ROOT",)
            case "ROOT" | "JOINT" | "END":
                self._open(keyword, words)
            case "{":
                self._depth += 1
                self._expected = ("OFFSET",) if self._block == "END" else ("OFFSET", "CHANNELS")
            case "OFFSET" | "CHANNELS":
                self._describe(keyword, words)
            case "}":
                self._depth -= 1
                self._expected = _IN_BLOCK if self._depth else ("MOTION",)
            case "MOTION":
                self._expected = ()
                return
        if keyword not in ("OFFSET", "CHANNELS"):
            self.text.plain.append(_plain_statement(keyword, len(self.text.names)))

    def _open(self, keyword: str, words: list[str]) -> None:
        if keyword != "END":
            if len(words) == 1:
                self._fail(f"{keyword} has no name; give the joint one.")
            self.text.names.append(" ".join(words[1:]))
        self._block, self._expected = keyword, ("{",)

    def _describe(self, keyword: str, words: list[str]) -> None:
        if keyword == "OFFSET":
            self._check_offset(words[1:])
            self.text.plain.append(" ".join(["OFFSET", *words[1:]]))
        else:
            self.text.channels.append(self._channels(words[1:]))
            positions = CHANNELS[:3] if self._block == "ROOT" else ()
            names = (*positions, *CHANNELS[3:])
            self.text.plain.append(" ".join(["CHANNELS", str(len(names)), *names]))
        rest = tuple(other for other in self._expected if other != keyword)
        self._expected = rest or (("}",) if self._block == "END" else _IN_BLOCK)

    def _check_offset(self, words: list[str]) -> None:
        if len(words) != 3 or not all(_is_number(word) for word in words):
            self._fail(f"OFFSET must be three numbers, not {_short(' '.join(words)) or 'none'}; repair the file.")

    def _channels(self, words: list[str]) -> tuple[str, ...]:
        names = tuple(word.capitalize() for word in words[1:])
        for word, name in zip(words[1:], names, strict=True):
            if name not in CHANNELS:
                self._fail(f"{_short(word)} is no channel; there are {', '.join(CHANNELS)}.")
            if names.count(name) > 1:
                self._fail(f"{word} is there twice; a joint has each channel once.")
        if words[:1] != [str(len(names))]:
            self._fail(
                f"CHANNELS says {_short(words[0]) if words else 'nothing'}, but {len(names)} follow; repair the file."
            )
        return names


def _plain_statement(keyword: str, n_joints: int) -> str:
    return {"ROOT": f"ROOT {n_joints}", "JOINT": f"JOINT {n_joints}", "END": "End Site"}.get(keyword, keyword)


def _short(text: str) -> str:
    """Cut what a sentence quotes: a file that is not BVH may have one word of any length."""
    return text if len(text) <= 40 else f"{text[:40]}..."


def _is_number(word: str) -> bool:
    return bool(_NUMBER.fullmatch(word)) and abs(float(word)) <= LARGEST


def _read_motion(path: Path, lines: Sequence[str], number: int, n_channels: int) -> tuple[Decimal, np.ndarray]:
    """Frame time and numbers of what follows the line with MOTION, which has the given number."""
    full = [k for k in range(number, len(lines)) if lines[k].strip()]
    values = []
    for place, name in enumerate(("Frames", "Frame Time")):
        if place >= len(full):
            _fail(path, len(lines), f"the file ends where {name} is expected; it is cut short.")
        line = lines[full[place]].strip()
        found = re.fullmatch(name.replace(" ", r"\s+") + r"\s*:\s*(\S+)", line, re.IGNORECASE)
        if not found:
            _fail(path, full[place] + 1, f"expected {name} and a number, but found {_short(line)!r}.")
        values.append(found.group(1))
    n_frames = _frame_count(path, full[0] + 1, values[0])
    frame_time = _frame_time(path, full[1] + 1, values[1])
    rows, told = full[2:], f"{n_frames} frames of line {full[0] + 1}"
    if len(rows) > n_frames:
        _fail(path, rows[n_frames] + 1, f"this comes after the {told}; correct one of them.")
    table = _read_table(path, lines, rows, n_channels)
    if len(rows) < n_frames:
        _fail(path, len(lines), f"the file ends after {len(rows)} of the {told}; correct one of them.")
    return frame_time, table


def _frame_count(path: Path, number: int, word: str) -> int:
    if not re.fullmatch("0*[1-9][0-9]{0,17}", word):
        _fail(path, number, f"Frames must be a whole number of at least 1, not {_short(word)}; correct it.")
    return int(word)


def _frame_time(path: Path, number: int, word: str) -> Decimal:
    try:
        seconds = Decimal(word)
    except InvalidOperation:
        seconds = Decimal(0)
    if not (seconds.is_finite() and 1e-6 <= seconds <= 1e6):
        _fail(path, number, f"Frame Time must be a positive number of seconds, not {_short(word)}; repair the file.")
    return seconds


def _read_table(path: Path, lines: Sequence[str], rows: Sequence[int], n_channels: int) -> np.ndarray:
    if not rows or not n_channels:
        return np.zeros((len(rows), n_channels))
    try:
        table = np.loadtxt([lines[k] for k in rows], ndmin=2, comments=None)
        if table.shape[1] == n_channels and (np.abs(table) <= LARGEST).all():
            return table
    except ValueError:
        pass
    number, problem = next((k + 1, words) for k in rows if (words := _row_problem(lines[k].split(), n_channels)))
    _fail(path, number, f"{problem}; repair the file.")


def _row_problem(words: Sequence[str], n_channels: int) -> str:
    if len(words) != n_channels:
        return f"{len(words)} numbers for {n_channels} channels"
    return next((f"{_short(word)} is no finite number" for word in words if not _is_number(word)), "")
