"""The work of `live`."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable
from pathlib import Path

from usd_tools.editing.saving import SaveOptions
from usd_tools.editing.session import EditSession
from usd_tools.skel.output import Output
from usd_tools.viewer.options import LOCAL, LiveOptions
from usd_tools.viewer.page import LivePage
from usd_tools.viewer.server import serving


def serve(
    source: Path,
    out: Path,
    options: LiveOptions,
    warn: Callable[[str], None] | None,
    announce: Callable[[str], None],
) -> None:
    """Open a file and show it until an interrupt; see `usd_tools.live.live`."""
    Output(source, out, SaveOptions()).check()
    session = EditSession.open(source, options.prim, options.library, warn=warn)
    presets = options.presets or out.parent / "presets"
    with serving(options.host, options.port) as server:
        host = "localhost" if options.host in (LOCAL, "0.0.0.0", "::") else options.host
        address = f"http://{host}:{server.get_port()}"
        page = LivePage(server, session, out, presets)
        announce(address)
        if not options.no_browser:
            webbrowser.open(address)
        try:
            page.run()
        finally:
            page.stop()
