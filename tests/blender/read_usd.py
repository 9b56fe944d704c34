"""python read_usd.py IN.usda OUT.npz FRAMES.npy - what Blender shows of the armature of a USD file.

The arrays: names (B), parents (B), rotations (F, B, 3, 3) relative to the parent at the given frames, keys, the frames
of the curves' keys, scene, the scene's first and last frame, and properties, the armature's own ones as JSON.
"""

import json
import sys

import bpy
import numpy as np
from armatures import at_rest, key_frames, only_armature, parents_of, shown

source, out, frames = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=source, set_frame_range=True)
armature = only_armature()
bones = armature.data.bones
parents = parents_of(bones)
turns, _ = shown(armature, np.load(frames).tolist())
rest = at_rest(bones)
above = np.array([np.eye(3) if parent < 0 else rest[parent] for parent in parents])
scene = bpy.context.scene
np.savez(
    out,
    names=[bone.name for bone in bones],
    parents=parents,
    rotations=above.transpose(0, 2, 1) @ rest @ turns,
    keys=key_frames(armature),
    scene=[scene.frame_start, scene.frame_end],
    properties=json.dumps({name: str(value) for name, value in armature.data.items()}),
)
