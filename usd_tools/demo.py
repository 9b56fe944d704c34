"""Show what this is about: make a clip, keep a tenth of its samples, rebuild it by slerp and by the learned spline.

python -m usd_tools.demo
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from usd_tools.console.errors import print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressBar, ProgressCallback
from usd_tools.console.text import say
from usd_tools.demonstration.options import DemoOptions
from usd_tools.demonstration.result import DemoResult

__all__ = ["DemoOptions", "DemoResult", "demo", "main", "parser"]

PROG = "python -m usd_tools.demo"

FOLDER = Path("geomstats_anim_demo")
"""Folder that is written unless another is named."""


def demo(
    out: str | os.PathLike[str] = FOLDER,
    options: DemoOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> DemoResult:
    """Make a clip, rebuild it from a tenth of its samples, and write a page and a picture of both.

    Parameters
    ----------
    out : path-like
        Folder to make; replaced if all its files were made by an earlier demonstration.
        Optional, default: geomstats_anim_demo in the current folder.
    options : DemoOptions
        Optional, default: `DemoOptions()`, which opens the page in a browser.
    progress : callable
        Called with the work done, all the work (None if nobody knows), and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes.
        Optional, default: nobody is told.

    Returns
    -------
    result : DemoResult

    Raises
    ------
    ToolError
        If the folder cannot be written.
    """
    from usd_tools.demonstration.run import make_demo

    result = make_demo(Path(out), progress, warn)
    if not (options or DemoOptions()).no_browser:
        import webbrowser

        webbrowser.open(result.page.resolve().as_uri())
    return result


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Make a clip of a baseball pitch, keep 14 of its 142 samples, rebuild the others by slerp and by "
        "the learned spline, and open a page on which all three play.",
    )
    parse.add_argument(
        "-o",
        "--out",
        metavar="FOLDER",
        type=Path,
        default=FOLDER,
        help=f"output folder; replaced only if an earlier run of this command created it; default: {FOLDER}",
    )
    parse.add_argument("--no-browser", action="store_true", help="open no browser")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)

    def command() -> int:
        with ProgressBar() as bar:
            result = demo(args.out, DemoOptions.from_args(args), progress=bar, warn=print_warning)
        say(f"Kept {result.keys} of the {result.samples} samples of {result.clip}, and rebuilt the others:")
        for scheme, (mean, largest) in result.centimetres.items():
            say(f"  {scheme}: bone ends are {mean:.1f} cm from the original, {largest:.0f} cm at most.")
        say(f"Wrote {result.page} and {result.picture}.")
        return 0

    return run(command, parse.error)


if __name__ == "__main__":
    sys.exit(main())
