"""Progress: counted where the work is done, and shown by a bar on stderr, late and on a terminal only."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from usd_tools.console.text import printable

ProgressCallback = Callable[[float, float | None, str], None]
"""Called with the work done, all the work in the same unit (None if nobody knows), and what is being done."""

PATIENCE = 2.0
"""Seconds before the bar shows."""


class Progress:
    """Progress of one task.

    Parameters
    ----------
    callback : ProgressCallback or None
    total : float or None
        Amount of work, in any unit; None if nobody knows.
    text : str
        What is being done.
    """

    def __init__(self, callback: ProgressCallback | None, total: float | None, text: str) -> None:
        self._callback, self._total, self._text, self._done = callback, total, text, 0.0

    def advance(self, amount: float, text: str | None = None) -> None:
        """Report that some work has been done, and perhaps what is being done now."""
        self._done += amount
        self._text = text or self._text
        if self._callback is not None:
            self._callback(self._done, self._total, self._text)


class SearchProgress(Progress):
    """Progress of a search for a metric.

    Parameters
    ----------
    callback : ProgressCallback or None
    trials : int or None
        Most evaluations, if that is known.
    """

    def __init__(self, callback: ProgressCallback | None, trials: int | None) -> None:
        super().__init__(callback, trials, "Learning")
        self._evaluations = 0
        self._searches = 1
        self._slerp: float | None = None

    def watch(self, evaluations: int, value: float) -> None:
        """Take the number of evaluations and the best value so far; searches begin with slerp's metric."""
        if evaluations <= self._evaluations:
            self._searches += 1
            self._evaluations, self._slerp = 0, None
        if self._slerp is None:
            self._slerp = value
        amount, self._evaluations = evaluations - self._evaluations, evaluations
        doing = "Learning" if self._searches == 1 else f"Checking what carries over, {self._searches - 1}"
        gain = 100.0 * (1.0 - value / self._slerp) if self._slerp else 0.0
        self.advance(amount, f"{doing}: {evaluations} tried, Q {value:.4g}, {gain:.1f} % below slerp")

    def choose(self, share: float) -> None:
        """Take the share of a choice of keys that is done."""
        self.advance(0.0, f"Choosing keys: {share:.0%}")


class ProgressBar:
    """A `ProgressCallback` that draws a bar on stderr: only after two seconds, only on a terminal."""

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._bar: Any = None
        self._total: float | None = None

    def __enter__(self) -> Self:
        """Start the clock."""
        return self

    def __call__(self, done: float, total: float | None, text: str) -> None:
        """Show the state of a task; a task of another size than the last is another task."""
        if self._bar is None or self._total != total:
            if time.monotonic() - self._start < PATIENCE or not sys.stderr.isatty():
                return
            self._stop()
            self._begin(total)
        from rich.markup import escape

        # Names from files may hold what rich or a terminal would obey.
        self._bar.update(self._task, completed=done, description=escape(printable(text)))

    def _begin(self, total: float | None) -> None:
        from rich.console import Console
        from rich.progress import Progress as Bar
        from rich.progress import TextColumn, TimeElapsedColumn

        unknown = (TextColumn("{task.description}"), TimeElapsedColumn()) if total is None else ()
        self._bar, self._total = Bar(*unknown, console=Console(stderr=True, emoji=False), transient=True), total
        self._bar.start()
        self._task = self._bar.add_task("", total=total)

    def _stop(self) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove the bar."""
        self._stop()
