"""A progress bar that keeps out of the way: only after two seconds, only on a terminal, only on stderr."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any, Self

from usd_tools.console.text import printable

PATIENCE = 2.0
"""Seconds before the bar shows."""


class Progress:
    """Progress of one long task.

    Parameters
    ----------
    total : float or None
        Amount of work, in any unit; None if nobody knows.
    description : str
    """

    def __init__(self, total: float | None, description: str) -> None:
        self._total, self._description, self._done = total, description, 0.0
        self._start = time.monotonic()
        self._bar: Any = None

    def __enter__(self) -> Self:
        """Start the clock."""
        return self

    def advance(self, amount: float, description: str | None = None) -> None:
        """Report that some work has been done, and perhaps what is being done now."""
        self._done += amount
        self._description = description or self._description
        if self._bar is None:
            if time.monotonic() - self._start < PATIENCE or not sys.stderr.isatty():
                return
            from rich.console import Console
            from rich.progress import Progress as Bar
            from rich.progress import TextColumn, TimeElapsedColumn

            console = Console(stderr=True, emoji=False)
            unknown = (TextColumn("{task.description}"), TimeElapsedColumn()) if self._total is None else ()
            self._bar = Bar(*unknown, console=console, transient=True)
            self._bar.start()
            self._task = self._bar.add_task("", total=self._total)
        self._bar.update(self._task, completed=self._done, description=self._shown())

    def _shown(self) -> str:
        """Return the description without what rich or a terminal would obey: it may hold names from files."""
        from rich.markup import escape

        return escape(printable(self._description))

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()


class SearchProgress(Progress):
    """Progress of a search for a metric.

    Parameters
    ----------
    trials : int or None
        Most evaluations, if that is known.
    """

    def __init__(self, trials: int | None) -> None:
        super().__init__(trials, "Learning")
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
