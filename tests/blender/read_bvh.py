"""python read_bvh.py IN.bvh OUT.npz - how Blender's own importer reads a BVH file.

The arrays: names (B), parents (B), rotations (F, B, 3, 3) relative to the parent in the file's axes, translations
(F, B, 3) in the file's unit, and rate, the scene's frames a second.
"""

import sys

import bpy
import numpy as np
from armatures import at_rest, key_frames, only_armature, parents_of, shown

source, out = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
# These axes make the importer leave the file's own alone.
bpy.ops.import_anim.bvh(filepath=source, rotate_mode="QUATERNION", axis_forward="Y", axis_up="Z", update_scene_fps=True)
armature = only_armature()
bones = armature.data.bones
turns, locations = shown(armature, key_frames(armature))
rest = at_rest(bones)
offsets = [bone.head_local - bone.parent.head_local if bone.parent else bone.head_local for bone in bones]
render = bpy.context.scene.render
np.savez(
    out,
    names=[bone.name for bone in bones],
    parents=parents_of(bones),
    # A pose turns a bone as seen from its rest, whose axes follow the bone.
    rotations=rest @ turns @ rest.transpose(0, 2, 1),
    translations=np.array(offsets) + np.einsum("bij,fbj->fbi", rest, locations),
    rate=render.fps / render.fps_base,
)
