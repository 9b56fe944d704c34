"""Learning a metric from baked motion."""

from types import SimpleNamespace

import numpy as np

from . import curves as fc
from . import fill, service, style, working_copy
from . import tracks as tr


def request(armature):
    """Return the request for a metric learned from an armature's motion: all its frames, and the keys to keep."""
    fill.check_action(armature)
    copy, animation, settings = working_copy.opened(armature), armature.animation_data, armature.geodesic
    action, slot = (animation.action, animation.action_slot) if copy is None else (copy.source, copy.source_slot)
    # what was baked is the truth, not what was made from it
    baked = SimpleNamespace(curves=fc.curves_of(action, slot) or ())
    tracks = tr.found_tracks(armature, baked)
    tracks = [track for track in tracks if track.bone != tr.OBJECT and track.name != "scale"]
    if not tracks:
        raise fill.FillError(f"{armature.name} has no bone with keys, so there is nothing to learn from.")
    ends = [keys[[0, -1], fc.FRAME] for track in tracks for keys in track.own.values() if len(keys)]
    frames = np.arange(np.ceil(np.min(ends)), np.floor(np.max(ends)) + 1.0)
    with fc.Scratch() as scratch:
        values = [tr.pose(armature, track, frames, scratch) for track in tracks]
    kept = _kept(armature, frames)
    if len(kept) == len(frames):
        raise fill.FillError("All frames are kept, so there is nothing to learn from; keep fewer.")
    header, arrays, place = tr.rig_of(armature)
    header |= {
        "request": "learn",
        "settings": {"purpose": settings.purpose.lower(), "family": settings.family.lower()},
        "groups": [[[place[track.bone], track.mode] for track in tracks]],
    }
    arrays |= {"0/times": frames * fill.frame_seconds(), "0/wanted": np.zeros(0), "keys": kept}
    return header, arrays | {f"0/{i}": each for i, each in enumerate(values)}


def _kept(armature, frames):
    """Return the indices of the frames that are kept, with both ends."""
    settings, animation = armature.geodesic, armature.animation_data
    if settings.keep == "EVERY":
        return np.union1d(np.arange(0, len(frames), settings.every), len(frames) - 1)
    picked = []
    for curve in fc.curves_of(animation.action, animation.action_slot) or ():
        keys = fc.read_keys(curve, ("co", "select_control_point"))
        picked.append(keys[keys[:, fc.SELECTED] > 0.0, fc.FRAME])
    kept = np.flatnonzero(fc.is_at(frames, np.concatenate(picked))) if picked else np.zeros(0, dtype=int)
    if len(kept) < 2:
        raise fill.FillError("Select the keys to keep in the dope sheet, two or more, or keep every n-th frame.")
    return np.union1d(kept, [0, len(frames) - 1])


def take(armature, answer):
    """Give the armature the metric that was learned, and return a sentence."""
    document = answer["metric"]
    style.take(armature, document)
    scores = document["provenance"]
    return f"Learned from {armature.name}: Q {scores['score']:.4g}, slerp {scores['slerp_score']:.4g}."


def learn(armature, progress=lambda text: None):
    """Learn a metric, and return a sentence; see `request`."""
    answer, _ = service.ask(*request(armature), progress)
    return take(armature, answer)
