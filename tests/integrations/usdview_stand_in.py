"""A stand-in for usdview, which is on no package index: of its documented interface what plug-ins use."""

import sys
import types

from pxr import Tf


class PluginContainer:
    """Base of plug-ins, as in pxr.Usdviewq.plugin."""

    def deferredImport(self, name):  # noqa: N802
        raise NotImplementedError

    def registerPlugins(self, plugRegistry, usdviewApi):  # noqa: N802, N803
        raise NotImplementedError

    def configureView(self, plugRegistry, plugUIBuilder):  # noqa: N802, N803
        raise NotImplementedError


class UsdviewApi:
    """Arguments that commands are called with: the stage, the selection, the status line."""

    def __init__(self, stage, *selected):
        self.stage, self.selectedPrims, self.status, self.qMainWindow = stage, list(selected), [], None

    def PrintStatus(self, text):  # noqa: N802
        self.status.append(text)


class PluginRegistry:
    """Commands by name, each once."""

    def __init__(self):
        self.commands = {}

    def registerCommandPlugin(self, name, displayName, callback, description=""):  # noqa: N802, N803
        assert name not in self.commands
        self.commands[name] = (displayName, callback)
        return name


class PluginUIBuilder:
    """Menus with items."""

    def __init__(self):
        self.menus = {}

    def findOrCreateMenu(self, name):  # noqa: N802
        items = self.menus.setdefault(name, [])
        return types.SimpleNamespace(addItem=items.append)


def install():
    """Put the modules that usdview brings where Python finds them."""
    if "pxr.Usdviewq.plugin" not in sys.modules:
        package, plugin = types.ModuleType("pxr.Usdviewq"), types.ModuleType("pxr.Usdviewq.plugin")
        PluginContainer.__module__ = plugin.__name__
        plugin.PluginContainer, package.plugin = PluginContainer, plugin
        sys.modules |= {package.__name__: package, plugin.__name__: plugin}
        Tf.Type.Define(PluginContainer)
