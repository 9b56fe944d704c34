"""Find the time codes that a command asks for, those of a downsampled animation's source among them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usd_tools.console.arguments import SOURCE, TimeCodes
from usd_tools.console.errors import Messages, ToolError
from usd_tools.metrics.attributes import read_source_codes
from usd_tools.skel.clip import SkelClip


def codes_for(clip: SkelClip, wanted: TimeCodes) -> np.ndarray:
    """Return the time codes that are asked for of an animation, shape=[F].

    Raises
    ------
    ToolError
        If they are those of its source, which it does not store, or its samples are elsewhere now.
    """
    if wanted.codes is not None:
        return np.array(wanted.codes)
    stored = _source_codes(clip)
    if stored is None:
        raise ToolError(
            f"--times {SOURCE}: {clip.path} does not store the time codes of its source; list time codes, or run "
            "usd_tools.downsample, which stores them."
        )
    codes, n_found = stored
    if n_found <= len(clip.codes) / 2.0:
        raise ToolError(
            f"--times {SOURCE}: {n_found} of the {len(clip.codes)} samples of {clip.path} are where "
            "usd_tools.downsample left them; list time codes instead."
        )
    return codes


def clips_with_source_codes(clips: Sequence[SkelClip], messages: Messages) -> list[SkelClip]:
    """Keep the clips that store where their source had samples; all of them if none does, an error of `codes_for`.

    Parameters
    ----------
    clips : sequence of SkelClip
    messages : Messages
        Told of the others.
    """
    found = [clip for clip in clips if read_source_codes(clip.source.prim) is not None]
    for clip in clips:
        if found and clip not in found:
            messages.warn(f"{clip.path} does not store the time codes of its source; it is left unchanged.")
    return found or list(clips)


def left_sparse(clip: SkelClip) -> list[str]:
    """Return a note on an animation that `usd_tools.downsample` made sparse and nobody has rebuilt; none on others."""
    stored = _source_codes(clip)
    n_kept = min((len(channel.codes) for channel in clip.channels.values() if channel.is_animated), default=0)
    if stored is None or len(stored[0]) <= n_kept:
        return []
    return [
        f"{clip.path} is sparse: it keeps {n_kept} of {len(stored[0])} samples, only these are looked at, "
        "and with another metric the rest cannot be rebuilt; run usd_tools.upsample --times source first."
    ]


def _source_codes(clip: SkelClip) -> tuple[np.ndarray, int] | None:
    """Return the time codes of a source's samples in a clip's range, and how many of the clip's are among them."""
    codes = read_source_codes(clip.source.prim)
    if codes is None or not len(clip.codes):
        return None
    # A layer offset moves samples, and not the numbers of an attribute; who trims or extends a clip moves neither.
    first, last = clip.codes[0], clip.codes[-1]
    stretch = (last - first) / (codes[-1] - codes[0]) if codes[-1] > codes[0] else 1.0
    candidates = [codes, np.clip(first + (codes - codes[0]) * stretch, first, last)]
    found = [_n_among(clip.codes, each) for each in candidates]
    best = int(np.argmax(found))
    return candidates[best][(candidates[best] >= first) & (candidates[best] <= last)], found[best]


def _n_among(samples: np.ndarray, codes: np.ndarray) -> int:
    """Count samples that are at one of some increasing time codes, but for rounding."""
    near = 1e-3 * float(np.diff(codes).min(initial=1.0))
    after = np.searchsorted(codes, samples - near)
    return int((codes[np.minimum(after, len(codes) - 1)] <= samples + near)[after < len(codes)].sum())
