"""Which animations of a file a command works on."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from pxr import Sdf

from usd_tools.console.errors import ToolError
from usd_tools.skel.clip import AnimationSource


def add_option(parse: argparse.ArgumentParser) -> None:
    """Add `--prim`."""
    parse.add_argument(
        "--prim",
        metavar="PATH",
        action="append",
        default=[],
        help="only this SkelAnimation or Skeleton, or those below this prim; may be repeated; default: all",
    )


def selected(path: Path, sources: list[AnimationSource], wanted: Sequence[str]) -> list[AnimationSource]:
    """Keep the animations that `--prim` asks for.

    Parameters
    ----------
    path : Path
        File that they are in.
    sources : list of AnimationSource
    wanted : sequence of str
        Paths of prims; none for all.

    Returns
    -------
    sources : list of AnimationSource
        At least one, in the same order.

    Raises
    ------
    ToolError
        If there is no such prim, or no animation there.
    """
    if not sources:
        raise ToolError(f"{path} has no skeletal animation.")
    if not wanted:
        return sources
    stage = sources[0].stage
    chosen = []
    for text in wanted:
        prefix = Sdf.Path(text) if Sdf.Path.IsValidPathString(text) else Sdf.Path()
        if not prefix.IsAbsolutePath() or not stage.GetPrimAtPath(prefix):
            raise ToolError(f"--prim {text}: there is no such prim in {path}; usd_tools.inspect lists the animations.")
        below = [
            source
            for source in sources
            if any(prim.GetPath().HasPrefix(prefix) for prim in (*source.prims, *source.skeletons))
        ]
        if not below:
            raise ToolError(f"--prim {text} has no skeletal animation in {path}; usd_tools.inspect lists them.")
        chosen += below
    return [source for source in sources if source in chosen]
