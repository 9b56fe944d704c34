"""Cycles: how nearly a clip is one, and its samples beyond both ends, so that curves lead across the seam."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import normalize
from usd_tools.console.errors import ToolError
from usd_tools.console.text import short_names
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip

if TYPE_CHECKING:
    from usd_tools.skel.xforms import XformOp

NEAR = 5.0
"""Degrees by which the worst joint of what is nearly a loop may miss."""

LEAST_RANGE = 10.0
"""Degrees that some joint of a loop goes away from its first pose, and four times as far as it misses."""

REACH = 32
"""Samples beyond the seam that a curve looks at: of continuous acceleration each has a quarter of the weight of the one
before, so that nothing is left in double precision."""

IN_PLACE = 1.5
"""A root that ends within so many of its largest steps from where it began does not travel."""


@dataclass(frozen=True)
class Loop:
    """Measures of a clip as a cycle.

    Parameters
    ----------
    closed : bool
        Whether the last pose is the first again; otherwise the first comes one sample later.
    joint : str
        That misses most.
    degrees : float
        By how much: between both poses, or from the step across the seam to the mean of the steps beside it.
    range_degrees : float
        How far a joint goes away from its first pose.
    """

    closed: bool
    joint: str
    degrees: float
    range_degrees: float

    @property
    def is_near(self) -> bool:
        """Return whether it is nearly a loop."""
        return self.degrees <= NEAR and self.range_degrees >= max(LEAST_RANGE, 4.0 * self.degrees)


def find_loop(clip: SkelClip) -> Loop | None:
    """Measure by how much a clip misses being a loop; None for rotations of fewer than four samples, or with blocks.

    Parameters
    ----------
    clip : SkelClip

    Returns
    -------
    loop : Loop or None
    """
    channel = clip.channels.get("rotations")
    if channel is None or len(channel.codes) < 4 or channel.blocked.any() or not clip.joints:
        return None
    moves = np.flatnonzero(~channel.holds.all(axis=0))
    if not len(moves):
        return None
    first, second, last_but_one, last = normalize(channel.values[[0, 1, -2, -1]][:, moves].astype(np.float64))
    seam = _turns(last, first)
    beside = 0.5 * (_turns(first, second) + _turns(last_but_one, last))
    misses = {True: np.linalg.norm(seam, axis=-1), False: np.linalg.norm(seam - beside, axis=-1)}
    closed = bool(misses[True].max() <= misses[False].max())
    worst = int(np.argmax(misses[closed]))
    away = max(
        float(quat.distance(normalize(channel.values[frames][:, moves].astype(np.float64)), first).max())
        for frames in np.array_split(np.arange(len(channel.codes)), 1 + len(channel.codes) // 1024)
    )
    return Loop(closed, clip.joints[moves[worst]], float(np.degrees(misses[closed][worst])), float(np.degrees(away)))


def _turns(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return `quat.difference` in plain NumPy: inspect is too short for loading compiled code."""
    vector = left[..., 3:] * right[..., :3] - right[..., 3:] * left[..., :3] - np.cross(left[..., :3], right[..., :3])
    cosine = (left * right).sum(axis=-1, keepdims=True)
    sine = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, np.abs(cosine))
    return np.asarray(np.copysign(angle / np.where(sine > 0.0, sine, 1.0), cosine) * vector)


def closed_cycle(clip: SkelClip) -> tuple[SkelClip, Loop]:
    """Give a loop its first pose again at its end, one sample later, where it has it not yet.

    Raises
    ------
    ToolError
        If it is no loop, or its channels do not begin and end together.
    """
    loop = find_loop(clip)
    if loop is None:
        raise ToolError(f"{clip.path} has no rotations of at least four samples without blocks, which --loop needs.")
    if not loop.is_near:
        joint = short_names(clip.joints)[loop.joint]
        raise ToolError(
            f"{clip.path} is not a loop: joint {joint} misses by {loop.degrees:.1f} degrees; leave --loop out."
        )
    if not all(_spans_all(channel, clip) for channel in clip.channels.values() if channel.is_animated):
        raise ToolError(f"{clip.path}: not all attributes begin and end together, as --loop needs it.")
    if loop.closed:
        return clip, loop
    gap = clip.codes_per_second / clip.samples_per_second()
    channels = {
        name: _with_first_again(channel, _carried(clip, channel), gap) if channel.is_animated else channel
        for name, channel in clip.channels.items()
    }
    return replace(clip, channels=channels, given_cuts=clip.cuts), loop


def _spans_all(channel: Channel, clip: SkelClip) -> bool:
    """Return whether a channel has samples where its clip begins and ends, and no blocks."""
    return not channel.blocked.any() and channel.codes[[0, -1]].tolist() == clip.codes[[0, -1]].tolist()


def extended_cycle(clip: SkelClip) -> SkelClip:
    """Repeat the samples of a closed cycle beyond both of its ends; roots go on travelling."""
    channels = {
        name: _extended(channel, _carried(clip, channel)) if channel.is_animated else channel
        for name, channel in clip.channels.items()
    }
    return replace(clip, channels=channels, given_cuts=clip.cuts)


def cropped(channel: Channel, first: float, last: float) -> Channel:
    """Take the samples in a range of time codes."""
    return channel.at((channel.codes >= first) & (channel.codes <= last))


def closed_op(op: XformOp, clip: SkelClip, loop: Loop) -> XformOp:
    """Do as `closed_cycle` with a transform op of the character."""
    if loop.closed:
        return op
    gap = clip.codes_per_second / clip.samples_per_second()
    return replace(op, channel=_with_first_again(op.channel, _carried_by(op), gap))


def extended_op(op: XformOp) -> XformOp:
    """Do as `extended_cycle` with a transform op of the character."""
    return replace(op, channel=_extended(op.channel, _carried_by(op)))


def _carried(clip: SkelClip, channel: Channel) -> np.ndarray:
    """Return which numbers of a channel go on from cycle to cycle, shape=[N, C]: translations of roots."""
    carried = np.zeros(channel.values.shape[1:], dtype=bool)
    if channel.name == "translations":
        carried[clip.skeleton.parents[clip.columns] < 0] = True
    return carried


def _carried_by(op: XformOp) -> np.ndarray:
    """Return which numbers of an op go on from cycle to cycle, shape=[1, C]."""
    width = op.channel.values.shape[2]
    if width == 16:  # a matrix, whose last row is where it moves to
        return np.isin(np.arange(16), (12, 13, 14))[None]
    return np.full((1, width), op.attribute.GetName().startswith("xformOp:translate"))


def _with_first_again(channel: Channel, carried: np.ndarray, gap: float) -> Channel:
    """Add the first sample at the end of a channel, as far on as it has travelled by then."""
    values = channel.values.astype(np.float64)
    steps = np.diff(values, axis=0)
    travels = carried & (np.abs(values[-1] - values[0]) > IN_PLACE * np.abs(steps).max(axis=0))
    again = np.where(travels, values[-1] + 0.5 * (steps[0] + steps[-1]), values[0])
    return replace(
        channel,
        codes=np.append(channel.codes, channel.codes[-1] + gap),
        values=np.concatenate([channel.values, again[None].astype(channel.values.dtype)]),
        blocked=np.append(channel.blocked, False),
    )


def _extended(channel: Channel, carried: np.ndarray) -> Channel:
    """Repeat the samples of a closed cycle beyond both ends; what is carried goes on."""
    count, period = len(channel.codes) - 1, channel.codes[-1] - channel.codes[0]
    travel = np.where(carried, channel.values[-1].astype(np.float64) - channel.values[0], 0.0)
    index = np.arange(-REACH, count + REACH + 1)
    inside = (index >= 0) & (index <= count)  # the last stays as it is, though it may miss the first
    cycles, places = np.divmod(index, count)
    cycles[inside], places[inside] = 0, index[inside]
    values = channel.values[places]
    values[~inside] = values[~inside].astype(np.float64) + cycles[~inside, None, None] * travel
    codes = channel.codes[places] + cycles * period
    return replace(channel, codes=codes, values=values, blocked=np.zeros(len(codes), dtype=bool))
