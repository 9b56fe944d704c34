"""python round_trip.py IN.usda OUT.usda - import a USD file into Blender, and export it again."""

import sys

import bpy

source, out = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=source, set_frame_range=True)
bpy.ops.wm.usd_export(filepath=out, export_armatures=True, export_animation=True)
