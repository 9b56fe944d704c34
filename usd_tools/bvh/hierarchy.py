"""The first part of a BVH file: joints in trees, their offsets and channels, and end sites."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NoReturn

from usd_tools.bvh.lines import LineError, check_decimal_points, is_number, quoted

CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
"""The channels that a joint may have, as they are spelled here; files may spell them in any case."""

Vector = tuple[float, ...]

_IN_JOINT = ("JOINT", "END", "}")
_SPELLED = {"END": "End Site"}


@dataclass
class Hierarchy:
    """Joints, parents before children.

    Parameters
    ----------
    names : list of str, shape=[B]
        As in the file.
    parents : list of int, shape=[B]
        Index of each joint's parent, -1 for a root.
    offsets : list of tuple of float, shape=[B, 3]
        From the parent.
    channels : list of tuple of str, shape=[B]
        Names of `CHANNELS`, in the order of the file; empty for a joint that has none.
    end_sites : list of list of tuple of float, shape=[B]
        Offsets of the end sites of each joint.
    """

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[Vector] = field(default_factory=list)
    channels: list[tuple[str, ...]] = field(default_factory=list)
    end_sites: list[list[Vector]] = field(default_factory=list)

    @property
    def n_channels(self) -> int:
        """Count the channels of all joints."""
        return sum(map(len, self.channels))


def read_hierarchy(lines: Sequence[str]) -> tuple[Hierarchy, int]:
    """Read the lines from HIERARCHY to MOTION.

    Parameters
    ----------
    lines : sequence of str

    Returns
    -------
    hierarchy : Hierarchy
    n_lines : int
        How many lines were read; the last one has MOTION.

    Raises
    ------
    LineError
        If they are broken.
    """
    parser = _Parser()
    for parser.number, line in enumerate(lines, 1):
        for statement in re.split(r"([{}])", line):
            words = statement.split()
            if words:
                parser.take(words)
        if not parser.expected:
            return parser.hierarchy, parser.number
    parser.fail(f"the file ends where {parser.wanted()} is expected; it is cut short.")


class _Parser:
    """Takes one statement after the other, and knows which keywords may come next."""

    def __init__(self) -> None:
        self.hierarchy = Hierarchy()
        self.number = 0
        self.expected: tuple[str, ...] = ("HIERARCHY",)
        self._open: list[int] = []  # the joints whose blocks are open, the innermost last
        self._in_end_site = False

    def fail(self, sentence: str) -> NoReturn:
        raise LineError(max(1, self.number), sentence)

    def wanted(self) -> str:
        return " or ".join(_SPELLED.get(keyword, keyword) for keyword in self.expected)

    def take(self, words: list[str]) -> None:
        keyword = words[0].upper()
        if keyword not in self.expected:
            self.fail(f"expected {self.wanted()}, but found {quoted(words[0])}; repair the file.")
        match keyword:
            case "HIERARCHY":
                self.expected = ("ROOT",)
            case "ROOT" | "JOINT":
                self._begin_joint(keyword, words[1:])
            case "END":
                self._in_end_site, self.expected = True, ("{",)
            case "{":
                self.expected = ("OFFSET",) if self._in_end_site else ("OFFSET", "CHANNELS")
            case "OFFSET":
                self._take_offset(words[1:])
            case "CHANNELS":
                self.hierarchy.channels[self._open[-1]] = self._channels(words[1:])
                self.expected = ("OFFSET",) if "OFFSET" in self.expected else _IN_JOINT
            case "}":
                self._end_block()
            case "MOTION":
                self.expected = ()

    def _begin_joint(self, keyword: str, name: list[str]) -> None:
        if not name:
            self.fail(f"{keyword} has no name; give the joint one.")
        tree = self.hierarchy
        tree.names.append(" ".join(name))
        tree.parents.append(self._open[-1] if self._open else -1)
        tree.offsets.append((0.0, 0.0, 0.0))
        tree.channels.append(())
        tree.end_sites.append([])
        self._open.append(len(tree.names) - 1)
        self.expected = ("{",)

    def _end_block(self) -> None:
        if self._in_end_site:
            self._in_end_site = False
        else:
            self._open.pop()
        self.expected = _IN_JOINT if self._open else ("ROOT", "MOTION")

    def _take_offset(self, words: list[str]) -> None:
        check_decimal_points(self.number, words)
        if len(words) != 3 or not all(map(is_number, words)):
            self.fail(f"OFFSET must be three numbers, not {quoted(' '.join(words)) or 'none'}; repair the file.")
        offset = tuple(map(float, words))
        if self._in_end_site:
            self.hierarchy.end_sites[self._open[-1]].append(offset)
            self.expected = ("}",)
        else:
            self.hierarchy.offsets[self._open[-1]] = offset
            self.expected = ("CHANNELS", *_IN_JOINT) if "CHANNELS" in self.expected else _IN_JOINT

    def _channels(self, words: list[str]) -> tuple[str, ...]:
        names = tuple(word.capitalize() for word in words[1:])
        for word, name in zip(words[1:], names, strict=True):
            if name not in CHANNELS:
                self.fail(f"{quoted(word)} is no channel; there are {', '.join(CHANNELS)}.")
            if names.count(name) > 1:
                self.fail(f"{word} is there twice; a joint has each channel once.")
        if words[:1] != [str(len(names))]:
            said = quoted(words[0]) if words else "nothing"
            self.fail(f"CHANNELS says {said}, but {len(names)} follow; repair the file.")
        return names
