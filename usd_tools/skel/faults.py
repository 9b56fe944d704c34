"""Find the faults of a clip: gaps in all channels, spikes and drop-outs in rotations and translations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geomstats_anim.faults import Fault, find_faults, steps_between
from geomstats_anim.names import DROPOUT, GAP, SPIKE
from usd_tools.skel.channels import Channel, step_pairs
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.gaps import space_of
from usd_tools.skel.joint_names import read_names
from usd_tools.skel.rotation_checks import rotation_steps

UNIT_OF_REACH = 0.05
"""Translations are compared in this share of the skeleton's longest chain: 5 cm of a body count as much as a radian."""

DENSE = 0.07
"""Seconds between samples, at most, of recorded motion; keys further apart may leave and come back as they like."""

PAUSE = 0.15
"""Seconds without a sample that part recorded motion."""


@dataclass(frozen=True)
class ClipFault:
    """A fault of one joint in one channel.

    Parameters
    ----------
    channel : str
    joint : str
        Name of the joint, or of the blend shape; of a transform the path of its prim.
    fault : Fault
        With the column of the joint, samples of the channel, and a size in radians or metres.
    start, end : float
        Time codes of its first and its last sample.
    is_turn : bool
        Whether its size is an angle.
    """

    channel: str
    joint: str
    fault: Fault
    start: float
    end: float
    is_turn: bool

    @property
    def samples(self) -> int:
        """Number of samples."""
        return self.fault.stop - self.fault.start

    def as_dict(self, short_name: str) -> dict[str, Any]:
        """Return plain values; `degrees` or `centimetres` is None where it does not apply."""
        sized = self.fault.kind in (SPIKE, DROPOUT)
        return {
            "kind": self.fault.kind,
            "channel": self.channel,
            "joint": self.joint,
            "joint_name": short_name,
            "start": self.start,
            "end": self.end,
            "samples": self.samples,
            "degrees": float(np.degrees(self.fault.size)) if sized and self.is_turn else None,
            "centimetres": 100.0 * self.fault.size if sized and not self.is_turn else None,
        }


def find_clip_faults(clip: SkelClip, degrees: np.ndarray | None = None) -> list[ClipFault]:
    """Find the faults of a clip that was read with its gaps filled in.

    Parameters
    ----------
    clip : SkelClip
    degrees : array-like, shape=[K - 1, N]
        See `rotation_steps`.
        Optional, default: measured here.

    Returns
    -------
    faults : list of ClipFault
        By channel, then by time, then by joint. Of sparse keys only gaps.
    """
    found = []
    for name, channel in clip.channels.items():
        faults: list[Fault] = []
        if name in clip.gaps:
            where = clip.gaps[name].where
            faults += find_gaps(where)
        if name in ("rotations", "translations") and clip.given_cuts is None and channel.is_animated:
            if name == "rotations":
                degrees = rotation_steps(clip) if degrees is None else degrees
                faults += _unlikely(clip, channel, np.radians(degrees))
            else:
                faults += _unlikely(clip, channel, None)
        faults.sort(key=lambda fault: (fault.start, fault.joint))
        found += [fault_of(clip, channel, fault) for fault in faults]
    return found


def find_gaps(where: np.ndarray) -> list[Fault]:
    """Return the runs of what is missing, shape=[K, N], as faults."""
    still = np.zeros((*where.shape, 1))
    faults = find_faults(still, np.arange(len(where), dtype=float), space_of("gaps"), where)
    return [fault for fault in faults if fault.kind == GAP]


def fault_of(clip: SkelClip, channel: Channel, fault: Fault) -> ClipFault:
    """Name the joint and the time codes of a fault."""
    is_joint = channel.name != "blendShapeWeights"
    names = clip.joints if is_joint else read_names(clip.source.prim, "blendShapes")
    start, end = channel.codes[[fault.start, fault.stop - 1]].tolist()
    return ClipFault(channel.name, names[fault.joint], fault, start, end, channel.name == "rotations")


def _unlikely(clip: SkelClip, channel: Channel, steps: np.ndarray | None) -> Iterator[Fault]:
    """Find spikes and drop-outs in the dense stretches of a channel."""
    unit = length_unit(clip)
    if channel.name != "rotations" and unit == 0.0:
        return
    space = space_of(channel.name, unit / clip.world_scale)
    columns = np.flatnonzero(~channel.holds.all(axis=0))
    if not len(columns):
        return
    parents = _parents(clip)[columns]
    place = np.full(len(clip.joints) + 1, -1)
    place[columns] = np.arange(len(columns))
    missing = clip.gaps[channel.name].where if channel.name in clip.gaps else None
    everything = len(columns) == len(clip.joints)
    for span in dense_stretches(channel, clip.codes_per_second):
        values = channel.values[span] if everything else channel.values[span][:, columns]
        own = steps_between(values, space) if steps is None else steps[span.start : span.stop - 1][:, columns]
        faults = find_faults(
            values,
            channel.codes[span] / clip.codes_per_second,
            space,
            None if missing is None else missing[span][:, columns],
            own,
            place[parents],
        )
        for fault in faults:
            if fault.kind != GAP:
                size = fault.size if channel.name == "rotations" else fault.size * unit
                start, stop = fault.start + span.start, fault.stop + span.start
                yield replace(fault, joint=int(columns[fault.joint]), start=start, stop=stop, size=size)


def dense_stretches(channel: Channel, codes_per_second: float) -> Iterator[slice]:
    """Yield the stretches of recorded motion: without blocks, steps and pauses, see `DENSE`."""
    for span in channel.spans:
        gaps = np.diff(channel.codes[span]) / codes_per_second
        breaks = step_pairs(channel.codes[span], codes_per_second) | (gaps > PAUSE * (1.0 + 1e-9))
        edges = [span.start, *(span.start + 1 + np.flatnonzero(breaks)).tolist(), span.stop]
        for start, stop in zip(edges[:-1], edges[1:], strict=True):
            if stop - start > 2 and np.median(np.diff(channel.codes[start:stop])) <= DENSE * codes_per_second * 1.001:
                yield slice(start, stop)


def _parents(clip: SkelClip) -> np.ndarray:
    """Return the place among the animation's joints of each one's parent, shape=[N]; -1 for none."""
    place = np.full(clip.skeleton.n_joints + 1, -1)
    place[clip.columns] = np.arange(len(clip.joints))
    return place[clip.skeleton.parents[clip.columns]]


def length_unit(clip: SkelClip) -> float:
    """Return the length that counts as much as a turn of one radian, in metres; see `UNIT_OF_REACH`."""
    skeleton = clip.skeleton
    lengths = np.linalg.norm(skeleton.rest_translations, axis=-1)
    reach = np.zeros(skeleton.n_joints)
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            reach[joint] = reach[parent] + lengths[joint]
    return UNIT_OF_REACH * float(reach.max(initial=0.0))
