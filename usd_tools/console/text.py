"""Text for a terminal: names from files are harmless, and a mistyped word gets a suggestion."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence

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


def say(text: object) -> None:
    """Print one line on stdout, as far as it is printable."""
    print(printable(str(text)))


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Suggest the word nearest to a mistyped one, as the end of a sentence; "" where none is near."""
    from difflib import get_close_matches

    by_lower = {each.lower(): each for each in words}
    near = get_close_matches(word.lower(), by_lower, n=1)
    return f"; did you mean {by_lower[near[0]]}?" if near else ""


def listed(words: Sequence[str]) -> str:
    """Join alternatives: "a", "a or b", "a, b or c"."""
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
