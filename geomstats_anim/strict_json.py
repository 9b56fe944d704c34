"""JSON for and from strangers: no larger, no deeper and no stranger than every program can read."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

LARGEST = 1 << 26
"""Characters of a document."""

DEEPEST = 32
"""Lists and objects within each other."""


def read_text(path: Path) -> str:
    """Read a file that somebody else may have written, as UTF-8 text.

    Parameters
    ----------
    path : Path

    Returns
    -------
    text : str

    Raises
    ------
    ValueError
        If it is too large, or not UTF-8.
    OSError
        If it cannot be read.
    """
    with path.open("rb") as file:  # which may have no end, as a device
        data = file.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise ValueError(f"This file has more than {LARGEST} bytes.")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise ValueError("This file is not UTF-8 text.") from None


def parse_json(text: str) -> Any:
    """Parse JSON that somebody else may have written.

    Parameters
    ----------
    text : str

    Returns
    -------
    document : object
        Of plain values, finite ones only.

    Raises
    ------
    ValueError
        If the text is not JSON, is too large or nested too deeply, or has a number that is not finite.
    """
    if len(text) > LARGEST:
        raise ValueError(f"This JSON has {len(text)} characters; at most {LARGEST} are read.")
    try:
        document = json.loads(text, parse_constant=_refuse, parse_float=_finite)
    except json.JSONDecodeError as error:
        # whichever is met first depends on the version of Python
        raise ValueError(_TOO_DEEP if _is_deep(text) else f"This is not JSON: {error}.") from error
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    _check_depth(document)
    return document


_TOO_DEEP = f"This JSON is nested more than {DEEPEST} levels deep."
_PLAIN = str | int | float | None


def dump_json(document: Any, indent: int | None = None) -> str:
    """Write JSON that `parse_json`, and programs with integers of 64 bits, read back without loss.

    Parameters
    ----------
    document : object
        Of plain values.
    indent : int
        As in `json.dumps`.
        Optional, default: one line.

    Returns
    -------
    text : str

    Raises
    ------
    ValueError
        If a value cannot be stored: not plain, not finite, an integer of more than 64 bits, or nested too deeply.
    """
    try:
        text = json.dumps(document, indent=indent, allow_nan=False)
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    except TypeError as error:
        raise ValueError(f"{error}.") from error
    json.loads(text, parse_int=_of_64_bits)
    _check_depth(document)
    return text


def _of_64_bits(digits: str) -> int:
    number = int(digits) if len(digits) <= 20 else 1 << 64
    if not -(1 << 63) <= number < 1 << 63:
        raise ValueError(f"{digits[:24]} has more than 64 bits")
    return number


def _check_depth(document: Any) -> None:
    level = [document]
    for _ in range(DEEPEST):
        inner = (value.values() if isinstance(value, Mapping) else value for value in level)
        level = [value for values in inner if not isinstance(values, _PLAIN) for value in values]
    if not all(isinstance(value, _PLAIN) for value in level):
        raise ValueError(_TOO_DEEP)


def _is_deep(text: str) -> bool:
    depth = 0
    for bracket in re.findall(r"[][{}]", re.sub(r'"(?:[^"\\]|\\.)*"', "", text)):
        depth += 1 if bracket in "[{" else -1
        if depth > DEEPEST:
            return True
    return False


def _refuse(word: str) -> Any:
    raise ValueError(f"This JSON has the value {word}, which is not a finite number.")


def _finite(text: str) -> float:
    number = float(text)
    return number if abs(number) != float("inf") else _refuse(text)
