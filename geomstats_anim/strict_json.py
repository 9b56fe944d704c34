"""JSON from strangers: no larger, no deeper and no stranger than this package writes it."""

from __future__ import annotations

import json
from typing import Any

LARGEST = 1 << 26
"""Characters of a document."""

DEEPEST = 32
"""Lists and objects within each other."""


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
        raise ValueError(f"This is not JSON: {error}.") from error
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    _check_depth(document)
    return document


_TOO_DEEP = f"This JSON is nested more than {DEEPEST} levels deep."
_PLAIN = str | int | float | None


def _check_depth(document: Any) -> None:
    level = [document]
    for _ in range(DEEPEST):
        inner = (value.values() if isinstance(value, dict) else value for value in level)
        level = [value for values in inner if not isinstance(values, _PLAIN) for value in values]
    if not all(isinstance(value, _PLAIN) for value in level):
        raise ValueError(_TOO_DEEP)


def _refuse(word: str) -> Any:
    raise ValueError(f"This JSON has the value {word}, which is not a finite number.")


def _finite(text: str) -> float:
    number = float(text)
    return number if abs(number) != float("inf") else _refuse(text)
