"""Options of `demo`."""

from __future__ import annotations

from dataclasses import dataclass

from usd_tools.console.options import Options, option


@dataclass(frozen=True, kw_only=True)
class DemoOptions(Options):
    """Options of `demo`.

    Parameters
    ----------
    no_browser : bool
        Whether to open no browser.
        Optional, default: False.
    """

    no_browser: bool = option(False, bool, recorded=False)
