"""The working copy: an action beside the original, which holds its keys and what is generated between them.

The copy has a custom property with notes, as JSON, for each track that was filled:

range            first and last frame; None for the whole of what was chosen
frames           frames of the keys that were chosen; None for all keys
before, after    how many keys before and after those were not
rest             values of numbers without a curve, by index
"""

import json
from dataclasses import dataclass

import bpy
import numpy as np

from . import curves as fc
from . import tracks as tr

NOTES = "geodesic_in_betweens"


@dataclass
class Copy:
    """An open working copy: its action and slot, and those of the original."""

    action: bpy.types.Action
    slot: bpy.types.ActionSlot
    source: bpy.types.Action
    source_slot: bpy.types.ActionSlot

    def __post_init__(self):
        """Look up the original's curves."""
        originals = fc.curves_of(self.source, self.source_slot)
        self._originals = {(each.data_path, each.array_index): each for each in originals}

    @property
    def curves(self):
        """Return the curves of the copy."""
        return fc.curves_of(self.action, self.slot)

    @property
    def notes(self):
        """Return the notes, by key of track."""
        try:
            notes = json.loads(self.action[NOTES])
        except (KeyError, TypeError, ValueError):
            return {}
        return notes if isinstance(notes, dict) else {}

    def write_notes(self, notes):
        """Write the notes."""
        self.action[NOTES] = json.dumps(notes)

    def restored_keys(self, curve, own, note):
        """Return the keys of a curve that are not ours, and those of the original that were replaced."""
        key = (curve.data_path, curve.array_index)
        original = None if note is None or note["frames"] is None else self._originals.get(key)
        if original is None:
            return own
        theirs, kept = fc.read_keys(original), np.array(note["frames"])
        frames = theirs[:, fc.FRAME]
        replaced = (frames > kept[0]) & (frames < kept[-1]) & ~fc.is_at(frames, kept)
        return fc.merged(own, theirs[replaced & ~fc.is_at(frames, own[:, fc.FRAME])])

    @property
    def is_changed(self):
        """Return whether the copy's curves have other keys than the original's."""
        curves = {(each.data_path, each.array_index): fc.read_keys(each, ("co",)) for each in self.curves}
        if curves.keys() != self._originals.keys():
            return True
        return any(
            not np.array_equal(keys, fc.read_keys(self._originals[key], ("co",))) for key, keys in curves.items()
        )


def opened(armature):
    """Return the working copy that an armature plays, or None."""
    settings, animation = armature.geodesic, armature.animation_data
    if animation is None or animation.action is None or animation.action_slot is None:
        return None
    if animation.action != settings.result or settings.source is None or NOTES not in settings.result:
        return None
    source_slot = settings.source.slots.get(settings.source_slot)
    return None if source_slot is None else Copy(animation.action, animation.action_slot, settings.source, source_slot)


def make(armature):
    """Copy the action that an armature plays, and play the copy. There must be one, with a slot."""
    settings, animation = armature.geodesic, armature.animation_data
    source, identifier = animation.action, animation.action_slot.identifier
    copy = source.copy()
    copy.name = f"{source.name} in-betweens"
    copy[NOTES] = "{}"
    settings.source, settings.result, settings.source_slot = source, copy, identifier
    _play(armature, copy, identifier)
    return opened(armature)


def discard(armature, copy):
    """Play the original again, and take the copy away."""
    identifier = copy.source_slot.identifier
    _forget(armature)
    _play(armature, copy.source, identifier)
    bpy.data.actions.remove(copy.action)


def remove(armature, copy):
    """Take what is generated away, and return a sentence that says what was done.

    If the keys are those of the original, that plays again and the copy is gone. Keys that were changed stay in the
    copy, with all that was replaced.
    """
    notes = copy.notes
    for channel, curves in tr.channels(copy.curves).items():
        own = tr.own_keys({index: fc.read_keys(curve) for index, curve in curves.items()})
        for index, curve in curves.items():
            keys = copy.restored_keys(curve, own[index], notes.get("\n".join(channel)))
            if len(keys):
                fc.write_keys(curve, keys)
            else:
                copy.curves.remove(curve)
    name, source = copy.action.name, copy.source.name
    if copy.is_changed:
        _forget(armature)
        del copy.action[NOTES]
        return f"Removed the in-betweens; the changed keys stay in {name}, and {source} is as it was."
    discard(armature, copy)
    return f"Removed {name}; {source} plays again."


def _play(armature, action, identifier):
    armature.animation_data.action = action
    armature.animation_data.action_slot = action.slots[identifier]


def _forget(armature):
    for name in ("result", "source", "source_slot", "live"):
        armature.geodesic.property_unset(name)
