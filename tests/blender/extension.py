"""Functions that scripts that run the extension share: it is installed from its zip by Blender's own command."""

import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import bpy
from armatures import only_armature

MODULE = "bl_ext.user_default.geomstats_anim"


def install(archive, python):
    """Validate the zip, install it into the user's extensions, enable it, and choose the Python that computes."""
    import bl_pkg

    command = Path(bl_pkg.__file__).parent / "cli" / "blender_ext.py"
    subprocess.run([sys.executable, command, "validate", archive, "--valid-tags", ""], check=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    done = bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
    assert done == {"FINISHED"} and MODULE in bpy.context.preferences.addons
    bpy.context.preferences.addons[MODULE].preferences.python = python
    assert bpy.ops.geodesic.check() == {"FINISHED"}


def part(name):
    """Return a module of the extension."""
    return sys.modules[f"{MODULE}.{name}"]


def load(source):
    """Import a USD file into an empty scene, and return its armature, active and in pose mode."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    for action in list(bpy.data.actions):
        bpy.data.actions.remove(action)
    bpy.ops.wm.usd_import(filepath=source, set_frame_range=True)
    armature = only_armature()
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="POSE")
    return armature


def curves(action):
    """Return the curves of an action with one slot."""
    return action.layers[0].strips[0].channelbag(action.slots[0]).fcurves


def dump(action):
    """Return all that an action holds."""
    fields = ("co", "handle_left", "handle_right", "interpolation", "type", "handle_left_type", "handle_right_type")
    return {
        (curve.data_path, curve.array_index): [
            [tuple(each) if field.startswith(("co", "handle")) and "type" not in field else each for each in values]
            for field in fields
            for values in [[getattr(point, field) for point in curve.keyframe_points]]
        ]
        for curve in curves(action)
    }


def file_state():
    """Return what in-betweens could change in the file."""
    state = {action.name: dump(action) for action in bpy.data.actions}
    for thing in bpy.data.objects:
        animation = thing.animation_data
        if animation is not None and animation.action is not None:
            state[f"played by {thing.name}"] = (animation.action.name, animation.action_slot.identifier)
            state[f"of {thing.name}"] = {name: repr(thing[name]) for name in thing.keys() if name != "geodesic"}
    return state


class Layout:
    """A layout that checks what is drawn in it: properties and operators that are there."""

    def __init__(self):
        self.shown = []

    def prop(self, data, name, **options):
        getattr(data, name)
        assert name in data.bl_rna.properties
        self.shown.append(name)

    def operator(self, name, **options):
        group, _, own = name.partition(".")
        assert getattr(getattr(bpy.ops, group), own).get_rna_type()
        self.shown.append(name)

    def label(self, text="", icon="NONE"):
        assert icon in bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items

    def row(self, **options):
        return self

    column = row


def draw_panels():
    """Draw the panels into nothing, which is all that Blender without a window can do, and return what they show."""
    shown = []
    for name in ("in_betweens", "style", "metric"):
        panel, layout = getattr(bpy.types, f"GEODESIC_PT_{name}"), Layout()
        assert panel.poll(bpy.context)
        panel.draw(SimpleNamespace(layout=layout), bpy.context)
        shown += layout.shown
    return shown


def thin(armature, every):
    """Keep every n-th key of all curves."""
    for curve in curves(armature.animation_data.action):
        points = curve.keyframe_points
        for point in reversed(list(points)[:-1]):
            if round(point.co[0] - points[0].co[0]) % every:
                points.remove(point)


def set_mode(armature, bone, mode):
    """Bake the rotation keys of a bone into those of another rotation mode."""
    animation = armature.animation_data
    path = bone.path_from_id()
    all_curves = curves(animation.action)
    old = [all_curves.find(f"{path}.rotation_quaternion", index=i) for i in range(4)]
    frames = [point.co[0] for point in old[0].keyframe_points]
    values, before = [], None
    for i in range(len(frames)):
        bone.rotation_quaternion = [curve.keyframe_points[i].co[1] for curve in old]
        turn = bone.rotation_quaternion.normalized()
        if mode == "AXIS_ANGLE":
            # Blender's own conversion takes the arc cosine, which loses small angles
            length = math.hypot(turn.x, turn.y, turn.z)
            axis = (turn.x / length, turn.y / length, turn.z / length) if length else (0.0, 1.0, 0.0)
            values.append((2.0 * math.atan2(length, turn.w), *axis))
        else:
            before = turn.to_euler(mode) if before is None else turn.to_euler(mode, before)
            values.append(tuple(before))
    for curve in old:
        all_curves.remove(curve)
    bone.rotation_mode = mode
    name = "rotation_axis_angle" if mode == "AXIS_ANGLE" else "rotation_euler"
    for index in range(len(values[0])):
        curve = all_curves.new(f"{path}.{name}", index=index)
        for frame, value in zip(frames, values, strict=True):
            curve.keyframe_points.insert(frame, value[index])
