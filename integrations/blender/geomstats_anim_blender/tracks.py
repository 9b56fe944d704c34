"""Channels that are interpolated: those of bones, and of the armature itself, that have keys and may be changed."""

from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Vector

from . import curves as fc
from . import style

OBJECT = ""
"""In place of a bone's name."""

ROTATIONS = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
"""Properties of rotation modes; the others are Euler angles."""

WHOLE = tuple(ROTATIONS)
"""Modes in which four numbers are one rotation, which is left alone if one of them is locked or driven."""


@dataclass
class Track:
    """One channel of a bone or of the armature.

    frames and values are those of its keys, shape=[K] and shape=[K, C]; wanted are the frames between them. By index of
    its curves, before are all keys, own those that are not generated, and rest the values of numbers without a curve.
    free are the indices that may be written, none where the channel is left alone.
    """

    bone: str
    name: str
    mode: str
    path: str
    curves: dict
    before: dict
    own: dict
    free: list
    frames: np.ndarray = None
    values: np.ndarray = None
    wanted: np.ndarray = None
    rest: dict = field(default_factory=dict)

    @property
    def key(self):
        """Return what names it in the notes of a working copy."""
        return f"{self.bone}\n{self.name}"


def found_tracks(armature, copy):
    """Return the tracks of an armature's action.

    Parameters
    ----------
    armature : bpy.types.Object
    copy : working_copy.Copy
        Or anything with curves.

    Returns
    -------
    tracks : list of Track
        Those that must be left alone have no free numbers.
    """
    driven = {(each.data_path, each.array_index) for each in armature.animation_data.drivers}
    tracks = []
    for (bone, name), curves in channels(copy.curves).items():
        owner = owner_of(armature, bone)
        if owner is None or (name.startswith("rotation") and name != rotation_of(owner)):
            continue
        mode = owner.rotation_mode if name.startswith("rotation") else name
        path = next(iter(curves.values())).data_path
        before = {index: fc.read_keys(curve) for index, curve in curves.items()}
        track = Track(bone, name, mode, path, curves, before, {}, _free(owner, name, mode, curves, driven))
        track.own = own_keys(before)
        tracks.append(track)
    return tracks


def channels(curves):
    """Return curves by bone and property, and then by index."""
    found = {}
    for curve in curves:
        channel = fc.split_path(curve.data_path)
        if channel is not None:
            found.setdefault(channel, {})[curve.array_index] = curve
    return found


def own_keys(keys):
    """Return the keys of a channel's curves, by index, that are not generated.

    Where a generated key was changed, the others of that frame belong to it: they are one pose.
    """
    edited = [each[fc.is_edited(each), fc.FRAME] for each in keys.values()]
    if not any(map(len, edited)):
        return {index: each[~fc.is_generated(each)] for index, each in keys.items()}
    frames, own = np.concatenate(edited), {}
    for index, each in keys.items():
        is_new = fc.is_at(each[:, fc.FRAME], frames) & (each[:, fc.TYPE] == fc.number_of("type", "GENERATED"))
        kept = ~fc.is_generated(each) & ~is_new
        own[index] = fc.merged(each[kept], fc.as_key(each[is_new]))
    return own


def owner_of(armature, bone):
    """Return the pose bone of a name, or None; of `OBJECT` the armature."""
    return armature if bone == OBJECT else armature.pose.bones.get(bone)


def rotation_of(owner):
    """Return the property in which a bone or an object keeps its rotation."""
    return ROTATIONS.get(owner.rotation_mode, "rotation_euler")


def _free(owner, name, mode, curves, driven):
    """Return the indices of a channel that are neither locked nor driven nor muted."""
    width = len(getattr(owner, name))
    path = next(iter(curves.values())).data_path
    free = []
    for index in range(width):
        curve = curves.get(index)
        locked = _is_locked(owner, name, index, mode)
        closed = curve is not None and (curve.lock or curve.mute or bool(curve.group and curve.group.lock))
        if not (locked or closed or (path, index) in driven):
            free.append(index)
    return free if mode not in WHOLE or len(free) == width else []


def _is_locked(owner, name, index, mode):
    """Return whether the owner's lock is on a number."""
    if not name.startswith("rotation"):
        return getattr(owner, f"lock_{name}")[index]
    if mode not in WHOLE:
        return owner.lock_rotation[index]
    # w is locked by a switch of its own, and only where the four have their own
    return owner.lock_rotations_4d and owner.lock_rotation_w if index == 0 else owner.lock_rotation[index - 1]


def pose(armature, track, frames, scratch):
    """Return the values of a track at frames, shape=[K, C], as its own keys have them; see `Track`."""
    owner = owner_of(armature, track.bone)
    values = np.tile(np.array(getattr(owner, track.name), dtype=np.float64), (len(frames), 1))
    for index, constant in track.rest.items():
        values[:, index] = constant
    for index, own in track.own.items():
        at, known = own[:, fc.FRAME], own[:, fc.VALUE]
        if not len(at):
            continue
        if len(at) == len(frames) and np.abs(at - frames).max(initial=0.0) <= fc.NEAR:
            values[:, index] = known
        else:
            values[:, index] = scratch.evaluated(own, frames)
            there = fc.is_at(frames, at)
            values[there, index] = known[np.abs(at - frames[there, None]).argmin(axis=1)]
    return values


def rest_of(armature):
    """Return the rest pose of the bones from their parents: quaternion (x, y, z, w) and place, shape=[B, 7]."""
    rows = []
    for bone in style.bones_of(armature):
        own = bone.bone.matrix_local
        matrix = own if bone.parent is None else bone.parent.bone.matrix_local.inverted() @ own
        w, x, y, z = matrix.to_quaternion()
        rows.append([x, y, z, w, *matrix.translation])
    return np.array(rows).reshape(-1, 7)


def rig_of(armature):
    """Return what a request says of an armature: a header and arrays."""
    bones = style.bones_of(armature)
    place = {bone.name: i for i, bone in enumerate(bones)}
    scale = bpy.context.scene.unit_settings.scale_length * armature.matrix_world.median_scale
    up = armature.matrix_world.to_3x3().inverted_safe() @ Vector((0.0, 0.0, 1.0))
    document = style.document_of(armature)
    header = {
        "joints": document["joints"],
        "parents": [place[bone.parent.name] if bone.parent else -1 for bone in bones],
        "metric": document,
        "metres": scale if scale > 0.0 else 1.0,
        "up": list(up.normalized()),
        "library": bpy.path.abspath(armature.geodesic.library) or None,
    }
    return header, {"rest": rest_of(armature)}, place
