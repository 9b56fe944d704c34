"""Options of a verb as a frozen dataclass, checked once, whether a command line or a program makes it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Self

from usd_tools.console.arguments import MAX_UNPACKED, positive_number
from usd_tools.console.errors import UsageError
from usd_tools.console.parser import listed
from usd_tools.console.text import did_you_mean

Rule = Callable[[Any], Any]
"""Returns a value as it is kept; raises `argparse.ArgumentTypeError` if it is not allowed."""


def option(default: Any = None, rule: Rule | None = None, *, recorded: bool = True, word: str | None = None) -> Any:
    """Declare a field of options.

    Parameters
    ----------
    default : object
    rule : callable
        Applied to each value but None.
        Optional, default: any value is allowed.
    recorded : bool
        Whether the value belongs to what made a file; see `Options.settings`.
    word : str
        Name on the command line, without dashes.
        Optional, default: the field's name.
    """
    return field(default=default, metadata={"rule": rule, "recorded": recorded, "word": word})


def one_of(words: Sequence[str]) -> Rule:
    """Make the rule for a value that is one of some words."""

    def rule(value: object) -> object:
        if value not in words:
            near = did_you_mean(str(value), words)
            raise argparse.ArgumentTypeError(f"must be {listed(words)}, not {value!r}{near}")
        return value

    return rule


def several(rule: Rule) -> Rule:
    """Make the rule for a sequence of values, kept as a tuple; a word alone is a sequence of one."""
    return lambda values: tuple(rule(value) for value in ([values] if isinstance(values, str | Path) else values))


@dataclass(frozen=True, kw_only=True)
class Options:
    """Base of the options of every verb.

    Raises
    ------
    UsageError
        If a value is not allowed, or does not go with another.
    """

    def __post_init__(self) -> None:
        """Apply the rules."""
        for each in fields(self):
            rule, value = each.metadata["rule"], getattr(self, each.name)
            if rule is None or value is None:
                continue
            try:
                object.__setattr__(self, each.name, rule(value))
            except argparse.ArgumentTypeError as error:
                raise UsageError(f"--{_word(each)} {error}") from None
        self.check()

    def check(self) -> None:
        """Refuse values that do not go together.

        Raises
        ------
        UsageError
        """

    @classmethod
    def from_args(cls, args: argparse.Namespace) -> Self:
        """Take the options from a parsed command line."""
        given = vars(args)
        words = {each.name: _word(each).replace("-", "_") for each in fields(cls)}
        return cls(**{name: given[word] for name, word in words.items() if word in given})

    def settings(self) -> dict[str, Any]:
        """Return what was asked for, as plain values without paths of this machine."""
        values = {each.name: getattr(self, each.name) for each in fields(self) if each.metadata["recorded"]}
        return {name: _plain(value) for name, value in values.items() if value not in (None, ()) and value is not False}


def _word(each: Any) -> str:
    return each.metadata["word"] or each.name.replace("_", "-")


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return " ".join(map(str, value))
    if isinstance(value, Path):
        return value.name
    return value if isinstance(value, str | int | float) else str(value)


@dataclass(frozen=True, kw_only=True)
class PrimOptions(Options):
    """Choice of the animations of a file or stage to work on.

    Parameters
    ----------
    prim : tuple of str
        Paths of SkelAnimations, Skeletons or prims above them.
        Optional, default: all animations.
    """

    prim: tuple[str, ...] = option((), several(str))


@dataclass(frozen=True, kw_only=True)
class OutputOptions(PrimOptions):
    """Options for writing a result to a file; an open stage takes none of these.

    Parameters
    ----------
    flatten : bool
        Whether to write one file that does not need the source.
        Optional, default: False.
    in_place : bool
        Whether to change the source itself.
        Optional, default: False.
    usd_format : str
        "usda" or "usdc", for a name that ends in .usd.
        Optional, default: "usdc".
    max_unpacked : float
        Gigabytes that a usdz package may unpack to.
        Optional, default: 4.
    report : Path
        JSON file to write the result to as well.
        Optional, default: none.
    """

    flatten: bool = option(False, bool, recorded=False)
    in_place: bool = option(False, bool, recorded=False)
    usd_format: str | None = option(None, one_of(("usda", "usdc")), recorded=False, word="usdFormat")
    max_unpacked: float = option(MAX_UNPACKED, positive_number, recorded=False)
    report: Path | None = option(None, Path, recorded=False)
