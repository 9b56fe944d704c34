"""Blender extension: in-betweens of pose keys by the schemes of geomstats-anim, which runs in a process of its own."""

from . import live, operators, panel, preferences, service, settings

_MODULES = (preferences, settings, operators, panel, live)


def register():
    """Register everything."""
    for module in _MODULES:
        module.register()


def unregister():
    """Unregister everything, and end the process."""
    for module in reversed(_MODULES):
        module.unregister()
    service.close()
