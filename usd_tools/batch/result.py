"""Results of a verb on several files, as plain values."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass
from typing import Any, Protocol

from geomstats_anim._version import __version__
from usd_tools.console.errors import print_warning
from usd_tools.console.text import print_to

WRITTEN, SKIPPED, FAILED = "written", "skipped", "failed"


class Result(Protocol):
    """Result of a verb on one file."""

    @property
    def brief(self) -> str:
        """Summary of what was done, in a few words."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what to beware of."""

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""


@dataclass(frozen=True)
class FileResult:
    """Result for one file.

    Parameters
    ----------
    source : str
        As seen from the folder that it was found in.
    output : str or None
        As seen from the output folder; None if nothing is written.
    status : str
        "written", also of a dry run, "skipped" or "failed".
    brief : str
        What was done, or what went wrong.
    warnings : tuple of str
    report : dict or None
        What `--report` has of this file alone; None unless it is written.
    """

    source: str
    output: str | None
    status: str
    brief: str
    warnings: tuple[str, ...] = ()
    report: dict[str, Any] | None = None


def print_problems(result: FileResult) -> None:
    """Print the warnings of a file, or why it has failed, on stderr."""
    for sentence in result.warnings:
        print_warning(f"{result.source}: {sentence}")
    if result.status == FAILED:
        sentence = result.brief if result.source in result.brief else f"{result.source}: {result.brief}"
        print_to(sys.stderr, f"error: {sentence}")


@dataclass(frozen=True)
class BatchResult:
    """Result for several files.

    Parameters
    ----------
    tool : str
        Such as "usd_tools.upsample".
    settings : dict
        Options that were asked for, plain values.
    files : tuple of FileResult
        In the order of their names.
    """

    tool: str
    settings: dict[str, Any]
    files: tuple[FileResult, ...]

    def count(self, status: str) -> int:
        """Count the files of a status."""
        return Counter(file.status for file in self.files)[status]

    def as_dict(self) -> dict[str, Any]:
        """Return the content of `--report`."""
        return {
            "tool": self.tool,
            "version": __version__,
            "settings": self.settings,
            **{status: self.count(status) for status in (WRITTEN, SKIPPED, FAILED)},
            "files": [
                {
                    "source": file.source,
                    "output": file.output,
                    "status": file.status,
                    "error": file.brief if file.status == FAILED else None,
                    "report": file.report,
                }
                for file in self.files
            ],
        }
