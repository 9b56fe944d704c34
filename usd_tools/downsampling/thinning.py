"""A clip with few of its samples: which channels are thinned, what becomes a default, and what comes back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim import Animation, LearnedMetric
from geomstats_anim import rotations as quat
from geomstats_anim.criteria import kind_shares, location_errors
from geomstats_anim.interpolation.learned_scheme import Library
from geomstats_anim.markers import Markers, world_errors
from geomstats_anim.rotations import Array
from usd_tools.console.errors import Messages
from usd_tools.downsampling.weights import WEIGHTS
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import animation_of, resample, with_codes, without_cuts
from usd_tools.skel.stored_contacts import StoredContacts
from usd_tools.skel.writer import AnimationLayer

THINNED = ("rotations", "translations")
"""Channels whose samples are chosen together; scales that change are kept whole, for nothing judges them."""


def sampled_alike(clip: SkelClip) -> SkelClip:
    """Sample rotations and translations that change at the same times, as USD shows them; keys need both.

    What is constant becomes a default, if anything moves: its samples tell nothing, but may reach further in time.
    """
    clip = _without_constant_samples(clip)
    moving = {name: clip.channels[name] for name in THINNED if name in clip.channels}
    moving = {name: channel for name, channel in moving.items() if channel.is_animated and not channel.is_constant}
    codes = [channel.codes for channel in moving.values()]
    if len(codes) < 2 or np.array_equal(codes[0], codes[1]):
        return clip
    shown = resample(without_cuts(replace(clip, channels=moving)), np.union1d(codes[0], codes[1]), "slerp").channels
    note = f"{clip.path}: rotations and translations have samples at different times; both get samples at all of them."
    return replace(clip, channels={**clip.channels, **shown}, notes=(*clip.notes, note), given_cuts=clip.cuts)


@dataclass(frozen=True, eq=False)
class SampleSelection:
    """Samples of an animation to choose from.

    Parameters
    ----------
    clip : SkelClip
    names : tuple of str
        Channels that are thinned together; none if neither rotations nor translations change.
    spans : tuple of slice
        Their stretches between value blocks, steps and cuts.
    weights : Channel or None
        Weights of blend shapes with the samples that stay, see `thinned_weights`.
    """

    clip: SkelClip
    names: tuple[str, ...]
    spans: tuple[slice, ...]
    weights: Channel | None

    @classmethod
    def of(cls, clip: SkelClip, weights: Channel | None) -> SampleSelection:
        """Look at an aligned clip."""
        moving = [
            name
            for name in THINNED
            if name in clip.channels and clip.channels[name].is_animated and not clip.channels[name].is_constant
        ]
        if not moving:
            return cls(clip, (), (), weights)
        first = clip.channels[moving[0]]
        names = tuple(name for name in moving if _same_samples(clip.channels[name], first))
        return cls(clip, names, tuple(clip.spans(moving[0])), weights)

    @property
    def animations(self) -> list[Animation]:
        """Motion of each stretch."""
        return [keys for _, keys in self.clip.stretches(self.names)] if self.names else []

    @property
    def kept_whole(self) -> tuple[str, ...]:
        """Channels that change and are not thinned."""
        channels, thinned = self.clip.channels, (*self.names, WEIGHTS)
        return tuple(name for name in channels if name not in thinned and not channels[name].is_constant)

    def frames_at(self, codes: np.ndarray) -> list[np.ndarray]:
        """Find the frames of each stretch that are at some of the time codes."""
        if not self.names:
            return []
        return [np.flatnonzero(np.isin(self.clip.channels[self.names[0]].codes[span], codes)) for span in self.spans]

    def sparse(self, keyframes: Sequence[np.ndarray]) -> SkelClip:
        """Keep some frames of each stretch, and whatever is in none; what is constant becomes a default.

        Parameters
        ----------
        keyframes : sequence of array-like of int

        Returns
        -------
        sparse : SkelClip
        """
        channels = {}
        for name, channel in self.clip.channels.items():
            if name in self.names:
                kept = np.ones(len(channel.codes), dtype=bool)
                for span, frames in zip(self.spans, keyframes, strict=True):
                    kept[span] = False
                    kept[span.start + frames] = True
                channels[name] = channel.at(kept)
            elif name == WEIGHTS and self.weights is not None:
                channels[name] = self.weights
            elif channel.is_constant:
                channels[name] = channel.at(np.zeros(len(channel.codes), dtype=bool))
            else:
                channels[name] = channel
        if self.clip.is_animated and not any(len(channel.codes) for channel in channels.values()):
            # one channel tells how long nothing moves
            name, channel = next(item for item in self.clip.channels.items() if item[1].is_animated)
            kept = np.zeros(len(channel.codes), dtype=bool)
            kept[[0, -1]] = True
            channels[name] = channel.at(kept)
        return replace(self.clip, channels=channels, given_cuts=self.clip.cuts)


def restored(
    sparse: SkelClip,
    metric: LearnedMetric,
    codes: np.ndarray,
    scheme: str | None = None,
    library: Library | None = None,
) -> SkelClip:
    """Rebuild the samples that were removed, as `usd_tools.upsample --times source` does.

    Parameters
    ----------
    sparse : SkelClip
    metric : LearnedMetric
    codes : array-like, shape=[F]
        Where the source has samples.
    scheme : str
        A scheme without a metric instead of the metric's; "slerp" is what viewers show.
        Optional, default: the metric's.
    library : Library
        For the scheme "learned".
        Optional, default: none.
    """
    metric_used = metric if scheme is None else None
    dense = resample(sparse, with_codes(sparse, codes), scheme or metric.scheme, metric_used, library)
    return replace(sparse, channels={**sparse.channels, **dense.channels})


def write_sparse(
    layer: AnimationLayer,
    clip: SkelClip,
    sparse: SkelClip,
    metric: LearnedMetric | None,
    messages: Messages,
    contacts: StoredContacts | None = None,
) -> None:
    """Write a clip with few of its samples, and where the others were.

    Parameters
    ----------
    layer : AnimationLayer
    clip : SkelClip
    sparse : SkelClip
        What `SampleSelection.sparse` made of it.
    metric : LearnedMetric
        That rebuilds the others; None if there are no joints.
    messages : Messages
    contacts : StoredContacts
        What is planted in the clip.
        Optional, default: nothing is said of that.
    """
    sampled = {name: channel for name, channel in sparse.channels.items() if len(channel.codes)}
    constant = {name: channel.default for name, channel in sparse.channels.items() if name not in sampled}
    defaults = {**clip.missing, **constant}
    layer.write_animation(clip.source, sampled, defaults, metric, messages, clip.codes, clip.cuts, contacts=contacts)


@dataclass(frozen=True, eq=False)
class Errors:
    """Distances of a rebuilt animation from its source, frame by frame.

    Parameters
    ----------
    joints : tuple of str, shape=[B]
    degrees : array-like, shape=[F, B]
        Angles between local rotations.
    centimetres : array-like, shape=[F, B]
        Distances in the world, of what is shown of each joint.
    largest : float
        Largest distance in the world of all that is measured, centimetres.
    metres : array-like, shape=[F, B]
        Distances of bone ends as in the papers, which know no scales.
    """

    joints: tuple[str, ...]
    degrees: Array
    centimetres: Array
    largest: float
    metres: Array

    @classmethod
    def between(cls, rebuilt: SkelClip, source: SkelClip, shown: Markers, measured: Markers) -> Errors:
        """Compare two clips that have the same samples."""
        ours, truth = animation_of(rebuilt), animation_of(source)
        return cls(
            truth.skeleton.joints,
            np.degrees(quat.distance(truth.rotations, ours.rotations)),
            100.0 * world_errors(ours, truth, shown),
            100.0 * float(world_errors(ours, truth, measured).max(initial=0.0)),
            location_errors(ours, truth),
        )

    def quality(self, kind: str) -> float:
        """Quality as in `geomstats_anim.criteria`, without weights."""
        location = float((self.metres**2).sum(axis=-1).mean())
        rotation = float(np.radians(self.degrees).sum(axis=-1).mean())
        shares = kind_shares(kind)
        return shares.location * location + shares.rotation * rotation


def _without_constant_samples(clip: SkelClip) -> SkelClip:
    constant = {name: channel for name, channel in clip.channels.items() if channel.is_constant}
    if not any(channel.is_animated for name, channel in clip.channels.items() if name not in constant):
        return clip
    defaults = {name: channel.at(np.zeros(len(channel.codes), dtype=bool)) for name, channel in constant.items()}
    return replace(clip, channels={**clip.channels, **defaults})


def _same_samples(one: Channel, other: Channel) -> bool:
    return np.array_equal(one.codes, other.codes) and np.array_equal(one.blocked, other.blocked)
