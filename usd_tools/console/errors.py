"""Errors of commands: one sentence on stderr and an exit code, never a traceback for bad input."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable
from typing import NoReturn

from usd_tools.console.text import print_to

INTERRUPTED = 130
"""Exit code after Ctrl-C: 128 and the number of SIGINT."""


class ToolError(Exception):
    """Something is wrong with the input; the message is one sentence that names it and says what to do."""


class UsageError(ToolError):
    """Options are wrong in themselves, whatever the input; the message is a sentence without its dot."""


class Messages:
    """Warnings of one run, each kept once.

    Parameters
    ----------
    listener : callable
        Called with each new warning.
        Optional, default: nobody listens.

    Attributes
    ----------
    warnings : list of str
    """

    def __init__(self, listener: Callable[[str], None] | None = None) -> None:
        self.warnings: list[str] = []
        self._listener = listener

    def warn(self, sentence: str) -> None:
        """Keep a warning that is new, and pass it on."""
        if sentence not in self.warnings:
            self.warnings.append(sentence)
            if self._listener is not None:
                self._listener(sentence)


def print_warning(sentence: str) -> None:
    """Print a warning on stderr: the listener of the command line."""
    print_to(sys.stderr, f"warning: {sentence}")


def run(command: Callable[[], int], usage_error: Callable[[str], NoReturn] | None = None) -> int:
    """Run a command and turn its errors into one sentence on stderr.

    Parameters
    ----------
    command : callable
        Returns the exit code.
    usage_error : callable
        Ends the program after an error of usage: `ArgumentParser.error`.
        Optional, default: it is an error as others.

    Returns
    -------
    exit_code : int
        1 after an error, 130 after an interrupt, as shells have it.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a name may need letters that the terminal does not have
    try:
        code = command()
        sys.stdout.flush()
        return code
    except ToolError as error:
        if usage_error is not None and isinstance(error, UsageError):
            usage_error(str(error))
        sentence = str(error)
    except KeyboardInterrupt:
        print("error: interrupted; unfinished output was discarded.", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # The reader of our output, such as `head`, has seen enough; Python must not try to write the rest.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        sentence = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    print_to(sys.stderr, f"error: {sentence}")
    return 1
