"""Channels of Blender's bones and objects as turns and paths, and back: rotations in any of its modes."""

from __future__ import annotations

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array
from usd_tools.skel.xform_motion import Codec, Parts, codec_of, turning

EULER = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
"""Orders of Blender's Euler angles: in XYZ, X turns first."""

WIDTHS = {"location": 3, "scale": 3, "QUATERNION": 4, "AXIS_ANGLE": 4, **dict.fromkeys(EULER, 3)}
"""Numbers of each channel at a key. Quaternions are (w, x, y, z), axis and angle (angle, x, y, z); radians."""

_OPS = {"location": "translate", "scale": "scale"}

_SAME_AXIS = 1e-5
"""Sine between axes that are the same."""

_ROUNDING = 1e-5
"""Radians; Blender's numbers are float32."""


def codec(channel: str, values: Array) -> Codec:
    """Choose how to interpolate a channel.

    A turn goes the short way from key to key, whatever numbers name it. Angles that leave the range in which they name
    turns say how far it goes: they are interpolated themselves.

    Parameters
    ----------
    channel : str
        One of `WIDTHS`.
    values : array-like, shape=[K, C]
        At the keys.

    Returns
    -------
    codec : Codec
    """
    if channel == "QUATERNION":
        return Codec(lambda keys: Parts.of(turns=quaternions(keys)), _join_quaternions)
    if channel == "AXIS_ANGLE":
        if _is_about_one_axis(values) and _spins(values[:, :1], 2.0 * np.pi, _from_axis_angle(values)):
            return Codec(lambda keys: Parts.of(path=keys[:, :1]), _join_spin)
        return Codec(lambda keys: Parts.of(turns=_from_axis_angle(keys)), _join_axis_angle)
    if channel in EULER:
        split, join = turning(channel.lower())
        if _spins(values, np.pi + 2.0 * _ROUNDING, split(np.degrees(values)).turns):
            return Codec(lambda keys: Parts.of(path=keys), lambda parts, keys, segment: parts.path)
        return Codec(
            lambda keys: split(np.degrees(keys)),
            lambda parts, keys, segment: np.radians(join(parts, np.degrees(keys), segment)),
        )
    plain = codec_of(_OPS[channel], values)
    assert plain is not None
    return plain


def quaternions(values: Array) -> Array:
    """Return unit quaternions (x, y, z, w) of Blender's (w, x, y, z), of any length; zeros are the identity."""
    turns = values[:, [1, 2, 3, 0]]
    zero: np.ndarray = ~np.any(turns, axis=-1)
    return quat.normalize(np.where(zero[:, None], quat.IDENTITY, turns))


def _join_quaternions(parts: Parts, keys: Array, segment: np.ndarray) -> Array:
    turns = parts.turns[:, [3, 0, 1, 2]]
    return turns * _signs(turns, keys[segment])


def _axes(values: Array) -> Array:
    """Return unit axes of (angle, x, y, z); Blender takes Y for an axis without length."""
    sizes = np.linalg.norm(values[:, 1:], axis=-1, keepdims=True)
    return np.where(sizes > 0.0, values[:, 1:] / np.where(sizes > 0.0, sizes, 1.0), [0.0, 1.0, 0.0])


def _from_axis_angle(values: Array) -> Array:
    return quat.exp(values[:, :1] * _axes(values))


def _is_about_one_axis(values: Array) -> bool:
    axes = _axes(values)
    same = np.linalg.norm(np.cross(axes, axes[0]), axis=-1) <= _SAME_AXIS
    return bool(same.all() and (axes @ axes[0] > 0.0).all())


def _spins(angles: Array, largest: float, turns: Array) -> bool:
    """Check that only angles tell which way it goes: they are too large to name turns, or a step is half a turn."""
    steps = np.abs(np.diff(angles, axis=0))
    is_beyond = np.abs(angles).max(initial=0.0) >= largest - _ROUNDING
    half_turns = quat.distance(turns[1:], turns[:-1]) >= np.pi - _ROUNDING
    return bool((is_beyond and (steps >= np.pi - _ROUNDING).any()) or half_turns.any())


def _join_spin(parts: Parts, keys: Array, segment: np.ndarray) -> Array:
    return np.concatenate([parts.path[:, :1], keys[segment, 1:]], axis=-1)


def _join_axis_angle(parts: Parts, keys: Array, segment: np.ndarray) -> Array:
    """Return axis and angle, of all names those nearest to the key before."""
    vectors = quat.log(parts.turns)
    angles = np.linalg.norm(vectors, axis=-1, keepdims=True)
    near = _axes(keys)[segment]
    axes = np.where(angles > 0.0, vectors / np.where(angles > 0.0, angles, 1.0), near)
    signs = _signs(axes, near)
    angles, before = signs * angles, keys[segment, :1]
    return np.concatenate([angles + 2.0 * np.pi * np.round((before - angles) / (2.0 * np.pi)), signs * axes], axis=-1)


def _signs(vectors: Array, near: Array) -> Array:
    """Return the signs, shape=[F, 1], with which vectors, shape=[F, C], are nearer to others."""
    return np.where((vectors * near).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
