"""How a command ends: one sentence on stderr and an exit code, never a traceback for bad input."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pxr import Tf, UsdUtils

TEMPORARY = "geomstats_anim-"
"""How the names of temporary folders begin."""

LONGEST = 400
"""Characters of what OpenUSD says: of a broken file it may list every part."""

_PACKED = re.compile(r"Failed to resolve reference @\d+/")
"""How OpenUSD, when it packs, begins to speak of files that it has packed, by their new names; those are there."""


class ToolError(Exception):
    """Something is wrong with the input; the message is one sentence that names it and says what to do."""


class Messages:
    """Warnings of one run: each is printed once on stderr, and kept for the report."""

    def __init__(self) -> None:
        self.warnings: list[str] = []

    def warn(self, sentence: str) -> None:
        """Print a warning that has not been printed before."""
        if sentence not in self.warnings:
            self.warnings.append(sentence)
            print(f"warning: {sentence}", file=sys.stderr)


def commentary(error: Tf.ErrorException) -> str:
    """Tell in one line what OpenUSD says in several: its first error, without places in its source code."""
    return _one_line(error.args[0]) if error.args else "OpenUSD gives no reason"


def _one_line(diagnostic: Any) -> str:
    try:
        text = diagnostic.commentary
    except UnicodeDecodeError as error:  # it quotes a file that is not UTF-8
        text = error.object.decode(errors="replace")
    text = text[: 100 * LONGEST]  # it may be a gigabyte long
    # Addresses in memory and temporary folders differ from run to run, and say nothing to a user.
    meaningless = (
        r"\(instantiating stage on stage .*?>\)|<0x[0-9a-f]+>|pxrInternal_\w+?__(pxrReserved___)?(::)?"
        rf"|/[^@\s]*/{TEMPORARY}\w+/|/\.[^/@\s]+\.\w{{8}}(?=/)"
    )
    line = " ".join(re.sub(meaningless, "", text).split())
    return line if len(line) <= LONGEST else f"{line[:LONGEST]}..."


@contextmanager
def usd_warnings(messages: Messages) -> Iterator[None]:
    """Turn what OpenUSD would print on stderr into warnings of our own."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        for line in map(_one_line, delegate.TakeUncoalescedDiagnostics()):
            if not _PACKED.match(line):
                messages.warn(line)


@contextmanager
def usd_unheard() -> Iterator[None]:
    """Keep OpenUSD from printing what is told in another way, or has been already."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        delegate.TakeUncoalescedDiagnostics()


def run(command: Callable[[], int]) -> int:
    """Run a command and turn its errors into one sentence on stderr.

    Parameters
    ----------
    command : callable
        Returns the exit code.

    Returns
    -------
    exit_code : int
        1 after an error.
    """
    try:
        code = command()
        sys.stdout.flush()
        return code
    except ToolError as error:
        sentence = str(error)
    except KeyboardInterrupt:
        sentence = "interrupted; what was not written yet is not written."
    except BrokenPipeError:
        # The reader of our output, such as `head`, has seen enough; Python must not try to write the rest.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Tf.ErrorException as error:
        sentence = commentary(error)
    except OSError as error:
        sentence = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    print(f"error: {sentence}", file=sys.stderr)
    return 1
