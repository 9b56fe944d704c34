"""Samples that are no values: numbers that are not finite, quaternions of no length; filled in, and remembered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geomstats_anim.faults import fill
from geomstats_anim.rotations import IDENTITY
from geomstats_anim.spaces import Points, Space, Turns
from usd_tools.console.errors import ToolError
from usd_tools.console.text import short_names
from usd_tools.skel.channels import Channel

NO_LENGTH = 1e-6
"""A quaternion that is shorter has no direction, so it is no rotation."""


class Gaps(NamedTuple):
    """Hold what is missing in a channel.

    Attributes
    ----------
    where : array-like of bool, shape=[K, N]
        Which elements were filled in.
    values : array-like, shape=[M, C]
        What the file has there, in the same order.
    """

    where: np.ndarray
    values: np.ndarray


def has_no_length(quaternions: np.ndarray) -> np.ndarray:
    """Return whether quaternions, shape=[..., 4], are no rotations, shape=[...]."""
    return np.linalg.norm(quaternions.astype(np.float64), axis=-1) < NO_LENGTH


def turns_of_no_length(channel: Channel) -> np.ndarray:
    """Return which rotations, shape=[K, N], are quaternions of no length, of joints that move."""
    none = (channel.squares < NO_LENGTH**2) & ~channel.blocked[:, None]
    return none & ~channel.holds.all(axis=0) if none.any() else none


def space_of(name: str, unit: float = 1.0) -> Space:
    """Return how values of a channel are compared; `unit` is of those that are no rotations."""
    return Turns() if name == "rotations" else Points(unit)


def fill_gaps(
    path: str, joints: Sequence[str], channels: Mapping[str, Channel], notes: list[str]
) -> tuple[dict[str, Channel], dict[str, Gaps]]:
    """Fill in what is missing in channels, between the samples beside it.

    Parameters
    ----------
    path : str
        Of the animation.
    joints : sequence of str, shape=[N]
    channels : mapping of str to Channel
    notes : list of str
        Told of weights of blend shapes that are left, as no sample of one of them is a value.

    Returns
    -------
    channels : dict of str to Channel
    gaps : dict of str to Gaps
        Of those that have any.

    Raises
    ------
    ToolError
        If a joint has no sample at all that is a value.
    """
    filled, gaps = dict(channels), {}
    for name, channel in channels.items():
        where = ~channel.is_finite
        if name == "rotations":
            where |= turns_of_no_length(channel)
        if not where.any():
            continue
        live = ~channel.blocked
        lost = np.flatnonzero(where[live].all(axis=0))
        if len(lost):
            if name != "blendShapeWeights":
                joint = short_names(joints)[joints[lost[0]]]
                raise ToolError(f"{path}: {name} of joint {joint} have no sample that is a number; repair the file.")
            notes.append(f"{path}: {name} have no number for a shape; the weights are left as they are.")
            del filled[name]
            continue
        values = channel.values.copy()
        # what is filled in goes on, where a joint is at rest beside a gap it is no rotation, too
        good = np.where(has_no_length(values)[..., None], IDENTITY, values) if name == "rotations" else values
        values[live] = fill(good[live].astype(values.dtype), channel.codes[live], space_of(name), where[live])
        values[~where] = channel.values[~where]
        gaps[name] = Gaps(where, channel.values[where])
        filled[name] = replace(channel, values=values, default=values[np.flatnonzero(live)[0]])
    return filled, gaps
