"""In-betweens of an armature: which keys and frames, the request, and the keys that are generated."""

from dataclasses import dataclass

import bpy
import numpy as np

from . import curves as fc
from . import service, style, working_copy
from . import tracks as tr

_STAYS = 1e-6
"""Largest distance of a number without a curve from its value before it gets one."""


class FillError(Exception):
    """Error that one sentence says."""


@dataclass
class Filled:
    """Record of what was done.

    Parameters
    ----------
    channels, frames : int
        Channels with in-betweens, and how many there are in the fullest.
    notes : list of str
    """

    channels: int
    frames: int
    notes: list

    def __str__(self):
        """Say it in one sentence."""
        return f"{self.frames} in-betweens in {self.channels} channels." if self.frames else "No frame is between keys."


def fill(armature, scope=None):
    """Put in-betweens between the keys of an armature, in a working copy of its action.

    Parameters
    ----------
    armature : bpy.types.Object
    scope : str
        "RANGE": all keys, and the frames of the scene. "SELECTED": the selected keys, and all frames between them.
        What was filled before starts anew.
        Optional, default: None, once more what was filled before, between the keys that are there now.

    Returns
    -------
    filled : Filled

    Raises
    ------
    FillError, ServiceError, StyleError
        If it cannot be done; nothing has changed.
    """
    check_action(armature)
    copy = working_copy.opened(armature)
    is_new = copy is None
    if is_new:
        copy = working_copy.make(armature)
    try:
        tracks, notes = plan(armature, copy, scope)
        if not tracks and scope is not None:
            raise FillError(_nothing(armature, scope))
        style.adopt(armature)
        results, told = asked(armature, tracks)
    except (FillError, service.ServiceError):
        if is_new:
            working_copy.discard(armature, copy)
        raise
    style.store(armature)
    copy.write_notes(notes)
    for track, values in zip(tracks, results, strict=True):
        _write(track, values, copy.curves)
    copy.action.update_tag()
    armature.update_tag()
    return Filled(len(tracks), max((len(track.wanted) for track in tracks), default=0), told)


def check_action(armature):
    """Refuse an armature without an action of its own, or with a metric that cannot be read."""
    animation = armature.animation_data
    if not armature.is_editable:
        raise FillError(f"{armature.name} is linked from another file; make a library override of it.")
    if animation is None or animation.action is None or animation.action_slot is None:
        raise FillError(f"{armature.name} has no action, so there are no keys to go between.")
    if animation.use_tweak_mode:
        raise FillError(f"{armature.name} tweaks a strip; leave the tweak mode of the NLA editor.")
    style.check(armature)


def _nothing(armature, scope):
    if scope == "SELECTED":
        return "In-betweens go between selected keys; select two keys of a bone or more in the dope sheet."
    return f"{armature.name} has no channel with two keys that may be changed."


def plan(armature, copy, scope):
    """Return the tracks that get in-betweens, with their keys, and the notes of the copy afterwards."""
    notes, chosen = copy.notes, []
    with fc.Scratch() as scratch:
        for track in tr.found_tracks(armature, copy):
            if scope is not None:
                for index, curve in track.curves.items():
                    track.own[index] = copy.restored_keys(curve, track.own[index], notes.get(track.key))
            note = notes.get(track.key) if scope is None else _noted(armature, track, notes.get(track.key), scope)
            if note is not None and track.free and _place_keys(armature, track, note, scope, scratch):
                notes[track.key] = note
                chosen.append(track)
    return chosen, notes


def _noted(armature, track, before, scope):
    """Return the note of a track, or None if it is not in the scope."""
    settings, owner = armature.geodesic, tr.owner_of(armature, track.bone)
    if settings.only_selected_bones and (track.bone == tr.OBJECT or not style.is_selected(owner)):
        return None
    rest = {str(i): float(value) for i, value in enumerate(getattr(owner, track.name)) if i not in track.curves}
    rest |= {} if before is None else before["rest"]
    if scope == "RANGE":
        return {"range": _frame_range(), "frames": None, "before": 0, "after": 0, "rest": rest}
    frames, picked = _frames(track.own), _frames(_selected(track))
    if len(picked) < 2:
        return None
    n_before, n_after = (int(side.sum()) for side in (frames < picked[0] - fc.NEAR, frames > picked[-1] + fc.NEAR))
    return {"range": None, "frames": picked.tolist(), "before": n_before, "after": n_after, "rest": rest}


def _frame_range():
    scene = bpy.context.scene
    if scene.use_preview_range:
        return [scene.frame_preview_start, scene.frame_preview_end]
    return [scene.frame_start, scene.frame_end]


def _selected(track):
    return {index: keys[keys[:, fc.SELECTED] > 0.0] for index, keys in track.own.items()}


def _frames(own):
    """Return the frames of the keys of all curves of a track."""
    return fc.distinct(np.concatenate([keys[:, fc.FRAME] for keys in own.values()]))


def _place_keys(armature, track, note, scope, scratch):
    """Find the keys of a track and the frames between them; return whether there are two keys."""
    track.rest = {int(index): value for index, value in note["rest"].items()}
    if scope == "SELECTED":
        frames = np.array(note["frames"])
    else:
        frames = _frames(track.own)
        frames = frames[note["before"] : len(frames) - note["after"]]
    if len(frames) < 2:
        return False
    track.frames, track.values = frames, tr.pose(armature, track, frames, scratch)
    for index, keys in track.own.items():
        at = keys[:, fc.FRAME]
        is_inside = (at > frames[0]) & (at < frames[-1])
        track.own[index] = keys[~is_inside | fc.is_at(at, frames)]
    first, last = note["range"] or frames[[0, -1]]
    start = max(int(np.searchsorted(frames, first + fc.NEAR)) - 1, 0)
    stop = min(int(np.searchsorted(frames, last - fc.NEAR)), len(frames) - 1)
    whole = np.arange(np.ceil(frames[start]), np.floor(frames[stop]) + 1.0) if start < stop else np.zeros(0)
    track.wanted = whole[~fc.is_at(whole, frames)]
    return True


def asked(armature, tracks):
    """Return the values of tracks at their wanted frames, and notes, from the process."""
    header, arrays, place = tr.rig_of(armature)
    seconds = frame_seconds()
    groups = {}
    for track in tracks:
        groups.setdefault((track.frames.tobytes(), track.wanted.tobytes()), []).append(track)
    header |= {"request": "in-betweens", "groups": []}
    names = {}
    for g, group in enumerate(groups.values()):
        arrays |= {f"{g}/times": group[0].frames * seconds, f"{g}/wanted": group[0].wanted * seconds}
        header["groups"].append([[place.get(track.bone, -1), track.mode] for track in group])
        for i, track in enumerate(group):
            arrays[f"{g}/{i}"], names[id(track)] = track.values, f"{g}/{i}"
    answer, numbers = service.ask(header, arrays)
    return [numbers[names[id(track)]] for track in tracks], answer["notes"]


def frame_seconds():
    """Return the seconds from frame to frame."""
    render = bpy.context.scene.render
    return render.fps_base / render.fps


def _write(track, values, curves):
    """Write a track's generated keys beside its own."""
    breaks = _breaks(track, values)
    constant = fc.number_of("interpolation", "CONSTANT")
    for index in track.free:
        own, curve = track.own.get(index), track.curves.get(index)
        if curve is None:
            both = np.concatenate([track.values[:, index], values[:, index]])
            if np.abs(both - track.rest[index]).max(initial=0.0) <= _STAYS:
                continue
            curve = curves.new(track.path, index=index)
            own = fc.generated(np.zeros(0), np.zeros(0))
        if fc.is_flat(own, values[:, index]):
            fc.write_keys(curve, own, track.before[index])
            continue
        between = fc.generated(track.wanted, values[:, index])
        between[breaks, fc.INTERPOLATION] = constant
        missing = ~fc.is_at(track.frames, own[:, fc.FRAME])
        between = np.concatenate([between, fc.generated(track.frames[missing], track.values[missing, index])])
        fc.write_keys(curve, fc.merged(own, between), track.before.get(index))


def _breaks(track, values):
    """Return which frames, shape=[F], are held as the next key names its rotation otherwise: lines would go round."""
    after = np.searchsorted(track.frames, track.wanted)
    is_last = np.append(after[1:] != after[:-1], True)[: len(after)]
    if track.mode in ("location", "scale"):
        return np.zeros(len(after), dtype=bool)
    keys = track.values[np.minimum(after, len(track.frames) - 1)]
    if track.mode == "QUATERNION":
        jumps = (keys * values).sum(axis=-1) < 0.0
    else:
        jumps = (np.abs(keys - values) > np.pi).any(axis=-1)
    return is_last & jumps
