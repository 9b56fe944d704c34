"""See a character play, and bend its in-betweens with the mouse, in a browser; the result is saved as a layer.

python -m usd_tools.live walk.usda -o walk_styled.usda
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from usd_tools.console.errors import print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.text import say
from usd_tools.upsampling.arguments import add_library
from usd_tools.viewer.options import LOCAL, LiveOptions, port_number

__all__ = ["LiveOptions", "live", "main", "parser"]

PROG = "python -m usd_tools.live"


def live(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    options: LiveOptions | None = None,
    *,
    warn: Callable[[str], None] | None = None,
    announce: Callable[[str], None] | None = None,
) -> None:
    """Serve the page on which the in-betweens of a file's animation are edited, until it is interrupted.

    Parameters
    ----------
    source : path-like
        USD file.
    out : path-like
        USD file that Save writes; until then, edits are kept beside it.
        Optional, default: named after the source, with _live, in the current folder.
    options : LiveOptions
        Optional, default: `LiveOptions()`.
    warn : callable
        Called with each warning as it comes.
        Optional, default: nobody is told.
    announce : callable
        Called with the address when the page is served.
        Optional, default: nobody is told.

    Raises
    ------
    ToolError
        If something is wrong with the file, viser is missing, or the port is taken; nothing is served then.
    KeyboardInterrupt
        When it is interrupted; the edits are kept.
    """
    from usd_tools.viewer.run import serve

    path = Path(source)
    target = Path(f"{path.stem}_live.usda") if out is None else Path(out)
    serve(path, target, options or LiveOptions(), warn, announce or (lambda address: None))


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="See a character play in a browser beside its original and slerp, and bend its in-betweens with "
        "the mouse: alpha, beta, side and tension of any joint, keys, presets, learning. Save writes a layer over IN "
        "with the metric, its keys, or dense samples.",
        epilog="Needs the extra live: pip install 'geomstats-anim[live]'. Ctrl-C ends it; edits that are not saved are "
        "kept beside OUT, and offered at the next start.",
    )
    parse.add_argument("input", metavar="IN", type=Path, help="USD file")
    parse.add_argument(
        "-o",
        "--out",
        metavar="OUT",
        type=Path,
        help="USD file that Save writes; default: IN's name with _live, in the current folder",
    )
    parse.add_argument(
        "--prim", metavar="PATH", help="the SkelAnimation or Skeleton to edit, where IN has several, or a prim above"
    )
    add_library(parse)
    parse.add_argument(
        "--port", metavar="N", type=port_number, help="port of the page; default: the first free one from 8080 on"
    )
    parse.add_argument(
        "--host",
        metavar="ADDRESS",
        default=LOCAL,
        help=f"address to bind; default: {LOCAL}, which only this machine can reach",
    )
    parse.add_argument(
        "--presets", metavar="FOLDER", type=Path, help="your presets, as JSON; default: presets, beside OUT"
    )
    parse.add_argument("--no-browser", action="store_true", help="open no browser")
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    parse = parser(prog)
    args = parse.parse_args(argv)

    def command() -> int:
        try:
            live(args.input, args.out, LiveOptions.from_args(args), warn=print_warning, announce=_announce)
        except KeyboardInterrupt:
            say("Ended; edits that were not saved are kept.")
        return 0

    return run(command, parse.error)


def _announce(address: str) -> None:
    say(f"Serving {address} until Ctrl-C.")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
