"""The lines of a BVH file, and the words on them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

LARGEST = float(np.finfo(np.float32).max)
"""Larger numbers do not fit into a USD file."""

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_WITH_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?")
_LONGEST_QUOTE = 40


class LineError(Exception):
    """A line that is not as it must be.

    Parameters
    ----------
    number : int
        Of the line, from 1 on.
    sentence : str
        What is wrong, and what to do.
    """

    def __init__(self, number: int, sentence: str) -> None:
        super().__init__(f"line {number}: {sentence}")


def read_lines(path: Path) -> list[str]:
    """Read the lines of a text file, whatever ends them.

    Parameters
    ----------
    path : Path

    Returns
    -------
    lines : list of str

    Raises
    ------
    LineError
        If it is not UTF-8.
    """
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        number = 1 + data.count(b"\n", 0, error.start)
        raise LineError(number, "this is not UTF-8; save the file as UTF-8 text.") from None


def is_number(word: str) -> bool:
    """Return whether a word is a finite decimal number that fits into a USD file."""
    return bool(_NUMBER.fullmatch(word)) and abs(float(word)) <= LARGEST


def check_decimal_points(number: int, words: list[str]) -> None:
    """Refuse numbers that are written with a comma, as programs in some languages export them.

    Raises
    ------
    LineError
        If a word is such a number.
    """
    word = next(filter(_WITH_COMMA.fullmatch, words), None)
    if word is not None:
        raise LineError(number, f"{quoted(word)} has a decimal comma; replace the commas of numbers with points.")


def quoted(text: str) -> str:
    """Return what a sentence quotes of a text: a file that is not BVH may have one word of any length."""
    return text if len(text) <= _LONGEST_QUOTE else f"{text[:_LONGEST_QUOTE]}..."
