"""Find the time codes that a command asks for, those of a downsampled animation's source among them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usd_tools.console.arguments import SOURCE, TimeCodes
from usd_tools.console.errors import Messages, ToolError
from usd_tools.metrics.attributes import read_source_codes
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.source_codes import stored_source_codes


def codes_for(clip: SkelClip, wanted: TimeCodes) -> np.ndarray:
    """Return the time codes that are asked for of an animation, shape=[F].

    Raises
    ------
    ToolError
        If they are those of its source, which it does not store, or its samples are elsewhere now.
    """
    if wanted.codes is not None:
        return np.array(wanted.codes)
    stored = stored_source_codes(clip.source.prim, clip.codes)
    if stored is None:
        raise ToolError(
            f"--times {SOURCE}: {clip.path} does not store the time codes of its source; list time codes, or run "
            "usd_tools.downsample, which stores them."
        )
    if stored.n_found <= len(clip.codes) / 2.0:
        raise ToolError(
            f"--times {SOURCE}: {stored.n_found} of the {len(clip.codes)} samples of {clip.path} are where "
            "usd_tools.downsample left them; list time codes instead."
        )
    return stored.codes


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
    stored = stored_source_codes(clip.source.prim, clip.codes)
    n_kept = min((len(channel.codes) for channel in clip.channels.values() if channel.is_animated), default=0)
    if stored is None or len(stored.codes) <= n_kept:
        return []
    return [
        f"{clip.path} is downsampled to {n_kept} of {len(stored.codes)} samples, and only these are used; run "
        "usd_tools.upsample --times source first to restore the others."
    ]
