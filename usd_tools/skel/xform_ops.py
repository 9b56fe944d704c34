"""Samples of one transform op, as numbers and as values of USD."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, Usd

from geomstats_anim.rotations import Array
from usd_tools.skel.channels import Channel, read_samples

_QUATERNIONS = (Gf.Quath, Gf.Quatf, Gf.Quatd)
_TYPES = (*_QUATERNIONS, Gf.Vec3h, Gf.Vec3f, Gf.Vec3d, Gf.Matrix4d, float)


def read_op(attribute: Usd.Attribute) -> Channel:
    """Read the samples of a transform op: one element, numbers in double precision, quaternions as (x, y, z, w)."""
    codes, raw, source = read_samples(attribute)
    blocked = np.array([not isinstance(value, _TYPES) for value in raw])
    live = [_numbers(value) for value, is_blocked in zip(raw, blocked, strict=True) if not is_blocked]
    values = np.zeros((len(codes), 1, len(live[0]) if live else 1))
    values[~blocked, 0] = live
    first = values[np.argmin(blocked)]
    return Channel(attribute.GetName(), np.array(codes), values, blocked, first, source)


def _numbers(value: Any) -> np.ndarray:
    if isinstance(value, _QUATERNIONS):
        return np.array([*value.imaginary, value.real], dtype=np.float64)
    return np.array(value, dtype=np.float64).ravel()


def op_values(attribute: Usd.Attribute, numbers: Array) -> list[Any]:
    """Turn numbers of an op, shape=[F, C], into values of its attribute."""
    make = type(attribute.GetTypeName().defaultValue)
    rows = numbers.tolist()
    if make in _QUATERNIONS:
        return [make(w, x, y, z) for x, y, z, w in rows]
    return [make(*row) for row in rows]
