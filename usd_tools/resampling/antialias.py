"""Filter fast motion: what a lower rate cannot hold, before samples are taken at that rate, or noise."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geomstats_anim.filtering import low_pass, low_pass_rotations
from geomstats_anim.rotations import normalize
from usd_tools.console.errors import ToolError
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.xform_motion import Parts
from usd_tools.skel.xforms import XformOp

CUTOFF = 0.8
"""Of half the new rate: there half of the amplitude is left, and at half the new rate itself a thirtieth (-31 dB)."""

EVEN = 1e-2
"""Share of the spacing by which samples of a steady rate may be off."""


class LowPass(NamedTuple):
    """Hold what is filtered away, and why.

    Attributes
    ----------
    cutoff : float
        Hertz.
    rate : float
        What has no more samples per second than this is left alone.
    option : str
        That asks for it.
    """

    cutoff: float
    rate: float
    option: str


def before_resampling(fps: float) -> LowPass:
    """Return the filter of motion that is to be sampled at a rate."""
    return LowPass(CUTOFF * fps / 2.0, fps, "--antialias")


def filtered_clip(clip: SkelClip, low_pass_of: LowPass) -> SkelClip:
    """Filter every channel that has more samples per second than a rate.

    What never moves between two cuts stays bit for bit.

    Parameters
    ----------
    clip : SkelClip
    low_pass_of : LowPass

    Returns
    -------
    filtered : SkelClip
        With its samples where they were.

    Raises
    ------
    ToolError
        If samples are not evenly spaced.
    """
    channels = dict(clip.channels)
    for name, channel in clip.channels.items():
        values = channel.values.copy()
        for span in clip.spans(name):
            rate = _steady_rate(f"{clip.path}: {name}", channel, span, clip.codes_per_second, low_pass_of)
            if rate <= low_pass_of.rate:
                continue
            keys, moves = channel.values[span].astype(np.float64), ~channel.holds[span.start : span.stop - 1].all(0)
            if name == "rotations":
                smooth = low_pass_rotations(normalize(keys[:, moves]), rate, low_pass_of.cutoff)
            else:
                smooth = low_pass(keys[:, moves], rate, low_pass_of.cutoff)
            values[span.start : span.stop, moves] = smooth
        channels[name] = replace(channel, values=values)
    return replace(clip, channels=channels, given_cuts=clip.cuts)


def filtered_op(op: XformOp, cuts: np.ndarray, codes_per_second: float, low_pass_of: LowPass) -> XformOp:
    """Filter a transform op that has more samples per second than a rate; see `filtered_clip`.

    Raises
    ------
    ToolError
        If its samples are not evenly spaced.
    """
    channel = op.channel
    values = channel.values.copy()
    for span in channel.stretches(codes_per_second, cuts):
        rate = _steady_rate(str(op.attribute.GetPath()), channel, span, codes_per_second, low_pass_of)
        if rate <= low_pass_of.rate or channel.holds[span.start : span.stop - 1].all():
            continue
        numbers = channel.values[span, 0]
        parts, cutoff = op.codec.split(numbers), low_pass_of.cutoff
        smooth = Parts(
            low_pass_rotations(parts.turns, rate, cutoff),
            low_pass(parts.path, rate, cutoff),
            low_pass(parts.sizes, rate, cutoff),
        )
        values[span, 0] = op.codec.join(smooth, numbers, np.arange(len(numbers)))
    return replace(op, channel=replace(channel, values=values))


def _steady_rate(what: str, channel: Channel, span: slice, codes_per_second: float, low_pass_of: LowPass) -> float:
    """Return the samples per second of a stretch, or refuse one that cannot be filtered."""
    gaps = np.diff(channel.codes[span])
    usual = float(np.median(gaps))
    rate = codes_per_second / usual
    if codes_per_second / gaps.min() <= low_pass_of.rate:  # however uneven, there is nothing to filter
        return rate
    if np.abs(gaps - usual).max() > EVEN * usual:
        raise ToolError(
            f"{what} is not evenly sampled, so {low_pass_of.option} cannot filter it; resample it with --fps {rate:g} "
            "first."
        )
    return rate
