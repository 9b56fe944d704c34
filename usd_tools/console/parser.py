"""The parser of every command: a usage error is one sentence, with a suggestion, and the usage follows it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from usd_tools.console.text import did_you_mean, listed, printable


class ArgumentParser(argparse.ArgumentParser):
    """A parser that says what is wrong before it shows the usage, and suggests the nearest word that it knows."""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """Parse arguments; an unknown option is named before anything that it leaves missing."""
        words = sys.argv[1:] if args is None else list(args)
        if self._subparsers is not None:  # whose parsers know their options
            return super().parse_known_args(words, namespace)
        for word in words[: words.index("--")] if "--" in words else words:
            self._check_option(word)
        return super().parse_known_args(words, namespace)

    def _check_option(self, word: str) -> None:
        option = word.partition("=")[0]
        known = [each for each in self._option_string_actions if each.startswith("--")]
        # argparse takes the beginning of an option for all of it, and words with spaces for values
        if option.startswith("--") and " " not in option and not any(each.startswith(option) for each in known):
            self.error(f"unknown option {option}{did_you_mean(option, known)}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = None if action.choices is None else list(map(str, action.choices))
        if choices is not None and value not in action.choices:  # type: ignore[operator]
            raise argparse.ArgumentError(
                action, f"must be {listed(choices)}, not {value!r}{did_you_mean(str(value), choices)}"
            )

    def error(self, message: str) -> NoReturn:
        """End with exit code 2: the sentence, then the usage."""
        sentence = printable(message.removeprefix("argument "))
        self.exit(2, f"error: {sentence}{'' if sentence.endswith(('.', '?')) else '.'}\n{self.format_usage()}")
