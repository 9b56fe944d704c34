"""Numbers from the command line, each checked where it is parsed."""

from __future__ import annotations

import argparse
import math


def positive_number(text: str) -> float:
    """Parse a positive, finite number."""
    number = _number(text)
    if not (math.isfinite(number) and number > 0.0):
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text!r}")
    return number


def share(text: str) -> float:
    """Parse a number between 0 and 1, both excluded."""
    number = _number(text)
    if not 0.0 < number < 1.0:
        raise argparse.ArgumentTypeError(f"must be a number above 0 and below 1, not {text!r}")
    return number


def whole_number(text: str) -> int:
    """Parse a whole number of at least 1."""
    return _whole_number(text, 1)


def seed(text: str) -> int:
    """Parse a whole number of at least 0."""
    return _whole_number(text, 0)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _whole_number(text: str, least: int) -> int:
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f"must be a whole number of at least {least}, not {text!r}")
    return number


def add_workers(parse: argparse._ActionsContainer) -> None:
    """Add `--address` and `--cpus` to a parser, or to a group of one."""
    parse.add_argument("--address", metavar="HOST:PORT", help="of a Ray cluster; default: RAY_ADDRESS, else none")
    parse.add_argument("--cpus", metavar="N", type=whole_number, help="workers; more than one starts Ray; default: 1")
