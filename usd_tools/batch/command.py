"""The command line of a verb for several files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from usd_tools.batch.options import BatchOptions
from usd_tools.batch.result import FAILED, SKIPPED, WRITTEN, BatchResult, FileResult, print_problems
from usd_tools.batch.run import Verb, run_tasks
from usd_tools.batch.tasks import find_tasks
from usd_tools.console.errors import UsageError
from usd_tools.console.options import Options
from usd_tools.console.progress import ProgressBar
from usd_tools.console.text import counted, say
from usd_tools.files.atomic import write_json
from usd_tools.files.paths import EXTENSIONS, check_output


def run_verb(
    tool: str,
    verb: Verb,
    args: argparse.Namespace,
    options: Options,
    extensions: Sequence[str] = EXTENSIONS,
    suffix: str | None = None,
    for_one: Sequence[str] = (),
) -> int:
    """Run a verb on several files, print a line for each, and return the exit code.

    Parameters
    ----------
    tool : str
        Such as "usd_tools.upsample".
    verb : callable
        Its function that works on a file, see `Verb`.
    args : argparse.Namespace
        What `add_inputs` and `add_several` have added, and `out`.
    options : Options
        Of the verb; `--usdFormat` chooses the extension of the outputs.
    extensions : sequence of str
        Of the files that it reads.
        Optional, default: those of USD.
    suffix : str
        Extension of the outputs.
        Optional, default: that of each source.
    for_one : sequence of str
        Options that make no sense for several files.

    Returns
    -------
    exit_code : int
        1 if a file has failed.

    Raises
    ------
    UsageError
        If the output folder is not named, or an option is for one file only.
    ToolError
        If nothing can be begun.
    """
    for word in for_one:
        if getattr(args, word) is not None:
            raise UsageError(f"--{word} is for one file; leave it out, or call the command for each file")
    in_place = getattr(options, "in_place", False)
    if args.out is None and not (in_place or getattr(options, "dry_run", False)):
        raise UsageError("name the output folder with -o/--out")
    if in_place and args.out is not None:
        raise UsageError("--in-place changes the inputs; leave --out out")
    how = BatchOptions.from_args(args)
    if how.report is not None and how.report.parent != args.out:  # which may have to be made
        check_output(how.report, "--report")
    usd_format = getattr(options, "usd_format", None)
    tasks = find_tasks(args.input, args.out, extensions, suffix if usd_format is None else f".{usd_format}")
    with ProgressBar() as bar:
        files = run_tasks(verb, tasks, _for_each(options), how, _print_file, bar)
    result = BatchResult(tool, options.settings(), files)
    _print_counts(result, None if getattr(options, "dry_run", False) else args.out)
    if how.report is not None:
        how.report.parent.mkdir(exist_ok=True)
        write_json(how.report, result.as_dict())
    return 1 if result.count(FAILED) else 0


def _for_each(options: Options) -> Any:
    """Return the options of one file: the report is one of all, and the format is in the names."""
    names = {each.name for each in fields(options)}
    return replace(options, **dict.fromkeys(names & {"report", "usd_format"}))


def _print_file(result: FileResult) -> None:
    print_problems(result)
    if result.status == WRITTEN:
        say(f"{result.source}: {result.brief}")


def _print_counts(result: BatchResult, out: Path | None) -> None:
    written = counted(result.count(WRITTEN), "file")
    words = [f"Wrote {written} to {out}" if out is not None else f"Worked on {written}"]
    if result.count(SKIPPED):
        words.append(f"skipped {result.count(SKIPPED)} that {'is' if result.count(SKIPPED) == 1 else 'are'} there")
    if result.count(FAILED):
        words.append(f"{result.count(FAILED)} failed")
    say(f"{', '.join(words)}.")
