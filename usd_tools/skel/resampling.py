"""Place new samples and fill them: keys bit for bit, in-betweens from a scheme of `geomstats_anim`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from geomstats_anim import Animation, LearnedMetric
from geomstats_anim.interpolation.curves import Curve, Fallback
from geomstats_anim.interpolation.learned_scheme import Help, Library
from geomstats_anim.interpolation.metric_schemes import curve_parameters
from geomstats_anim.interpolation.schemes import make_curve
from usd_tools.console.errors import ToolError
from usd_tools.skel.blocks import joint_blocks
from usd_tools.skel.channels import Channel, held, sampled_alike, step_pairs
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.frame_rates import rate_like

CHUNK = 1 << 17
"""Rotations evaluated at once: enough to keep NumPy busy, few enough to need little memory."""

SNAP = 1e-6
"""A new sample nearer to a source sample than this share of the spacing is that sample."""

SNAP_OF_FRAME = 1e-2
"""A frame of a steady rate nearer to a source sample than this share of a frame is that sample."""


def subdivided(clip: SkelClip, factor: int) -> np.ndarray:
    """Return the time codes of a clip's samples, with every gap that is not a step cut into equal parts.

    Parameters
    ----------
    clip : SkelClip
    factor : int
        Parts.

    Returns
    -------
    codes : array-like, shape=[F]
    """
    starts, gaps = clip.codes[:-1][~clip.steps], np.diff(clip.codes)[~clip.steps]
    parts = np.arange(1, factor) / factor
    return np.union1d(clip.codes, (starts[:, None] + gaps[:, None] * parts).ravel())


def with_codes(clip: SkelClip, codes: np.ndarray, nearest: float | None = None) -> np.ndarray:
    """Return the time codes of the samples of a clip, and others that lie between them.

    Parameters
    ----------
    clip : SkelClip
    codes : array-like, shape=[F]
        Those outside the range of the clip, or within a step, are left out.
    nearest : float
        Time codes that are nearer to a sample than this are left out too.
        Optional, default: `SNAP` of the spacing of the clip's samples or of the codes, whichever is less.

    Returns
    -------
    codes : array-like, shape=[F']
    """
    return merged_codes(clip.codes, codes, clip.codes_per_second, nearest)


def merged_codes(
    keys: np.ndarray, codes: np.ndarray, codes_per_second: float, nearest: float | None = None
) -> np.ndarray:
    """Return the time codes of samples, shape=[K], and others that lie between them; see `with_codes`."""
    if nearest is None:
        gaps = [np.diff(some) for some in (keys, np.unique(codes)) if len(some) > 1]
        nearest = SNAP * min((float(np.median(each)) for each in gaps if len(each)), default=0.0)
    codes = np.unique(codes[(codes > keys[0]) & (codes < keys[-1])])
    segment = np.searchsorted(keys, codes, side="right") - 1
    far = np.minimum(codes - keys[segment], keys[segment + 1] - codes) > nearest
    return np.union1d(keys, codes[far & ~step_pairs(keys, codes_per_second)[segment]])


def at_rate(clip: SkelClip, rate: float) -> np.ndarray:
    """Return the time codes of the samples of a clip, and others at a steady rate: the whole frames of that rate.

    A clip that has samples at that rate keeps them, whatever frames they are on.

    Parameters
    ----------
    clip : SkelClip
    rate : float
        Samples per second.

    Returns
    -------
    codes : array-like, shape=[F]
    """
    spacing = clip.codes_per_second / rate_like(rate, clip.codes_per_second)
    steady = clip.codes[0] + spacing * np.arange(len(clip.codes))
    if (np.abs(clip.codes - steady) <= SNAP_OF_FRAME * spacing).all():
        return clip.codes
    frames = np.arange(np.ceil(clip.codes[0] / spacing), np.floor(clip.codes[-1] / spacing) + 1.0)
    return with_codes(clip, frames * spacing, SNAP_OF_FRAME * spacing)


@dataclass(frozen=True, eq=False)
class Resampled:
    """A clip at other time codes.

    Parameters
    ----------
    channels : mapping of str to Channel
        The animated ones.
    fallbacks : tuple of Fallback
        Segments that are slerped because their geodesic was not found.
    """

    channels: Mapping[str, Channel]
    fallbacks: tuple[Fallback, ...]
    helps: tuple[Help, ...] = ()


def resample(
    clip: SkelClip,
    codes: np.ndarray,
    scheme: str,
    metric: LearnedMetric | None = None,
    library: Library | None = None,
    advance: Callable[[float], None] = lambda share: None,
) -> Resampled:
    """Interpolate a clip.

    Every channel keeps its own samples bit for bit, whatever samples other channels have. An element that is the same
    in two neighbouring samples stays the same between them, and all are held until the end of a cut. Value blocks stay
    where they are, and nothing is written into them.

    Parameters
    ----------
    clip : SkelClip
    codes : array-like, shape=[F]
        Increasing, all samples of the clip among them.
    scheme : str
        A name in `SCHEMES`. Blend shape weights are always interpolated linearly.
    metric : LearnedMetric
        Joints of the skeleton for which it has no entry get the identity.
        Optional, default: the bi-invariant metric.
    library : Library
        For the scheme "learned".
        Optional, default: none.
    advance : callable
        Told the share of the work done since it was called last.
        Optional, default: nobody is told.

    Returns
    -------
    resampled : Resampled

    Raises
    ------
    ToolError
        If numbers are beyond what can be computed with.
    """
    if metric is not None:
        metric, _ = metric.for_joints(clip.skeleton.joints)
    animated = {name: channel for name, channel in clip.channels.items() if channel.is_animated}
    filled = {name: held(channel, codes) for name, channel in animated.items()}
    fallbacks: list[Fallback] = []
    helps: list[Help] = []
    n_spans = sum(len(clip.spans(name)) for name in animated)
    weights = animated.pop("blendShapeWeights", None)
    if weights is not None:
        for span in clip.spans(weights.name):
            _fill_linearly(weights, span, filled[weights.name])
            advance(1.0 / n_spans)
    for names in sampled_alike(animated):
        try:
            for span in clip.spans(names[0]):
                help = None
                if library is not None and "rotations" in names:
                    helps.append(_help(clip, names, span, metric, library))
                    help = helps[-1].at_joints(clip.columns)
                for joints in joint_blocks(len(clip.joints), span.stop - span.start):
                    keys = clip.joint_keys(names, span, joints)
                    curve = make_curve(keys, scheme, metric, None if help is None else help.at_joints(joints))
                    fallbacks += curve.fallbacks
                    part = len(names) * (joints.stop - joints.start) / len(clip.joints) / n_spans
                    for share in _fill(clip, names, span, joints, curve, filled):
                        advance(share * part)
        except ValueError as error:
            raise ToolError(f"{clip.path} cannot be interpolated: {error}") from error
    place = {joint: k for k, joint in enumerate(clip.skeleton.joints)}
    fallbacks.sort(key=lambda each: (each.start_time, place[each.joint]))
    return Resampled(filled, tuple(fallbacks), tuple(helps))


def _help(clip: SkelClip, names: Sequence[str], span: slice, metric: LearnedMetric | None, library: Library) -> Help:
    """Return what a library does for all joints of a span, which it needs together."""
    keys = clip.keys(names, span)
    return library.help(keys, curve_parameters(metric, keys))


def sampled_together(clip: SkelClip) -> SkelClip:
    """Sample all animated channels at the same times, as USD shows them; all are blocked where one of them is.

    Parameters
    ----------
    clip : SkelClip

    Returns
    -------
    together : SkelClip
    """
    animated = {name: channel for name, channel in clip.channels.items() if channel.is_animated}
    if len(sampled_alike(animated)) < 2:
        return clip
    shown = resample(without_cuts(clip), clip.codes, "slerp").channels
    live = reduce(np.intersect1d, [channel.codes[~channel.blocked] for channel in shown.values()])
    blocked = ~np.isin(clip.codes, live)
    together = {}
    for name, channel in shown.items():
        values = np.zeros((len(clip.codes), *channel.values.shape[1:]), dtype=channel.values.dtype)
        values[~blocked] = channel.values[np.isin(channel.codes, live)]
        together[name] = replace(channel, codes=clip.codes, values=values, blocked=blocked)
    return replace(clip, channels={**clip.channels, **together}, given_cuts=clip.cuts)


def without_cuts(clip: SkelClip) -> SkelClip:
    """Return a clip whose motion leads through every jump, as USD shows it."""
    return replace(clip, given_cuts=np.zeros((0, 2)))


def animation_of(clip: SkelClip) -> Animation:
    """Make one animation of the whole skeleton, at all samples of a clip that are not blocked, see `sampled_together`.

    Parameters
    ----------
    clip : SkelClip

    Returns
    -------
    animation : Animation
    """
    names = tuple(name for name, channel in clip.channels.items() if channel.is_animated)
    together = sampled_together(clip)
    return together.keys(names, ~together.channels[names[0]].blocked)


def _fill(
    clip: SkelClip, names: Sequence[str], span: slice, joints: slice, curve: Curve, filled: Mapping[str, Channel]
) -> Iterator[float]:
    """Put in-betweens of some joints into arrays that hold the sample before; yield the share done after each chunk."""
    keys = clip.channels[names[0]].codes[span]
    codes = filled[names[0]].codes
    first, stop = np.searchsorted(codes, keys[[0, -1]])
    for a, b in _chunks(np.searchsorted(codes, keys), max(1, CHUNK // curve.animation.n_joints)):
        segment = np.searchsorted(keys, codes[a:b], side="right") - 1
        between = codes[a:b] > keys[segment]
        dense = curve(codes[a:b] / clip.codes_per_second)
        for name in names:
            source = clip.channels[name]
            left = source.values[span, joints][segment]
            values = clip.values_of(name, getattr(dense, name))
            if name == "rotations":
                # A quaternion and its negative are one rotation, and USD interpolates the shorter way whatever the
                # signs, so signs are free in USD. Blender interpolates components: between a sample and its negated
                # neighbour it passes through zero. Samples keep their signs, so where the source flips, one gap must;
                # in-betweens continue from the left, which leaves it the last and short one.
                at_key = np.searchsorted(codes[a:b], keys[segment])
                values = values * signs_towards(left, values[at_key])
            moves = between[:, None] & ~source.holds[span.start : span.stop - 1, joints][segment]
            filled[name].values[a:b, joints][moves] = values[moves]
        yield (b - a) / (stop - first)


def _chunks(keys: np.ndarray, size: int) -> Iterator[tuple[int, int]]:
    """Cut frames at keys, whose places are given, into chunks of about a size."""
    start = 0
    while start < len(keys) - 1:
        stop = max(start + 1, int(np.searchsorted(keys, keys[start] + size, side="right")) - 1)
        yield int(keys[start]), int(keys[stop])
        start = stop


def signs_towards(reference: np.ndarray, quaternions: np.ndarray) -> np.ndarray:
    """Return the signs, shape=[F, N, 1], with which quaternions, shape=[F, N, 4], are nearer to a reference."""
    dots = np.einsum("fnc,fnc->fn", quaternions, reference.astype(np.float64))
    return np.where(dots < 0.0, -1.0, 1.0)[..., None]


def _fill_linearly(source: Channel, span: slice, filled: Channel) -> None:
    """Put linear in-betweens of a span into an array that holds the sample before."""
    keys, values = source.codes[span], source.values[span].astype(np.float64)
    inside = (filled.codes > keys[0]) & (filled.codes < keys[-1]) & ~np.isin(filled.codes, keys)
    codes = filled.codes[inside]
    segment = np.searchsorted(keys, codes, side="right") - 1
    weight = ((codes - keys[segment]) / np.diff(keys)[segment])[:, None, None]
    filled.values[inside] = (1.0 - weight) * values[segment] + weight * values[segment + 1]
