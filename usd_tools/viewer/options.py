"""Options of `live`."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from operator import index
from pathlib import Path

from usd_tools.console.options import Options, option

LOCAL = "127.0.0.1"
"""Address that only this machine can reach."""


def port_number(value: str | int) -> int:
    """Take a port: a whole number from 0, for any that is free, to 65535."""
    try:
        port = int(value) if isinstance(value, str) else index(value)
    except (ValueError, TypeError):
        port = -1
    if not 0 <= port <= 65535:
        raise argparse.ArgumentTypeError(f"must be a whole number from 0 to 65535, not {value!r}")
    return port


@dataclass(frozen=True, kw_only=True)
class LiveOptions(Options):
    """Options of `live`.

    Parameters
    ----------
    prim : str
        Path of the SkelAnimation, or of its Skeleton, or of a prim above.
        Optional, default: the only animation of the file, or the only one that drives a skeleton.
    library : Path
        Library of in-betweens of the rig, as `usd_tools.learn --library` makes it, for the scheme "learned".
        Optional, default: none.
    port : int
        Port of the page; 0 for any that is free.
        Optional, default: the first free one from 8080 on.
    host : str
        Address to bind.
        Optional, default: 127.0.0.1, which only this machine can reach.
    presets : Path
        Folder of the user's presets.
        Optional, default: presets, beside the output.
    no_browser : bool
        Whether to open no browser.
        Optional, default: False.
    """

    prim: str | None = option(None, str)
    library: Path | None = option(None, Path)
    port: int | None = option(None, port_number, recorded=False)
    host: str = option(LOCAL, str, recorded=False)
    presets: Path | None = option(None, Path, recorded=False)
    no_browser: bool = option(False, bool, recorded=False)
