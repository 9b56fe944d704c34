"""python run_extension.py ZIP PYTHON IN.usd FOLDER - fill an imported clip in every rotation mode, and take it back.

Written into FOLDER: filled.npz, with names (B), modes (B), frames (F), keys (K), rotations (F, B, 3, 3) and
translations (F, B, 3) from the parent; styled.usda, exported; and metric.json.
"""

import sys

import bpy
import numpy as np
from extension import MODULE, curves, dump, file_state, install, load, part, set_mode, thin
from mathutils import Matrix

archive, python, source, folder = sys.argv[1:]
install(archive, python)
armature = load(source)
thin(armature, 6)
modes = ("QUATERNION", "XYZ", "AXIS_ANGLE", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
for i, bone in enumerate(armature.pose.bones):
    if modes[i % len(modes)] != "QUATERNION":
        set_mode(armature, bone, modes[i % len(modes)])

bones, scene = armature.pose.bones, bpy.context.scene
animation = armature.animation_data
original = animation.action
untouched = dump(original)

# style: sliders set all selected bones together, and are mirrored by Blender's rules of names
for bone in bones:
    bone.bone.select = bone.name.endswith("_l")
left = next(bone for bone in bones if bone.bone.select)
left.geodesic_slider_alpha, left.geodesic_slider_beta = 2.5, 0.4
left.geodesic_slider_tension, left.geodesic_slider_side = 1.75, "right"
left.geodesic_slider_axes = (0.25, 0.5, -0.75)
assert bpy.ops.geodesic.mirror() == {"FINISHED"}
for bone in bones:
    side = bone.name[-2:]
    if side in ("_l", "_r"):
        sign = 1.0 if side == "_l" else -1.0
        assert bone["geodesic_alpha"] == 2.5 and bone["geodesic_side"] == "right", bone.name
        assert list(bone["geodesic_axes"]) == [0.25, sign * 0.5, -sign * 0.75], bone.name
        low, high = (bone.id_properties_ui("geodesic_tension").as_dict()[word] for word in ("min", "max"))
        assert (low, high) == (0.0, 2.0)
    else:
        assert "geodesic_alpha" not in bone
styled = file_state()
assert bpy.ops.geodesic.export_metric(filepath=f"{folder}/metric.json") == {"FINISHED"}

bpy.ops.ed.undo_push(message="styled")
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"}
result = animation.action
assert result != original and dump(original) == untouched
keys = sorted({point.co[0] for curve in curves(original) for point in curve.keyframe_points})
for curve in curves(result):
    points = {round(point.co[0], 3): point for point in curve.keyframe_points}
    for point in curves(original).find(curve.data_path, index=curve.array_index).keyframe_points:
        assert points.pop(round(point.co[0], 3)).co == point.co
    is_level = len({point.co[1] for point in curve.keyframe_points}) == 1
    assert {point.type for point in points.values()} == (set() if is_level else {"GENERATED"}), curve.data_path
frames = np.arange(keys[0], keys[-1] + 1)
rotations, translations = np.zeros((len(frames), len(bones), 3, 3)), np.zeros((len(frames), len(bones), 3))
for f, frame in enumerate(frames):
    scene.frame_set(int(frame))
    for b, bone in enumerate(bones):
        above = bone.parent.bone.matrix_local.inverted() if bone.parent else Matrix()
        local = np.array(above @ bone.bone.matrix_local @ bone.matrix_basis)
        rotations[f, b] = local[:3, :3] / np.linalg.norm(local[:3, :3], axis=0)
        translations[f, b] = local[:3, 3]
np.savez(
    f"{folder}/filled.npz",
    names=[bone.name for bone in bones],
    modes=[bone.rotation_mode for bone in bones],
    frames=frames,
    keys=keys,
    rotations=rotations,
    translations=translations,
)
bpy.ops.wm.usd_export(filepath=f"{folder}/styled.usda", export_armatures=True, export_animation=True)

# removing restores the file, and so does undoing, in one step
name, result_name, original_name = armature.name, result.name, original.name
assert bpy.ops.geodesic.remove() == {"FINISHED"} and file_state() == styled
bpy.ops.ed.undo_push(message="removed")
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"} and file_state() != styled
bpy.ops.ed.undo_push(message="filled")
bpy.ops.ed.undo()
assert file_state() == styled
bpy.ops.ed.redo()

# live: a changed key is followed, and one step of undo takes back both
live = part("live")
armature = bpy.data.objects[name]
armature.geodesic.live = True
live.update()
bpy.ops.ed.undo_push(message="live")
result = bpy.data.actions[result_name]
path = next(path for path, i in dump(result) if path.endswith("location") and len(dump(result)[path, 0][0]) > len(keys))
filled = dump(result)
key = next(point for point in curves(result).find(path, index=0).keyframe_points if point.co[0] == keys[1])
key.co[1] += 0.5
live.update()
moved = dump(result)
changes = [np.abs(np.array(moved[path, i][0]) - filled[path, i][0]).max() for i in range(3)]
assert abs(changes[0] - 0.5) < 1e-6 and max(changes[1:]) < 1e-6, changes
bpy.ops.ed.undo_push(message="moved")
for step, wanted in ((bpy.ops.ed.undo, filled), (bpy.ops.ed.redo, moved)):
    step()
    live.update()
    assert dump(bpy.data.actions[result_name]) == wanted

# and so is a slider
armature = bpy.data.objects[name]
armature.pose.bones[4].geodesic_slider_alpha = 9.0
live.update()
assert dump(bpy.data.actions[result_name]) != moved

# a pose that is keyed on a generated key becomes a key
result = bpy.data.actions[result_name]
bone = bpy.data.objects[name].pose.bones[1]
turn = bone.path_from_id("rotation_euler")
frame = round(keys[2]) + 1
bpy.context.scene.frame_set(frame)
bone.rotation_euler.x += 0.4
posed = bone.rotation_euler.x
bone.keyframe_insert("rotation_euler", frame=frame)
live.update()
for i in range(3):
    points = {round(point.co[0]): point for point in curves(result).find(turn, index=i).keyframe_points}
    assert points[frame].type == "KEYFRAME" and points[frame - 1].type == "KEYFRAME", i
    assert {points[frame + 1].type, points[frame + 2].type} == {"GENERATED"}
assert abs(dump(result)[turn, 0][0][frame - round(keys[0])][1] - posed) < 1e-6
bpy.ops.ed.undo()
bpy.ops.ed.redo()

# keys that were changed outlive the in-betweens, and the original is as it was
assert bpy.ops.geodesic.remove() == {"FINISHED"}
armature = bpy.data.objects[name]
assert armature.animation_data.action.name == result_name and dump(bpy.data.actions[original_name]) == untouched
values = np.array(dump(armature.animation_data.action)[path, 0][0]) - np.array(untouched[path, 0][0])
assert values[1, 1] == np.float32(0.5) or abs(values[1, 1] - 0.5) < 1e-6
assert np.count_nonzero(values) == 1
bpy.ops.preferences.addon_disable(module=MODULE)
