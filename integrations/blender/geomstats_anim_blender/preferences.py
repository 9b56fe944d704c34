"""Preferences: which Python has geomstats-anim."""

import os
import shutil

import bpy


class Preferences(bpy.types.AddonPreferences):
    """Preferences of the extension."""

    bl_idname = __package__

    python: bpy.props.StringProperty(
        name="Python",
        description="Python that has geomstats-anim; empty: the one of the command geomstats-anim on the PATH",
        subtype="FILE_PATH",
    )

    def draw(self, context):
        """Draw the preferences."""
        self.layout.prop(self, "python")
        self.layout.operator("geodesic.check")


def python():
    """Return the path of the Python that has geomstats-anim, or None."""
    chosen = bpy.context.preferences.addons[__package__].preferences.python
    if chosen:
        return bpy.path.abspath(chosen)
    command = shutil.which("geomstats-anim")
    if command is None:
        return None
    folder = os.path.dirname(os.path.realpath(command))  # pipx and uv link to it
    beside = (os.path.join(folder, name) for name in ("python", "python.exe"))
    return next((path for path in beside if os.path.exists(path)), None)


def register():
    """Register the preferences."""
    bpy.utils.register_class(Preferences)


def unregister():
    """Unregister the preferences."""
    bpy.utils.unregister_class(Preferences)
