"""Show the skeletal animation of a USD file, and warn of what may go wrong.

    python -m usd_tools.inspect walk.usda

With `--json` the same as JSON: one object with the stage's metadata, `skeletons`, `animations` and `warnings`.
Codes are time codes of the stage; a value that does not apply is null.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.result import FAILED, print_problems
from usd_tools.console.arguments import whole_number
from usd_tools.console.errors import UsageError, print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar
from usd_tools.inspection.result import InspectResult

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["InspectResult", "inspect", "inspect_stage", "main", "parser"]

PROG = "python -m usd_tools.inspect"


def inspect(source: str | os.PathLike[str], *, warn: Callable[[str], None] | None = None) -> InspectResult:
    """Describe the skeletal animation of a USD file.

    Parameters
    ----------
    source : path-like
        USD file.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : InspectResult

    Raises
    ------
    ToolError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Gf, Usd, UsdSkel
    >>> path = Path(tempfile.mkdtemp()) / "turn.usda"
    >>> stage = Usd.Stage.CreateNew(str(path))
    >>> turn = UsdSkel.Animation.Define(stage, "/Turn")
    >>> _ = turn.CreateJointsAttr(["arm"])
    >>> _ = turn.CreateRotationsAttr().Set([Gf.Quatf(1, 0, 0, 0)], 0)
    >>> _ = turn.CreateRotationsAttr().Set([Gf.Quatf(0, 1, 0, 0)], 24)
    >>> stage.Save()
    >>> (animation,) = inspect(path).animations
    >>> animation["samples"], animation["largest_step"]["degrees"]
    (2, 180.0)
    """
    from usd_tools.inspection.describe import inspect_file

    return inspect_file(Path(source), warn)


def inspect_stage(stage: Usd.Stage, *, warn: Callable[[str], None] | None = None) -> InspectResult:
    """Describe the skeletal animation of an open stage.

    Parameters
    ----------
    stage : Usd.Stage
    warn : callable
        See `inspect`.

    Returns
    -------
    result : InspectResult

    Raises
    ------
    ToolError
        If something on the stage cannot be read.

    Examples
    --------
    >>> from pxr import Gf, Usd, UsdSkel
    >>> stage = Usd.Stage.CreateInMemory()
    >>> _ = UsdSkel.Animation.Define(stage, "/Turn").CreateJointsAttr(["arm"])
    >>> inspect_stage(stage).animations[0]["joints"]
    1
    """
    from usd_tools.inspection.describe import inspect_open_stage

    return inspect_open_stage(stage, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Show the skeletal animation of a USD file, and warn of what may go wrong.",
    )
    parse.add_argument(
        "input",
        metavar="IN",
        nargs="+",
        type=Path,
        help="USD file; of several, or of folders: a row for each animation, and the takes of each rig",
    )
    form = parse.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print JSON instead of tables")
    form.add_argument("--csv", action="store_true", help="print the rows of several files as CSV")
    parse.add_argument("--jobs", metavar="N", type=whole_number, help="processes for several files; default: 1")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)

    def command() -> int:
        if len(args.input) > 1 or args.input[0].is_dir():
            return _inspect_several(args)
        if args.csv or args.jobs:
            raise UsageError(f"--{'csv' if args.csv else 'jobs'} is for several files or a folder; leave it out")
        result = inspect(args.input[0], warn=print_warning)
        if args.json:
            print(json.dumps(result.as_dict(), indent=2))
        else:
            from usd_tools.inspection.summary import print_summary

            print_summary(result)
        return 0

    return run(command, parse.error)


def _inspect_several(args: argparse.Namespace) -> int:
    """Print a row for each animation of several files; return the exit code."""
    from usd_tools.batch.options import BatchOptions
    from usd_tools.batch.run import run_tasks
    from usd_tools.batch.tasks import find_tasks
    from usd_tools.files.paths import EXTENSIONS
    from usd_tools.inspection.folder import FolderResult, inspect_task

    tasks = find_tasks(args.input, None, EXTENSIONS, None)
    with ProgressBar() as bar:
        files = run_tasks(inspect_task, tasks, None, BatchOptions(jobs=args.jobs or 1), print_problems, bar)
    result = FolderResult(files)
    if args.json:
        print(json.dumps(result.as_dict(), indent=2))
    elif args.csv:
        print(result.as_csv(), end="")
    else:
        result.print_summary()
    return 1 if any(file.status == FAILED for file in files) else 0


if __name__ == "__main__":
    sys.exit(main())
