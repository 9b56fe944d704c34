"""Requests, checked: the rig, its metric, and tracks of keys."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geomstats_anim import LearnedMetric, Skeleton
from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array
from usd_tools.console.errors import ToolError
from usd_tools.serving.channels import WIDTHS

OBJECT = -1
"""Index of what carries all bones, in place of a joint's: its motion has the bi-invariant metric."""


@dataclass(frozen=True)
class Track:
    """One channel of one joint.

    Parameters
    ----------
    joint : int
        Index among those of the rig, or `OBJECT`.
    channel : str
        One of `WIDTHS`, such as "location" or "XYZ".
    values : array-like, shape=[K, C]
        At the keys.
    """

    joint: int
    channel: str
    values: Array

    @property
    def turns(self) -> bool:
        """Return whether it is a rotation."""
        return self.channel not in ("location", "scale")


@dataclass(frozen=True)
class Group:
    """Tracks whose keys are at the same times.

    Parameters
    ----------
    times, wanted : array-like, shape=[K], shape=[F]
        Seconds of the keys, and of what is between them.
    tracks : tuple of Track
    """

    times: Array
    wanted: Array
    tracks: tuple[Track, ...]

    @property
    def poses(self) -> bool:
        """Return whether it turns joints."""
        return any(track.turns and track.joint != OBJECT for track in self.tracks)


@dataclass(frozen=True)
class Rig:
    """Bones, their rest pose and their metric.

    Parameters
    ----------
    skeleton : Skeleton
        Metres.
    metric : LearnedMetric
        For its joints, with the scheme.
    metres : float
        Metres of a unit of location.
    """

    skeleton: Skeleton
    metric: LearnedMetric
    metres: float

    @classmethod
    def of(cls, header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Rig:
        """Take the rig of a request."""
        metres = float(header["metres"])
        if not 0.0 < metres < np.inf:
            raise ToolError(f"metres must be a positive number, not {metres:g}.")
        rest = arrays["rest"]  # (x, y, z, w) and a place, relative to the parent
        if rest.ndim != 2 or rest.shape[1] != 7:
            raise ToolError(f"The rest pose has the shape {rest.shape}, but (B, 7) is needed.")
        turns = quat.normalize(rest[:, :4])
        skeleton = Skeleton(header["joints"], header["parents"], metres * rest[:, 4:], turns)
        metric = LearnedMetric.from_json(json.dumps(header["metric"]))
        return cls(skeleton, metric.for_joints(skeleton.joints)[0], metres)


def groups_of(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray], rig: Rig) -> list[Group]:
    """Take the tracks of a request; those of group 2 have arrays named 2/times, 2/wanted, 2/0, 2/1."""
    found = []
    for g, tracks in enumerate(header["groups"]):
        times, wanted = arrays[f"{g}/times"], arrays[f"{g}/wanted"]
        group = Group(times, wanted, tuple(_track(t, arrays[f"{g}/{i}"], rig) for i, t in enumerate(tracks)))
        if not all(len(track.values) == len(times) for track in group.tracks):
            raise ToolError(f"The tracks of group {g} have not {len(times)} keys each.")
        if len(wanted) and len(times) and not (times[0] <= wanted[0] and wanted[-1] <= times[-1]):
            raise ToolError(f"The times of group {g} are not all between its keys.")
        found.append(group)
    return found


def _track(entry: Any, values: np.ndarray, rig: Rig) -> Track:
    joint, channel = entry
    if type(joint) is not int or not OBJECT <= joint < rig.skeleton.n_joints:
        raise ToolError(f"There is no joint {joint!r}.")
    if channel not in WIDTHS:
        raise ToolError(f"There is no channel {channel!r}; the channels are {', '.join(WIDTHS)}.")
    if values.ndim != 2 or values.shape[1] != WIDTHS[channel] or not np.isfinite(values).all():
        raise ToolError(f"A track of {channel} needs {WIDTHS[channel]} finite numbers for each key.")
    return Track(joint, channel, values)
