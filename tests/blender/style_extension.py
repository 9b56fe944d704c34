"""python style_extension.py ZIP PYTHON LEARNED.usd LIBRARY FOLDER - metrics come and go, and what is locked stays.

LEARNED has dense samples and a metric, LIBRARY is of its rig. Written into FOLDER: found.json, the metric that Blender
found in it; learned.json and kept.json, what was learned from the baked motion and which frames were kept; again.usda,
exported with that; in_library.npz, what the library made of every 6th key: turns (4, F) of a bone, scalar first.
"""

import json
import os
import sys
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
from extension import MODULE, curves, draw_panels, dump, file_state, install, load, part, thin

archive, python, source, library, folder = sys.argv[1:]
install(archive, python)


def refused(operator, sentence, **arguments):
    """Check that an operator refuses with a sentence, and changes nothing."""
    before = file_state()
    try:
        operator(**arguments)
    except RuntimeError as error:
        assert sentence in str(error), error
    else:
        raise AssertionError(f"not refused: {sentence}")
    assert file_state() == before


# what a file brings: scheme, sliders and JSON
armature = load(source)
bones = armature.pose.bones
assert bpy.ops.geodesic.export_metric(filepath=f"{folder}/found.json") == {"FINISHED"}
found = json.load(open(f"{folder}/found.json"))
assert armature.geodesic.scheme == found["scheme"]
place = {joint.rsplit("/", 1)[-1]: i for i, joint in enumerate(found["joints"])}
words = {"alpha": "alpha", "beta": "beta", "tension": "tension", "side": "invariance"}
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"}
bpy.context.object.data.bones.active = bones[2].bone
assert len(draw_panels()) > 15
for bone in bones:
    for name, word in words.items():
        assert bone[f"geodesic_{name}"] == found[word][place[bone.name]], (bone.name, name)
assert bpy.ops.geodesic.remove() == {"FINISHED"}
original = armature.animation_data.action
baked = dump(original)

# selected keys alone are kept, whatever was baked between them; other bones stay
bone = bones[3]
turns = [curves(original).find(bone.path_from_id("rotation_quaternion"), index=i) for i in range(4)]
for each in bones:
    each.bone.select = False
for curve in curves(original):
    for point in curve.keyframe_points:
        point.select_control_point = False
frames = [point.co[0] for point in turns[0].keyframe_points]
kept = frames[2:-1:5]
for curve in turns:
    for point in curve.keyframe_points:
        point.select_control_point = point.co[0] in kept
before = file_state()
armature.geodesic.scope = "SELECTED"
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"}
result = armature.animation_data.action
for curve in curves(result):
    key = (curve.data_path, curve.array_index)
    if curve.data_path != turns[0].data_path:
        assert dump(result)[key] == baked[key]
        continue
    types = {point.co[0]: point.type for point in curve.keyframe_points}
    inside = [frame for frame in frames if kept[0] < frame < kept[-1] and frame not in kept]
    assert len(inside) > len(kept) and {types[frame] for frame in inside} == {"GENERATED"}
    assert {types[frame] for frame in types if frame not in inside} == {"KEYFRAME"}
assert bpy.ops.geodesic.remove() == {"FINISHED"} and file_state() == before
for curve in turns:
    for point in curve.keyframe_points:
        point.select_control_point = False
refused(bpy.ops.geodesic.in_betweens, "select two keys")
armature.geodesic.scope = "RANGE"

# learned from the baked motion
armature.geodesic.every = 8
assert bpy.ops.geodesic.learn() == {"FINISHED"}
assert bpy.ops.geodesic.export_metric(filepath=f"{folder}/learned.json") == {"FINISHED"}
learned = json.load(open(f"{folder}/learned.json"))
first, last = round(frames[0]), round(frames[-1])
json.dump([*range(first, last, 8), last], open(f"{folder}/kept.json", "w"))
bpy.ops.wm.usd_export(filepath=f"{folder}/again.usda", export_armatures=True, export_animation=True)

# JSON in and out, and what is none
bpy.ops.geodesic.import_metric(filepath=f"{folder}/found.json")
bpy.ops.geodesic.export_metric(filepath=f"{folder}/back.json")
assert open(f"{folder}/back.json").read() == open(f"{folder}/found.json").read()
for text, sentence in (("{", "not JSON"), ('{"format": "x"}', "not a metric"), ("[" * 100000, "not JSON")):
    open(f"{folder}/bad.json", "w").write(text)
    refused(bpy.ops.geodesic.import_metric, sentence, filepath=f"{folder}/bad.json")
found["alpha"][0] = -1.0
json.dump(found, open(f"{folder}/bad.json", "w"))
refused(bpy.ops.geodesic.import_metric, "no alpha", filepath=f"{folder}/bad.json")

# a library, for whole poses
thin(armature, 6)
armature.geodesic.scheme, armature.geodesic.library = "learned", library
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"}
keys = [curves(armature.animation_data.action).find(turns[0].data_path, index=i).keyframe_points for i in range(4)]
np.savez(f"{folder}/in_library.npz", turns=[[point.co[1] for point in each] for each in keys], bone=bone.name)
assert bpy.ops.geodesic.remove() == {"FINISHED"}

# some channels must stay: locked, muted, driven
armature.geodesic.scheme = "geodesic-spline"


def path(index, name):
    return bones[index].path_from_id(name)


def curve_of(data_path, index):
    return curves(original).find(data_path, index=index)


bones[1].lock_rotation[1] = True
bones[2].lock_location[2] = True
curve_of(path(4, "rotation_quaternion"), 0).lock = True
curve_of(path(5, "scale"), 1).mute = True
driver = armature.driver_add(path(6, "location"), 0)
driver.driver.expression = "0.25"
constraint = bones[7].constraints.new("COPY_ROTATION")
constraint.target, constraint.subtarget = armature, bones[0].name
stays = {(path(1, "rotation_quaternion"), i) for i in range(4)} | {
    (path(4, "rotation_quaternion"), i) for i in range(4)
}
stays |= {(path(2, "location"), 2), (path(5, "scale"), 1), (path(6, "location"), 0)}
# keys of some numbers only: the others stay, unless the turn needs them
hinge = bones[9]
for i in range(4):
    curves(original).remove(curve_of(path(9, "rotation_quaternion"), i))
hinge.rotation_mode, hinge.rotation_euler = "XYZ", (0.0, 0.0, 0.0)
spin = curves(original).new(path(9, "rotation_euler"), index=2)
for frame, angle in ((first, 0.0), (first + 7, 7.0), (last, 14.0)):
    spin.keyframe_points.insert(frame, angle)
# motion of the armature itself
root = curves(original).new("location", index=1)
for frame, value in ((first, 0.0), (first + 6, 1.0), (last, 3.0)):
    root.keyframe_points.insert(frame, value)
before = file_state()
sparse = dump(original)
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"}
result = armature.animation_data.action
filled = dump(result)
whole = {key for key, keys in filled.items() if len(keys[0]) == last - first + 1}
assert stays <= sparse.keys() and all(filled[key] == sparse[key] for key in stays)
level = {key for key, keys in sparse.items() if len({value for _, value in keys[0]}) == 1}
assert whole == filled.keys() - stays - level and all(filled[key] == sparse[key] for key in level)
assert (path(9, "rotation_euler"), 0) not in filled and ("location", 1) in whole
values = [value for _, value in filled[path(9, "rotation_euler"), 2][0]]
assert values[7] == 7.0 and values[-1] == 14.0 and all(abs(b - a) < 2.0 for a, b in pairwise(values))
assert bones[7].constraints[0].subtarget == bones[0].name and len(armature.animation_data.drivers) == 1
assert bpy.ops.geodesic.remove() == {"FINISHED"} and file_state() == before

# a metric that cannot be read is not passed over; schemes without tension do not forget it
good = armature["geodesicMetric"]
for holder in (armature, armature.data):
    holder["geodesicMetric"] = good.replace('"version": 1', '"version": 99')
refused(bpy.ops.geodesic.in_betweens, "remove that custom property")
for holder in (armature, armature.data):
    holder["geodesicMetric"] = good
bones[3].geodesic_slider_tension = 0.3
armature.geodesic.scheme = "geodesic"
assert bpy.ops.geodesic.in_betweens() == {"FINISHED"} and bpy.ops.geodesic.remove() == {"FINISHED"}
armature.geodesic.scheme = "geodesic-spline"
assert (bones[3]["geodesic_tension"], bones[3].geodesic_slider_tension) == (0.3, np.float32(0.3))

# without keys, library or process: sentences
armature.geodesic.scheme, armature.geodesic.library = "learned", ""
refused(bpy.ops.geodesic.in_betweens, "needs a library")
armature.geodesic.library = library
refused(bpy.ops.geodesic.in_betweens, "key all bones on the same frames")
armature.geodesic.library = f"{folder}/bad.json"
refused(bpy.ops.geodesic.in_betweens, "bad.json")
armature.geodesic.scheme = "slerp"
preferences = bpy.context.preferences.addons[MODULE].preferences
for nowhere, sentence in (("/nowhere/python", "cannot be started"), (sys.executable, "has no geomstats-anim")):
    os.environ.pop("PYTHONPATH", None)
    preferences.python = nowhere
    refused(bpy.ops.geodesic.in_betweens, sentence)
# the command on the PATH, or a link to it, leads to its Python
installed, linked = Path(folder, "env", "bin"), Path(folder, "bin")
for each in (installed, linked):
    each.mkdir(parents=True)
for name in ("python", "geomstats-anim"):
    (installed / name).touch(0o755)
(linked / "geomstats-anim").symlink_to(installed / "geomstats-anim")
preferences.python = ""
for path, found in ((linked, str((installed / "python").resolve())), (folder, None)):
    os.environ["PATH"] = str(path)
    assert part("preferences").python() == found
refused(bpy.ops.geodesic.in_betweens, "geomstats-anim is not found")
armature.animation_data.action = None
refused(bpy.ops.geodesic.in_betweens, "no action")

# what is linked from another file cannot be changed
bpy.ops.object.mode_set(mode="OBJECT")
bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/rig.blend", copy=True)
with bpy.data.libraries.load(f"{folder}/rig.blend", link=True) as (there, here):
    here.objects = [armature.name]
bpy.context.collection.objects.link(here.objects[0])
bpy.context.view_layer.objects.active = here.objects[0]
refused(bpy.ops.geodesic.in_betweens, "is linked from another file")
