"""Functions that the scripts of this folder share; they run in Blender's Python, without the project's packages."""

import bpy
import numpy as np


def only_armature():
    """The scene's armature, of which there must be one."""
    (armature,) = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    return armature


def parents_of(bones):
    """Index of each bone's parent, -1 for a root, shape=[B]."""
    place = {bone.name: i for i, bone in enumerate(bones)}
    return [place[bone.parent.name] if bone.parent else -1 for bone in bones]


def key_frames(armature):
    """Frames of the keys of all curves, increasing."""
    frames = set()
    for curve in armature.animation_data.action.fcurves:
        keys = np.zeros(2 * len(curve.keyframe_points))
        curve.keyframe_points.foreach_get("co", keys)
        frames.update(keys[::2].tolist())
    return sorted(frames)


def shown(armature, frames):
    """Return the pose at frames: rotation matrices (F, B, 3, 3) and locations (F, B, 3), as seen from rest."""
    bones = armature.data.bones
    quaternions, locations = np.zeros((len(frames), len(bones), 4)), np.zeros((len(frames), len(bones), 3))
    quaternions[..., 0] = 1.0
    arrays = {"rotation_quaternion": quaternions, "location": locations}
    for curve in armature.animation_data.action.fcurves:
        bone, _, channel = curve.data_path.removeprefix('pose.bones["').rpartition('"].')
        if channel in arrays:
            values = [curve.evaluate(frame) for frame in frames]
            arrays[channel][:, bones.find(bone), curve.array_index] = values
    return matrices(quaternions), locations


def matrices(quaternions):
    """Rotation matrices of quaternions (..., 4), scalar first, of any length."""
    w, x, y, z = np.moveaxis(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def at_rest(bones):
    """Rotation matrices (B, 3, 3) of the bones at rest, from bone to armature."""
    return np.array([np.array(bone.matrix_local.to_3x3()) for bone in bones])
