"""Live: what was filled is filled again when keys or sliders have changed, a moment after the last change."""

import hashlib
import json

import bpy
from bpy.app.handlers import persistent

from . import curves as fc
from . import fill, service, style, working_copy

DELAY = 0.15
"""Seconds without a change before it is filled again."""

_seen = {}
"""Inputs that each armature was filled from, by name."""

last_error = {}
"""Sentence on what went wrong last, by the armature's name."""


def touch(armature):
    """Have an armature filled again, if it is live."""
    if armature is not None and armature.geodesic.live:
        _wait()


def _wait():
    if bpy.app.timers.is_registered(update):
        bpy.app.timers.unregister(update)
    bpy.app.timers.register(update, first_interval=DELAY)


def update():
    """Fill every live armature that has changed since; return None, as timers do that are done."""
    if service.is_busy() or _is_in_use():
        return DELAY
    for armature in bpy.data.objects:
        if armature.type == "ARMATURE" and armature.geodesic.live:
            _update(armature)
    return None


def _is_in_use():
    """Return whether the animation plays, or keys are being dragged, which must not be exchanged meanwhile."""
    windows = bpy.context.window_manager.windows
    return any(window.screen.is_animation_playing or len(window.modal_operators) for window in windows)


def _update(armature):
    copy = working_copy.opened(armature)
    if copy is None:
        return
    now = _fingerprint(armature, copy)
    if _seen.get(armature.name) == now:
        return
    _seen[armature.name] = now
    try:
        fill.fill(armature)
        last_error.pop(armature.name, None)
    except (fill.FillError, service.ServiceError, style.StyleError) as error:
        last_error[armature.name] = str(error)


def _fingerprint(armature, copy):
    """Return a hash of all that the in-betweens depend on."""
    found = hashlib.sha256()
    for curve in copy.curves:
        keys = fc.read_keys(curve, fc.OWN_FIELDS)
        found.update(f"{curve.data_path} {curve.array_index} {curve.lock} {curve.mute}".encode())
        found.update(keys[~fc.is_generated(keys)].tobytes())
    found.update(json.dumps([style.document_of(armature), armature.geodesic.library, fill.frame_seconds()]).encode())
    modes = [(bone.rotation_mode, *bone.lock_rotation, *bone.lock_location) for bone in armature.pose.bones]
    found.update(repr(modes).encode())
    return found.digest()


@persistent
def _changed(scene, graph):
    for change in graph.updates:
        if isinstance(change.id, bpy.types.Action | bpy.types.Object) and _is_live():
            return _wait()


@persistent
def _travelled(*_):
    """Fill again after undo and redo, which bring back keys, perhaps from before they were filled."""
    _seen.clear()
    if _is_live():
        _wait()


def _is_live():
    return any(each.type == "ARMATURE" and each.geodesic.live for each in bpy.data.objects)


@persistent
def _saving(*_):
    """Keep the JSON true to the custom properties, which can be edited elsewhere too."""
    for armature in bpy.data.objects:
        if armature.type == "ARMATURE":
            style.store(armature)


_HANDLERS = {"depsgraph_update_post": _changed, "undo_post": _travelled, "redo_post": _travelled, "save_pre": _saving}


def register():
    """Listen to changes."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    """Listen no more."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
    if bpy.app.timers.is_registered(update):
        bpy.app.timers.unregister(update)
