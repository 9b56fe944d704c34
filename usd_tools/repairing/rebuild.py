"""Rebuild the faulty samples of a clip from the good ones beside them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim import SCHEMES, Animation, Skeleton
from geomstats_anim.faults import fill, mask_of
from geomstats_anim.names import DEFAULT_SCHEME, GAP
from geomstats_anim.rotations import IDENTITY, normalize
from usd_tools.skel.blocks import frame_blocks
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.fault_words import SIGN_FLIP
from usd_tools.skel.faults import ClipFault, fault_of, find_clip_faults, find_gaps
from usd_tools.skel.gaps import space_of
from usd_tools.skel.xform_faults import find_op_faults
from usd_tools.skel.xforms import XformOp, cuts_of, resample_op


@dataclass(frozen=True, eq=False)
class Repair:
    """A clip whose faults are repaired.

    Parameters
    ----------
    clip : SkelClip
        Repaired; what is left of gaps is filled in.
    faults : tuple of ClipFault
    left : tuple of ClipFault
        Those of them that are longer than what is rebuilt.
    changed : tuple of str
        Channels with other samples than before.
    """

    clip: SkelClip
    faults: tuple[ClipFault, ...]
    left: tuple[ClipFault, ...]
    changed: tuple[str, ...]

    def with_gaps(self, channel: Channel) -> Channel:
        """Return a channel to write: gaps that are left are as the file has them."""
        gaps = self.clip.gaps.get(channel.name)
        left = [each.fault for each in self.left if each.channel == channel.name and each.fault.kind == GAP]
        if gaps is None or not left:
            return channel
        still = mask_of(left, *gaps.where.shape)
        values = channel.values.copy()
        values[still] = gaps.values[still[gaps.where]]
        return replace(channel, values=values)


def repair_clip(clip: SkelClip, max_gap: int | None) -> Repair:
    """Repair a clip that was read with its gaps filled in.

    Rotations and translations are on the geodesic spline through the good samples, scales and weights of blend shapes
    on lines. Before the first good sample, and after the last, the nearest is held. Every other sample stays bit for
    bit, but for the sign of quaternions.

    Parameters
    ----------
    clip : SkelClip
    max_gap : int or None
        Samples of the longest fault that is rebuilt; None for those of a second.

    Returns
    -------
    repair : Repair
    """
    faults = find_clip_faults(clip)
    limits = {name: max_gap or _samples_of_a_second(clip, channel) for name, channel in clip.channels.items()}
    left = [each for each in faults if each.samples > limits[each.channel]]
    wanted = [each for each in faults if each.samples <= limits[each.channel]]
    bad = {name: _mask(clip.channels[name], wanted) for name in {each.channel for each in wanted}}
    near = replace(clip, channels={**clip.channels, **{name: _near(clip.channels[name], bad[name]) for name in bad}})
    channels = dict(near.channels)
    for name in bad:
        if name in ("rotations", "translations"):
            still_missing = _mask(near.channels[name], [each for each in left if each.fault.kind == GAP])
            channels[name] = _rebuilt(near, name, bad[name], still_missing)
    changed = set(bad)
    if "rotations" in channels:
        signed, flips = _one_sign(clip, channels["rotations"])
        if flips:
            channels["rotations"] = signed
            faults, changed = [*faults, *flips], changed | {"rotations"}
    repaired = replace(clip, channels=channels)
    return Repair(repaired, tuple(faults), tuple(left), tuple(name for name in clip.channels if name in changed))


@dataclass(frozen=True, eq=False)
class OpRepair:
    """A transform op whose faults are repaired.

    Parameters
    ----------
    op : XformOp
        Repaired.
    faults : tuple of ClipFault
    left : tuple of ClipFault
        Those of them that are longer than what is rebuilt; gaps are among the others, however long.
    """

    op: XformOp
    faults: tuple[ClipFault, ...]
    left: tuple[ClipFault, ...]


def repair_op(op: XformOp, clip: SkelClip, max_gap: int | None) -> OpRepair:
    """Repair a transform op that was read with its gaps filled in, see `repair_clip`.

    Parameters
    ----------
    op : XformOp
    clip : SkelClip
        Of the character, repaired.
    max_gap : int or None
        See `repair_clip`; a gap is filled in, however long.

    Returns
    -------
    repair : OpRepair
    """
    faults, channel = find_op_faults(op, clip), op.channel
    limit = max_gap or _samples_of_a_second(clip, channel)
    left = tuple(each for each in faults if each.samples > limit and each.fault.kind != GAP)
    bad = mask_of((each.fault for each in faults if each not in left), len(channel.codes), 1)[:, 0]
    if not bad.any():
        return OpRepair(op, tuple(faults), left)
    good = replace(op, channel=channel.at(~bad), gaps=None)
    dense = resample_op(good, channel.codes, clip.codes_per_second, DEFAULT_SCHEME, cuts_of(good, clip, True))
    last = np.searchsorted(dense.codes, channel.codes[bad], side="right") - 1  # at an end the nearest
    values = channel.values.copy()
    values[bad] = dense.values[np.maximum(last, 0)]
    return OpRepair(replace(op, channel=replace(channel, values=values), gaps=None), tuple(faults), left)


def _samples_of_a_second(clip: SkelClip, channel: Channel) -> int:
    if len(channel.codes) < 2:
        return 1
    return max(1, round(clip.samples_per_second(channel.codes)))


def _mask(channel: Channel, faults: Sequence[ClipFault]) -> np.ndarray:
    return mask_of((each.fault for each in faults if each.channel == channel.name), *channel.values.shape[:2])


def _near(channel: Channel, bad: np.ndarray) -> Channel:
    """Fill in faults on the shortest way, so that cuts can be found."""
    live = ~channel.blocked
    values = channel.values.copy()
    values[live] = fill(channel.values[live], channel.codes[live], space_of(channel.name), bad[live])
    values[~bad] = channel.values[~bad]
    return replace(channel, values=values)


def _rebuilt(near: SkelClip, name: str, bad: np.ndarray, missing: np.ndarray) -> Channel:
    """Put faults on the spline through all other samples of their stretch, but those that are missing too."""
    channel = near.channels[name]
    values = channel.values.copy()
    for span in near.spans(name):
        for columns, wanted, keys in _alike(bad[span], ~(bad | missing)[span]):
            if len(keys) < 2:
                continue
            times = channel.codes[span] / near.codes_per_second
            inside = wanted[(wanted > keys[0]) & (wanted < keys[-1])]
            rows = channel.values[span]
            curve = _spline(name, times[keys], rows[np.ix_(keys, columns)])
            if len(inside):
                values[np.ix_(span.start + inside, columns)] = curve(times[inside])
            for outside, nearest in ((wanted[wanted < keys[0]], keys[0]), (wanted[wanted > keys[-1]], keys[-1])):
                values[np.ix_(span.start + outside, columns)] = rows[nearest, columns]
    return replace(channel, values=values)


def _alike(bad: np.ndarray, good: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield joints that have the same faults, shape=[J], the samples of these, and the good ones."""
    faulty = np.flatnonzero(bad.any(axis=0))
    if not len(faulty):
        return
    both = np.concatenate([bad[:, faulty], good[:, faulty]])
    _, first, group = np.unique(both, axis=1, return_index=True, return_inverse=True)
    for k, column in enumerate(faulty[first].tolist()):
        yield faulty[group.reshape(-1) == k], np.flatnonzero(bad[:, column]), np.flatnonzero(good[:, column])


def _spline(name: str, times: np.ndarray, keys: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Lead a geodesic spline through rotations or translations of joints, shape=[K, J, C]."""
    n_keys, n_joints = keys.shape[:2]
    names = tuple(f"joint{k}" for k in range(n_joints))
    at_rest = np.zeros((n_joints, 3)), np.tile(IDENTITY, (n_joints, 1))
    apart = Skeleton(names, np.full(n_joints, -1), *at_rest)
    pose = {"translations": np.zeros((n_keys, n_joints, 3)), "rotations": np.tile(IDENTITY, (n_keys, n_joints, 1))}
    values = keys.astype(np.float64)
    pose[name] = normalize(values) if name == "rotations" else values
    curve = SCHEMES[DEFAULT_SCHEME](Animation(apart, times, **pose))
    return lambda wanted: np.asarray(getattr(curve(wanted), name))


def _one_sign(clip: SkelClip, channel: Channel) -> tuple[Channel, list[ClipFault]]:
    """Give each joint's quaternions the sign of the one before, changing as few as can be; list what was changed."""
    flips = np.zeros((len(channel.codes), len(clip.joints)), dtype=bool)
    for frames in frame_blocks(*channel.values.shape[:2]) if len(channel.codes) > 1 else ():
        values = channel.values[frames].astype(np.float64)
        flips[frames.start + 1 : frames.stop] = np.einsum("kni,kni->kn", values[:-1], values[1:]) < 0.0
    if not flips.any():
        return channel, []
    negative = np.logical_xor.accumulate(flips, axis=0)
    live = ~channel.blocked
    negative ^= 2 * negative[live].sum(axis=0) > live.sum()
    values = np.where((negative & live[:, None])[..., None], -channel.values, channel.values)
    found = [replace(fault, kind=SIGN_FLIP) for fault in find_gaps(negative & live[:, None])]
    found.sort(key=lambda fault: (fault.start, fault.joint))
    return replace(channel, values=values), [fault_of(clip, channel, fault) for fault in found]
