"""The clips that a verb leads curves through: those that move, with the cuts and schemes that are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim.names import DEFAULT_SCHEME, LEARNABLE, LEARNED, WITH_METRIC
from usd_tools.console.errors import Messages, ToolError
from usd_tools.skel.clip import SkelClip, read_clips
from usd_tools.skel.find import AnimationSource
from usd_tools.skel.resampling import without_cuts
from usd_tools.upsampling.metric import ChosenMetric
from usd_tools.upsampling.options import CurveOptions, StyleOptions

if TYPE_CHECKING:
    from usd_tools.libraries.files import LibraryFile

MAX_ROTATIONS = 1 << 27
"""More than these are taken for a slip of the finger: 2 GiB of quaternions."""

_STYLES = ("alpha", "beta", "invariance", "tension", "translation_tension", "joint")


def check_size(clip: SkelClip, n_samples: float, word: str) -> None:
    """Refuse an option, named by its word, that asks for more samples than anybody can mean.

    Raises
    ------
    ToolError
    """
    size = n_samples * max(1, clip.skeleton.n_joints)
    if size > MAX_ROTATIONS:
        raise ToolError(f"--{word} would create {size:.3g} rotations for {clip.path}; ask for fewer.")


def animated_clips(path: Path, sources: list[AnimationSource], messages: Messages) -> list[SkelClip]:
    """Read the animations, and keep those that move.

    Raises
    ------
    ToolError
        If none can be read, or none moves.
    """
    clips = read_clips(sources, messages)
    for clip in clips:
        for note in clip.notes:
            messages.warn(note)
    animated = [clip for clip in clips if clip.is_animated]
    if not animated:
        counts = (
            f"{clip.path} has {max((len(channel.codes) for channel in clip.channels.values()), default=0)}"
            for clip in clips
        )
        raise ToolError(f"{path} has no skeletal animation with at least two samples: {', '.join(counts)}.")
    return animated


def with_cuts(clips: Sequence[SkelClip], options: CurveOptions) -> list[SkelClip]:
    """Take the cuts that are asked for, if any are.

    Raises
    ------
    ToolError
        If one of them is between no two samples.
    """
    if options.no_cuts:
        return [without_cuts(clip) for clip in clips]
    if options.cut is None or options.cut.codes is None:
        return list(clips)
    wanted = np.unique(options.cut.codes)
    inside = [wanted[(wanted > clip.codes[0]) & (wanted <= clip.codes[-1])] for clip in clips]
    outside = np.setdiff1d(wanted, np.concatenate(inside))
    if len(outside):
        ranges = ", ".join(f"{clip.path} from {clip.codes[0]:g} to {clip.codes[-1]:g}" for clip in clips)
        raise ToolError(f"--cut {outside[0]:g} is between no two samples; there is {ranges}.")
    after = [np.searchsorted(clip.codes, codes) for clip, codes in zip(clips, inside, strict=True)]
    return [
        replace(clip, given_cuts=np.stack([clip.codes[end - 1], clip.codes[end]], axis=-1))
        for clip, end in zip(clips, after, strict=True)
    ]


def read_library(options: CurveOptions) -> LibraryFile | None:
    """Read the library that is asked for, if one is.

    Raises
    ------
    ToolError
        If it cannot be read, or is broken.
    """
    if options.library is None:
        return None
    from usd_tools.libraries.files import LibraryFile

    return LibraryFile.read(options.library)


def check_schemes(options: CurveOptions, clips: Sequence[SkelClip], metrics: Sequence[ChosenMetric]) -> None:
    """Refuse options about a metric where the scheme, asked for or stored, has none, and a scheme without its library.

    Raises
    ------
    ToolError
    """
    for clip, chosen in zip(clips, metrics, strict=True):
        if chosen.metric.scheme == LEARNED and chosen.library is None:
            raise ToolError(
                f"{clip.path}: the metric names the scheme {LEARNED}, which needs {_library_of(chosen.metric)}; give "
                f"it as --library, or choose --scheme {DEFAULT_SCHEME}."
            )
    check_styles_count(options, clips, [chosen.metric for chosen in metrics])


def check_styles_count(options: StyleOptions, clips: Sequence[SkelClip], metrics: Sequence[LearnedMetric]) -> None:
    """Refuse options about a metric that the scheme, asked for or stored, does not have.

    Raises
    ------
    ToolError
    """
    # A scheme may be stored with a metric, and then be asked for by its name.
    words = _STYLES if options.scheme is None else ("metric", *_STYLES)
    given = [f"--{word.replace('_', '-')}" for word in words if getattr(options, word) not in (None, ())]
    for clip, metric in zip(clips, metrics, strict=True):
        if given and metric.scheme not in WITH_METRIC:
            raise ToolError(
                f"{clip.path}: the scheme {metric.scheme} has no metric; leave out {', '.join(given)}, or use "
                f"--scheme {' or '.join(LEARNABLE)}."
            )
        if metric.scheme == "geodesic" and any(style.has_tension for style in options.styles):
            raise ToolError(
                f"{clip.path}: the scheme geodesic has no tension; leave out tensions, or use --scheme geodesic-spline."
            )


def _library_of(metric: LearnedMetric) -> str:
    """Name the library that a metric was used with."""
    used = metric.provenance.get("library")
    return f"the library {used['file']}" if isinstance(used, dict) and "file" in used else "a library"
