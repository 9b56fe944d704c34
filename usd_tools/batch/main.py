"""The command line of a verb that works on files, each by itself."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any

from usd_tools.batch.tasks import is_batch
from usd_tools.console.errors import print_warning, run
from usd_tools.console.options import Options
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar

Work = tuple[Callable[..., Any], Callable[[Any, argparse.Namespace], None]]
"""A verb's function on a file, see `batch.run.Verb`, and what prints its result."""


def run_on_files(
    parse: ArgumentParser,
    argv: Sequence[str] | None,
    tool: str,
    options: type[Options],
    work: Callable[[], Work],
    **several: Any,
) -> int:
    """Run a verb on the file, or the files and folders, of a command line, and return the exit code.

    Parameters
    ----------
    parse : ArgumentParser
        With what `add_inputs` and `add_several` add, and `out`.
    argv : sequence of str or None
        Words after the verb; None for those of the process.
    tool : str
        Such as "usd_tools.upsample".
    options : type
        Of the verb.
    work : callable
        Imports what does the work, and returns it.
    **several
        For `batch.command.run_verb`.

    Returns
    -------
    exit_code : int
    """
    args = parse.parse_args(argv)

    def command() -> int:
        chosen = options.from_args(args)
        if is_batch(args):
            from usd_tools.batch.command import run_verb

            return run_verb(tool, work()[0], args, chosen, **several)
        (source,) = args.input
        verb, show = work()
        with ProgressBar() as bar:
            result = verb(source, args.out, chosen, bar, print_warning)
        show(result, args)
        return 0

    return run(command, parse.error)
