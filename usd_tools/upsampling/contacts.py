"""Keep planted points of clips where they are between samples: `--contacts`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim import Animation
from geomstats_anim import rotations as quat
from geomstats_anim.contacts import Planted, Plants, plant
from geomstats_anim.markers import joint_places
from usd_tools.characters.placement import placed
from usd_tools.characters.planted import found_plants, stored_plants
from usd_tools.console.errors import Messages
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import signs_towards
from usd_tools.upsampling.result import KeptContacts
from usd_tools.upsampling.summary import UpsampledClip

REACH = 10.0
"""Centimetres by which a point is moved at most, where only samples tell that it is planted."""

_NEAR = 1e-7
"""Seconds by which two samples are the same."""


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Samples that one curve leads through, and the points that are planted between them."""

    span: slice
    keys: Animation
    plants: Plants


class ClipContacts:
    """The points of a clip that are planted, as the file says, or else as its samples tell.

    Parameters
    ----------
    clip : SkelClip
    reach : float or None
        Centimetres by which a point may be moved.
    messages : Messages
        Told if contacts cannot be kept.
    """

    def __init__(self, clip: SkelClip, reach: float | None, messages: Messages) -> None:
        self.clip = clip
        self._names = _joint_channels(clip)
        problem = _problem(clip, self._names)
        if problem is not None:
            messages.warn(f"{clip.path}: {problem}; --contacts changes nothing there.")
        stored = stored_plants(clip)
        self._reach = 0.01 * reach if reach is not None else 0.01 * REACH if stored is None else np.inf
        self._stretches = [] if problem is not None else self._found(stored)

    def _found(self, stored: Plants | None) -> list[_Stretch]:
        stretches = []
        for span, motion in self.clip.stretches(self._names):
            keys = placed(self.clip, motion)
            plants = (found_plants(self.clip, motion) if stored is None else stored).through_keys(keys)
            if plants.number:
                stretches.append(_Stretch(span, keys, plants))
        return stretches

    def with_probes(self, codes: np.ndarray) -> np.ndarray:
        """Add the time codes at which curves must be known beside some, to `planted`."""
        rate = self.clip.codes_per_second
        probes = np.concatenate([[], *(stretch.plants.probes() * rate for stretch in self._stretches)])
        after = np.searchsorted(codes, probes - _NEAR * rate)
        is_new = np.abs(codes[np.minimum(after, len(codes) - 1)] - probes) > _NEAR * rate
        return np.union1d(codes, probes[is_new])

    def planted(self, upsampled: UpsampledClip) -> UpsampledClip:
        """Keep points planted in the samples of a curve, and leave out the probes.

        Parameters
        ----------
        upsampled : UpsampledClip
            What `resample` gives at its time codes and at the probes.

        Returns
        -------
        planted : UpsampledClip
            With the contacts that are kept.
        """
        clip, kept, channels = self.clip, KeptContacts(), dict(upsampled.result.channels)
        for name in self._names if self._stretches else ():
            channels[name] = replace(channels[name], values=channels[name].values.copy())
        shown = replace(clip, channels={**clip.channels, **channels})
        parameters = upsampled.chosen.metric.for_joints(clip.skeleton.joints)[0].parameters
        for stretch in self._stretches:
            codes = channels["rotations"].codes
            first, last = clip.channels["rotations"].codes[stretch.span][[0, -1]]
            frames = np.flatnonzero((codes >= first) & (codes <= last))
            wanted = np.isin(codes[frames], upsampled.codes)
            dense = placed(shown, shown.keys(self._names, frames))
            moves_root = "translations" in self._names
            result = plant(dense, stretch.keys, stretch.plants, parameters, self._reach, moves_root, wanted)
            before, frames = dense.at_frames(wanted), frames[wanted]
            for name in self._names:
                _write(clip, channels[name], frames, getattr(before, name), getattr(result.animation, name))
            kept = _joined(kept, clip, before, result)
        at_codes = {name: channel.at(np.isin(channel.codes, upsampled.codes)) for name, channel in channels.items()}
        return replace(upsampled, result=replace(upsampled.result, channels=at_codes), contacts=kept)


def _joint_channels(clip: SkelClip) -> tuple[str, ...]:
    return tuple(name for name in ("rotations", "translations") if _moves(clip, name))


def _moves(clip: SkelClip, name: str) -> bool:
    return name in clip.channels and clip.channels[name].is_animated


def _problem(clip: SkelClip, names: Sequence[str]) -> str | None:
    """Return why points cannot be kept planted; None if they can."""
    if "rotations" not in names:
        return "no joint turns"
    first = clip.channels["rotations"]
    every = [*names, *(["scales"] if _moves(clip, "scales") else [])]
    alike = all(
        np.array_equal(clip.channels[name].codes, first.codes)
        and np.array_equal(clip.channels[name].blocked, first.blocked)
        for name in every
    )
    if not alike:
        return f"{' and '.join(every)} have samples at different times"
    placements = clip.placements(clip.codes)
    return "transforms move the character" if placements is not None and np.ptp(placements, axis=0).any() else None


def _write(clip: SkelClip, channel: Channel, frames: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
    """Write the values of joints that were moved into a channel, with the signs that are there."""
    moved = (before != after).any(axis=-1)[:, clip.columns]
    values = clip.values_of(channel.name, after[:, clip.columns])
    old = channel.values[frames]
    if channel.name == "rotations":
        values = values * signs_towards(old, values)
    old[moved] = values[moved]
    channel.values[frames] = old


def _joined(kept: KeptContacts, clip: SkelClip, before: Animation, planted: Planted) -> KeptContacts:
    """Add the contacts of a stretch, by the motion before and what became of it."""
    joints = np.unique(planted.plants.joints)
    places = [joint_places(each, joints) for each in (before, planted.animation)]
    way = 100.0 * np.linalg.norm(places[1] - places[0], axis=-1).max(initial=0.0)
    turn = np.degrees(quat.distance(before.rotations, planted.animation.rotations).max(initial=0.0))
    names = {clip.skeleton.joints[joint] for joint in joints}.union(kept.joints)
    return KeptContacts(
        tuple(joint for joint in clip.skeleton.joints if joint in names),
        kept.kept + planted.plants.number,
        kept.left + planted.left.number,
        max(kept.largest_cm, float(way)),
        max(kept.largest_degrees, float(turn)),
    )
