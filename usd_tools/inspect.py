"""Show the skeletal animation of a USD file, and warn of what may go wrong.

    python -m usd_tools.inspect walk.usda

With `--json` the same as JSON: one object with the stage's metadata, `skeletons`, `animations` and `warnings`.
Codes are time codes of the stage; a value that does not apply is null.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.console.errors import print_warning, run
from usd_tools.console.parser import ArgumentParser
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
    parse.add_argument("input", metavar="IN", type=Path, help="USD file")
    parse.add_argument("--json", action="store_true", help="print JSON instead of tables")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    args = parser(prog).parse_args(argv)

    def command() -> int:
        result = inspect(args.input, warn=print_warning)
        if args.json:
            print(json.dumps(result.as_dict(), indent=2))
        else:
            from usd_tools.inspection.summary import print_summary

            print_summary(result)
        return 0

    return run(command)


if __name__ == "__main__":
    sys.exit(main())
