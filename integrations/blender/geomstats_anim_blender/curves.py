"""F-curves as arrays: their keys, with everything that Blender stores of a key."""

import re
from functools import cache

import bpy
import numpy as np
from bpy_extras.anim_utils import action_get_channelbag_for_slot

NEAR = 1e-3
"""Frames between keys that are at the same time."""

_FIELDS = {
    "co": (2, np.float32),
    "handle_left": (2, np.float32),
    "handle_right": (2, np.float32),
    "back": (1, np.float32),
    "amplitude": (1, np.float32),
    "period": (1, np.float32),
    "handle_left_type": (1, np.int32),
    "handle_right_type": (1, np.int32),
    "interpolation": (1, np.int32),
    "easing": (1, np.int32),
    "type": (1, np.int32),
    "select_control_point": (1, bool),
    "select_left_handle": (1, bool),
    "select_right_handle": (1, bool),
}
"""Numbers of a key, and how Blender stores them."""

_STOPS = np.cumsum([width for width, _ in _FIELDS.values()]).tolist()
COLUMNS = {name: slice(stop - _FIELDS[name][0], stop) for name, stop in zip(_FIELDS, _STOPS, strict=True)}
FRAME, VALUE = 0, 1
TYPE, INTERPOLATION, SELECTED = (COLUMNS[name].start for name in ("type", "interpolation", "select_control_point"))
BACK, PERIOD = (COLUMNS[name].start for name in ("back", "period"))
"""Columns of keys, which are arrays of shape=[K, 17]."""

_PATH = re.compile(r'(?:pose\.bones\["(?P<bone>.*)"\]\.)?(?P<name>location|scale|rotation_\w+)')


@cache
def number_of(field, word):
    """Return the number of a word, such as GENERATED among types of keys."""
    return bpy.types.Keyframe.bl_rna.properties[field].enum_items[word].value


def split_path(path):
    """Return the bone ("" for the object itself) and the property of a curve's path; None if it is another path."""
    found = _PATH.fullmatch(path)
    return found and (bpy.utils.unescape_identifier(found["bone"] or ""), found["name"])


def curves_of(action, slot):
    """Return the curves of a slot of an action, or None."""
    return None if action is None else getattr(action_get_channelbag_for_slot(action, slot), "fcurves", None)


def read_keys(curve, fields=tuple(_FIELDS)):
    """Return the keys of a curve, shape=[K, 17]; fields that are not asked for are 0."""
    points = curve.keyframe_points
    keys = np.zeros((len(points), _STOPS[-1]))
    for name in fields:
        width, kind = _FIELDS[name]
        values = np.empty(width * len(points), dtype=kind)
        points.foreach_get(name, values)
        keys[:, COLUMNS[name]] = values.reshape(-1, width)
    return keys


def write_keys(curve, keys, before=None):
    """Make keys those of a curve; what it has already, if that is known, is not written again."""
    points = curve.keyframe_points
    if len(points) != len(keys):
        before = None
        points.clear()
        points.add(len(keys))
    for name, (_, kind) in _FIELDS.items():
        values = keys[:, COLUMNS[name]]
        if before is None or not np.array_equal(values, before[:, COLUMNS[name]]):
            points.foreach_set(name, values.astype(kind).ravel())
    curve.update()


OWN_FIELDS = ("co", "type", "back", "period")
"""Fields that tell what is generated."""


def is_generated(keys):
    """Return which keys are as they were generated, shape=[K].

    They remember their frame and value in numbers that straight lines do not use: who sets a key on a generated one in
    Blender changes its value, but not its type.
    """
    unchanged = (keys[:, BACK] == keys[:, FRAME]) & (keys[:, PERIOD] == keys[:, VALUE])
    return unchanged & (keys[:, TYPE] == number_of("type", "GENERATED"))


def is_edited(keys):
    """Return which keys were generated and then changed, shape=[K]; keys that others have generated are not."""
    others = (keys[:, BACK] == _plain_key()[BACK]) & (keys[:, PERIOD] == _plain_key()[PERIOD])
    return (keys[:, TYPE] == number_of("type", "GENERATED")) & ~is_generated(keys) & ~others


def as_key(keys):
    """Return keys as Blender makes them by default, at the same frames and values."""
    new = np.tile(_plain_key(), (len(keys), 1))
    words = {"handle_left_type": "AUTO_CLAMPED", "handle_right_type": "AUTO_CLAMPED", "interpolation": "BEZIER"}
    for name, word in {**words, "type": "KEYFRAME"}.items():
        new[:, COLUMNS[name]] = number_of(name, word)
    for name in ("co", "handle_left", "handle_right", "select_control_point"):
        new[:, COLUMNS[name]] = keys[:, COLUMNS[name]]
    return new


def merged(one, other):
    """Return the keys of both, in the order of time."""
    both = np.concatenate([one, other])
    return both[np.argsort(both[:, FRAME], kind="stable")]


@cache
def _plain_key():
    """Return a generated key at 0 that leads on a straight line to the next."""
    key = np.zeros(_STOPS[-1])
    words = {"handle_left_type": "VECTOR", "handle_right_type": "VECTOR", "interpolation": "LINEAR"}
    for name, word in {**words, "easing": "AUTO", "type": "GENERATED"}.items():
        key[COLUMNS[name]] = number_of(name, word)
    # what Blender gives a new key
    for name, number in {"back": 1.70158, "amplitude": 0.8, "period": 4.1}.items():
        key[COLUMNS[name]] = np.float32(number)
    return key


def generated(frames, values):
    """Return generated keys at frames."""
    keys = np.tile(_plain_key(), (len(frames), 1))
    for name in ("co", "handle_left", "handle_right"):
        keys[:, COLUMNS[name]] = np.stack([frames, values], axis=-1).astype(np.float32)
    keys[:, [BACK, PERIOD]] = keys[:, [FRAME, VALUE]]
    return keys


def is_flat(keys, values):
    """Return whether a curve through keys is level, as values between them are, so that it needs no more keys."""
    heights = keys[:, [COLUMNS[name].stop - 1 for name in ("co", "handle_left", "handle_right")]]
    return len(keys) > 0 and not np.ptp(heights) and bool((values.astype(np.float32) == heights[0, 0]).all())


def is_at(frames, others):
    """Return which frames are at those of others, shape=[K]."""
    if not len(others):
        return np.zeros(len(frames), dtype=bool)
    if len(frames) == len(others) and np.array_equal(frames, others):
        return np.ones(len(frames), dtype=bool)
    others = np.sort(others)
    after = np.clip(np.searchsorted(others, frames), 1, max(1, len(others) - 1))
    nearest = np.minimum(
        np.abs(frames - others[np.minimum(after, len(others) - 1)]), np.abs(frames - others[after - 1])
    )
    return nearest <= NEAR


def distinct(frames):
    """Return frames, increasing, of those at the same time only the first."""
    frames = np.sort(frames)
    return frames[np.diff(frames, prepend=-np.inf) > NEAR]


class Scratch:
    """A curve that is not in the animation, to evaluate keys as Blender does."""

    def __enter__(self):
        """Make an action for it."""
        self._action = bpy.data.actions.new("scratch")
        slot = self._action.slots.new("OBJECT", "scratch")
        strip = self._action.layers.new("scratch").strips.new(type="KEYFRAME")
        self._curve = strip.channelbag(slot, ensure=True).fcurves.new("location", index=0)
        return self

    def __exit__(self, *error):
        """Take the action away."""
        bpy.data.actions.remove(self._action)

    def evaluated(self, keys, frames):
        """Return what keys come to at frames."""
        write_keys(self._curve, keys)
        return np.array([self._curve.evaluate(frame) for frame in frames])
