"""Options that several commands share, and values checked where they are parsed; imports nothing that is slow."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import index
from pathlib import Path

from geomstats_anim.strict_json import read_text


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
    """Parse a whole number from 0 on, of at most 64 bits, for it is stored with what it made."""
    number = _whole_number(text, 0)
    if number >= 1 << 63:
        raise argparse.ArgumentTypeError(f"must be below 2^63, not {text!r}")
    return number


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _whole_number(text: str | int, least: int) -> int:
    try:
        number = int(text) if isinstance(text, str) else index(text)
    except (ValueError, TypeError):
        number = least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f"must be a whole number of at least {least}, not {text!r}")
    return number


def add_workers(parse: argparse._ActionsContainer) -> None:
    """Add `--address` and `--cpus` to a parser, or to a group of one."""
    parse.add_argument(
        "--address", metavar="HOST:PORT", help="Ray cluster to use; default: the variable RAY_ADDRESS, else none"
    )
    parse.add_argument(
        "--cpus",
        metavar="N",
        type=whole_number,
        help="number of workers; more than one starts Ray; default: 1",
    )


def add_inputs(parse: argparse._ActionsContainer, what: str = "USD file") -> None:
    """Add `IN`, a file, several, or folders."""
    parse.add_argument(
        "input", metavar="IN", nargs="+", type=Path, help=f"{what}; or several, or folders: then OUT is a folder"
    )


def add_several(parse: argparse.ArgumentParser) -> None:
    """Add the options for several files."""
    group = parse.add_argument_group(
        "several files",
        "With more than one IN, or a folder, OUT is a folder with the same tree inside. A file that fails is named and "
        "the others go on; the exit code is 1 then. --report writes one summary of all.",
    )
    group.add_argument("--jobs", metavar="N", type=whole_number, help="processes on this machine; default: 1")
    group.add_argument(
        "--skip-existing", action="store_true", help="leave out files whose output is there, as after an interrupt"
    )
    add_workers(group)


MAX_UNPACKED = 4.0
"""Gigabytes that a package from a stranger may unpack to."""

SOURCE = "source"
"""The word for the samples that an animation had before it was downsampled."""


@dataclass(frozen=True)
class TimeCodes:
    """Time codes asked for on the command line.

    Parameters
    ----------
    codes : tuple of float or None
        None for those of `SOURCE`, which the animation itself stores.
    text : str
        How they were given, without folders of this machine.
    """

    codes: tuple[float, ...] | None
    text: str

    def __str__(self) -> str:
        """Write them as they were given."""
        return self.text


def time_codes(text: str) -> TimeCodes:
    """Parse numbers separated by commas, the name of a text file of numbers, or `SOURCE`."""
    if text == SOURCE:
        return TimeCodes(None, text)
    try:
        return TimeCodes(_numbers(text), text)
    except ValueError:
        pass
    try:
        return TimeCodes(_numbers(read_text(Path(text))), Path(text).name)
    except (OSError, ValueError):
        raise argparse.ArgumentTypeError(
            f"must be comma-separated numbers or a file of numbers, not {text!r}"
        ) from None


def as_time_codes(value: str | TimeCodes | Sequence[float]) -> TimeCodes:
    """Take time codes as a program gives them: numbers, or what `time_codes` parses."""
    if isinstance(value, TimeCodes):
        return value
    if not isinstance(value, str):
        value = ",".join(repr(float(code)).removesuffix(".0") for code in value)
    return time_codes(value)


def _numbers(text: str) -> tuple[float, ...]:
    numbers = tuple(float(word) for word in text.replace(",", " ").split())
    if not numbers or not all(map(math.isfinite, numbers)):
        raise ValueError(text)
    return numbers


def add_prim(parse: argparse._ActionsContainer) -> None:
    """Add `--prim`, which chooses animations."""
    parse.add_argument(
        "--prim",
        metavar="PATH",
        action="append",
        default=[],
        help="only this SkelAnimation or Skeleton, or those below this prim; repeatable; default: all",
    )


def add_output(parse: argparse._ActionsContainer) -> None:
    """Add the options that say how a USD file is written."""
    parse.add_argument(
        "-f",
        "--flatten",
        action="store_true",
        help="write one file that does not need the source; textures stay where they are",
    )
    add_format(parse)
    parse.add_argument("--in-place", action="store_true", help="change IN itself")
    parse.add_argument(
        "--max-unpacked",
        metavar="GB",
        type=positive_number,
        default=MAX_UNPACKED,
        help="refuse packages that unpack to more than this; default: %(default)g",
    )


def add_format(parse: argparse._ActionsContainer) -> None:
    """Add the option for the format of a name that does not tell it."""
    parse.add_argument(
        "--usdFormat",
        choices=("usda", "usdc"),
        help="format of an OUT that ends in .usd; default: usdc; of several files: how their names end",
    )
