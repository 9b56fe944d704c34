"""Options of every verb for several files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from usd_tools.console.arguments import whole_number
from usd_tools.console.errors import UsageError
from usd_tools.console.options import Options, option


@dataclass(frozen=True, kw_only=True)
class BatchOptions(Options):
    """Options for work on several files.

    Parameters
    ----------
    jobs : int
        Processes on this machine.
        Optional, default: 1, this one.
    skip_existing : bool
        Leave files alone whose output is there already.
    address : str
        Of a Ray cluster, whose machines see the files under the same paths.
        Optional, default: the environment variable RAY_ADDRESS, else none.
    cpus : int
        Workers of Ray; more than one starts it.
        Optional, default: all of a cluster, else 1.
    report : Path
        JSON file to write the summary of all files to.
        Optional, default: none.
    """

    jobs: int | None = option(None, whole_number)
    skip_existing: bool = option(False, bool)
    address: str | None = option(None, str)
    cpus: int | None = option(None, whole_number)
    report: Path | None = option(None, Path)

    def check(self) -> None:
        """Refuse values that do not go together."""
        if self.jobs is not None and (self.address or self.cpus):
            raise UsageError("--jobs starts processes, and --cpus and --address use Ray; leave one of them out")
