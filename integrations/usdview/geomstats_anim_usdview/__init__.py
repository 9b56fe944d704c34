"""Plug-in of usdview: the menu Geodesic, with in-betweens in the session layer and the metric of each joint.

Install `geomstats-anim` for usdview's Python, put the folder above this one on PYTHONPATH and this one on
PXR_PLUGINPATH_NAME. The commands are tested against a stand-in for usdview; usdview itself is on no package index, so
the menu and the dialogs were not run in it.
"""

from __future__ import annotations

from typing import Any

from pxr import Tf
from pxr.Usdviewq.plugin import PluginContainer


class GeodesicContainer(PluginContainer):
    """The menu and its commands; what they do is imported when one is called."""

    def registerPlugins(self, plugRegistry: Any, usdviewApi: Any) -> None:  # noqa: N802, N803
        """Register a command for each item of the menu."""
        items = {"Upsample...": _upsample, "Metric of Each Joint...": _show, "Remove": _remove}
        self._commands = [
            plugRegistry.registerCommandPlugin(f"GeodesicContainer.{call.__name__.strip('_')}", label, call)
            for label, call in items.items()
        ]

    def configureView(self, plugRegistry: Any, plugUIBuilder: Any) -> None:  # noqa: N802, N803
        """Make the menu."""
        menu = plugUIBuilder.findOrCreateMenu("Geodesic")
        for command in self._commands:
            menu.addItem(command)


def _upsample(api: Any) -> None:
    from geomstats_anim_usdview.commands import upsample
    from geomstats_anim_usdview.dialogs import ask_options

    options = ask_options(api)
    if options is not None:
        upsample(api, **options)


def _show(api: Any) -> None:
    from geomstats_anim_usdview.commands import metric_tables
    from geomstats_anim_usdview.dialogs import show_tables

    tables = metric_tables(api)
    if tables:
        show_tables(api, tables)


def _remove(api: Any) -> None:
    from geomstats_anim_usdview.commands import remove

    remove(api)


Tf.Type.Define(GeodesicContainer)
