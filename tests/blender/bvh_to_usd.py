"""python bvh_to_usd.py IN.bvh OUT.usda - import a BVH file into Blender, and export it as USD."""

import sys

import bpy
from armatures import key_frames, only_armature

source, out = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_anim.bvh(filepath=source, rotate_mode="QUATERNION", update_scene_fps=True)
frames = key_frames(only_armature())
bpy.context.scene.frame_start, bpy.context.scene.frame_end = int(frames[0]), int(frames[-1])
bpy.ops.wm.usd_export(filepath=out, export_armatures=True, export_animation=True)
