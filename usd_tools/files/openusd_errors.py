"""Turn OpenUSD's errors and warnings into sentences of one line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pxr import Tf, UsdUtils

from usd_tools.console.errors import Messages, ToolError

TEMPORARY = "geomstats_anim-"
"""Prefix of the names of temporary folders."""

LONGEST = 400
"""Characters of a message of OpenUSD: for a broken file it may list every part."""

_TOLD = re.compile(r"Failed to resolve reference @\d+/|Ill-formed SdfPath <")
"""Starts of warnings that say nothing new: when OpenUSD packs, it does not find files under the new names that it gives
them itself; of joint names that are no paths it warns one by one, `names_note` of all."""


def commentary(error: Tf.ErrorException) -> str:
    """Return the first error of several in one line, without places in OpenUSD's source code."""
    return _one_line(error.args[0]) if error.args else "OpenUSD gave no reason"


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
def openusd_errors() -> Iterator[None]:
    """Turn an error of OpenUSD into a `ToolError`.

    Raises
    ------
    ToolError
        If OpenUSD raises.
    """
    try:
        yield
    except Tf.ErrorException as error:
        raise ToolError(commentary(error)) from error


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn an error of OpenUSD on a broken file into a `ToolError`: much of a file is read only when it is asked for.

    Raises
    ------
    ToolError
        If something in it cannot be read.
    """
    try:
        yield
    except Tf.ErrorException as error:
        raise ToolError(f"{path} cannot be read as USD: {commentary(error).rstrip('.')}.") from error
    except UnicodeDecodeError as error:
        raise ToolError(f"{path} cannot be read as USD: it has names that are not UTF-8.") from error


_listening: list[tuple[UsdUtils.CoalescingDiagnosticDelegate, list[str]]] = []
"""Every `usd_warnings` around the code that runs now, and what it has taken so far: all of them hear everything."""


@contextmanager
def usd_warnings(messages: Messages) -> Iterator[None]:
    """Collect what OpenUSD would print on stderr as warnings."""
    listener = (UsdUtils.CoalescingDiagnosticDelegate(), list[str]())
    _listening.append(listener)
    try:
        yield
    finally:
        _listening.remove(listener)
        _take(listener)
        for line in listener[1]:
            if not _TOLD.match(line):
                messages.warn(line)


@contextmanager
def usd_unheard() -> Iterator[None]:
    """Keep OpenUSD from printing what is reported in another way, or has been already."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    for listener in _listening:
        _take(listener)
    try:
        yield
    finally:
        for silenced in (delegate, *(one for one, _ in _listening)):
            silenced.TakeUncoalescedDiagnostics()


def _take(listener: tuple[UsdUtils.CoalescingDiagnosticDelegate, list[str]]) -> None:
    delegate, lines = listener
    lines += map(_one_line, delegate.TakeUncoalescedDiagnostics())
