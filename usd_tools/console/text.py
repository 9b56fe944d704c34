"""Text for a terminal: harmless whatever names files have, a suggestion for a mistyped word, short names of joints."""

from __future__ import annotations

import shutil
import sys
import textwrap
import unicodedata
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TextIO

_RAW = {"Cc", "Cf", "Cs", "Zl", "Zp"}
"""Unicode categories that a terminal obeys or cannot show: controls, directions, halves of pairs, ends of lines."""

_JOINERS = "\u200c\u200d"
"""Parts of words in several scripts; they change nothing but the letters beside them."""


def printable(text: str) -> str:
    r"""Escape what a terminal would obey, so that names from files are only ever shown.

    Parameters
    ----------
    text : str

    Returns
    -------
    text : str
        The same where every character can be shown; otherwise with escapes such as `\x1b`, `\n` and `\u202e`.
    """
    if text.isprintable():
        return text
    return "".join(_escaped(c) if unicodedata.category(c) in _RAW and c not in _JOINERS else c for c in text)


def _escaped(character: str) -> str:
    return character.encode("unicode_escape", "surrogatepass").decode("ascii")


def say(sentence: str) -> None:
    """Print a sentence on stdout; a terminal breaks it between words."""
    print_to(sys.stdout, sentence)


def say_command(command: str) -> None:
    """Print a command on a line of its own, never broken, so that it can be pasted."""
    print(f"  {printable(command)}")


def print_to(stream: TextIO, sentence: str) -> None:
    """Print a sentence: one line, but on a terminal no wider than that, with its indent kept."""
    line = printable(sentence)
    if stream.isatty():
        indent = " " * (len(line) - len(line.lstrip()))
        width = shutil.get_terminal_size().columns
        line = textwrap.fill(
            line.lstrip(),
            width,
            initial_indent=indent,
            subsequent_indent=indent,
            break_long_words=False,
            break_on_hyphens=False,
        )
    print(line, file=stream)


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Suggest the word nearest to a mistyped one, as the end of a sentence; "" where none is near."""
    from difflib import get_close_matches

    by_lower = {each.lower(): each for each in words}
    near = get_close_matches(word.lower(), by_lower, n=1)
    return f"; did you mean {by_lower[near[0]]}?" if near else ""


def listed(words: Sequence[str]) -> str:
    """Join alternatives: "a", "a or b", "a, b or c"."""
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def counted(number: float, thing: str) -> str:
    """Return a number and its noun, whose plural ends in s."""
    return f"{number if isinstance(number, int) else format(number, 'g')} {thing}{'' if number == 1 else 's'}"


def short_names(joints: Sequence[str]) -> dict[str, str]:
    """Take as much from the end of each joint's path as tells it from the others.

    Parameters
    ----------
    joints : sequence of str
        Full paths.

    Returns
    -------
    names : dict
        By path.
    """
    names = {joint: joint for joint in joints}
    left, n_parts = list(names), 0
    while left:  # those whose last parts are also another's
        n_parts += 1
        ends = {joint: "/".join(joint.rsplit("/", n_parts)[-n_parts:]) for joint in left}
        counts = Counter(ends.values())
        names |= {joint: end for joint, end in ends.items() if counts[end] == 1}
        left = [joint for joint, end in ends.items() if counts[end] > 1 and end != joint]
    return names
