"""The server of the page: viser, quiet, and for pages of its own only."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from functools import partial
from typing import TYPE_CHECKING

from usd_tools.console.errors import ToolError

if TYPE_CHECKING:
    import viser

DEFAULT_PORT = 8080
"""The first that is tried where none is asked for."""


@contextmanager
def serving(host: str, port: int | None) -> Iterator[viser.ViserServer]:
    """Yield a server that runs until the end of the context.

    Parameters
    ----------
    host : str
        Address to bind.
    port : int or None
        None for the first that is free, from `DEFAULT_PORT` on.

    Raises
    ------
    ToolError
        If viser is missing, or the address cannot be bound.
    """
    try:
        import viser
    except ImportError:
        raise ToolError("live needs viser; install it with: pip install 'geomstats-anim[live]'.") from None
    with redirect_stdout(io.StringIO()), _own_pages_only(host):  # viser prints a frame around its address
        server = viser.ViserServer(host=host, port=DEFAULT_PORT if port is None else port, verbose=False)
    try:
        if port not in (None, 0, server.get_port()):
            raise ToolError(f"port {port} of {host} cannot be bound; choose another --port.")
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        yield server
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


@contextmanager
def _own_pages_only(host: str) -> Iterator[None]:
    """Let websockets refuse the pages of strangers while viser starts, for viser itself accepts every origin."""
    from websockets.asyncio import server

    names = {"localhost", "127.0.0.1", "[::1]"} if host in ("127.0.0.1", "localhost", "::1") else None
    if names is None:  # seen under names that nobody here knows
        yield
        return
    origin = re.compile(rf"https?://({'|'.join(map(re.escape, names))})(:\d+)?")
    plain = server.serve
    server.serve = partial(plain, origins=[origin, None])  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        server.serve = plain  # type: ignore[misc]
