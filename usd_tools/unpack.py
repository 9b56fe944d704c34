"""Restore the samples of packed skeletal animation.

python -m usd_tools.unpack walk_packed.usdc -o walk_back.usdc
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.main import Work, run_on_files
from usd_tools.console.arguments import add_inputs, add_output, add_prim, add_several
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.packing.options import UnpackOptions
from usd_tools.packing.result import UnpackedAnimation, UnpackResult

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["UnpackOptions", "UnpackResult", "UnpackedAnimation", "main", "parser", "unpack", "unpack_stage"]

PROG = "python -m usd_tools.unpack"


def unpack(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    options: UnpackOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> UnpackResult:
    """Restore the samples of the packed animations of a USD file.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like or None
        USD file to write; None with `in_place`.
    options : UnpackOptions
        Optional, default: the defaults.
    progress : callable
        Not called: unpacking takes milliseconds.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : UnpackResult

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the file, or nothing in it is packed; nothing is written then.
    """
    from usd_tools.packing.unpacking import unpack_file

    return unpack_file(Path(source), None if out is None else Path(out), options or UnpackOptions(), progress, warn)


def unpack_stage(
    stage: Usd.Stage, options: UnpackOptions | None = None, *, warn: Callable[[str], None] | None = None
) -> UnpackResult:
    """Restore the samples of the packed animations of an open stage, in the layer of its edit target.

    Parameters
    ----------
    stage : Usd.Stage
    options : UnpackOptions
        Those about files are not used.
        Optional, default: the defaults.
    warn : callable
        See `unpack`.

    Returns
    -------
    result : UnpackResult

    Raises
    ------
    ToolError
        If something is wrong with the stage, nothing on it is packed, or stronger opinions would hide what is written;
        the layer is as it was then.
    """
    from usd_tools.packing.unpacking import unpack_open_stage

    return unpack_open_stage(stage, options or UnpackOptions(), warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Restore the samples of skeletal animation that usd_tools.pack has packed, at the time codes of "
        "its source, for programs that read samples only. Everything else on the stage is unchanged.",
    )
    add_inputs(parse)
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, help="USD file or folder to write")
    add_prim(parse)
    add_output(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")
    add_several(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(parser(prog), argv, "usd_tools.unpack", UnpackOptions, _work)


def _work() -> Work:
    from usd_tools.packing.summary import print_unpacked
    from usd_tools.packing.unpacking import unpack_file

    return unpack_file, lambda result, _: print_unpacked(result)


if __name__ == "__main__":
    sys.exit(main())
