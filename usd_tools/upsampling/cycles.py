"""Interpolate clips that are loops, with curves that lead across the seam."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from usd_tools.console.errors import Messages
from usd_tools.console.progress import ProgressCallback
from usd_tools.console.text import short_names
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.loops import Loop, closed_cycle, closed_op, cropped, extended_cycle, extended_op
from usd_tools.skel.resampling import Resampled
from usd_tools.skel.xforms import XformOp, resample_op
from usd_tools.upsampling.interpolation import interpolated
from usd_tools.upsampling.metric import ChosenMetric

SMALL = 0.5
"""Degrees by which a loop may miss without being named."""


END = 1e-6
"""Time codes by which what is before the end of a cycle is before it."""


class Cycles:
    """Clips that are loops.

    Parameters
    ----------
    clips : sequence of SkelClip
    messages : Messages
        Told by how much a loop misses.

    Attributes
    ----------
    closed : list of SkelClip
        That end with their first pose.
    loops : list of Loop

    Raises
    ------
    ToolError
        If one is no loop.
    """

    def __init__(self, clips: Sequence[SkelClip], messages: Messages) -> None:
        found = [closed_cycle(clip) for clip in clips]
        self.closed: list[SkelClip] = [clip for clip, _ in found]
        self.loops: list[Loop] = [loop for _, loop in found]
        for clip, loop in found:
            if loop.closed and loop.degrees > SMALL:
                joint = short_names(clip.joints)[loop.joint]
                messages.warn(
                    f"{clip.path}: joint {joint} misses a loop by {loop.degrees:.1f} degrees, which stays in the step "
                    "across the seam."
                )

    def before_end(self, k: int, codes: np.ndarray) -> np.ndarray:
        """Leave out, of time codes of the clip number k, its first pose at the end if that is not its own."""
        return codes if self.loops[k].closed else codes[codes < self.closed[k].codes[-1] - END]

    def interpolated(
        self,
        targets: Sequence[np.ndarray],
        metrics: Sequence[ChosenMetric],
        progress: ProgressCallback | None,
        prepare: Callable[[SkelClip], SkelClip] = lambda clip: clip,
    ) -> list[Resampled]:
        """Do as `interpolated`; `prepare` changes the clips, repeated beyond both ends, before."""
        extended = [prepare(extended_cycle(clip)) for clip in self.closed]
        codes = [np.union1d(clip.codes, own) for clip, own in zip(extended, targets, strict=True)]
        results = interpolated(extended, codes, metrics, progress)
        return [
            replace(
                dense,
                channels={name: cropped(channel, own[0], own[-1]) for name, channel in dense.channels.items()},
                fallbacks=tuple(
                    fallback
                    for fallback in dense.fallbacks
                    if own[0] <= fallback.start_time * clip.codes_per_second < own[-1]
                ),
            )
            for dense, own, clip in zip(results, targets, extended, strict=True)
        ]

    def resample_op(self, k: int, op: XformOp, codes: np.ndarray, scheme: str, cuts: np.ndarray) -> Channel:
        """Do as `resample_op` with an op of the clip number k; one with another range is led across no seam."""
        clip, loop = self.closed[k], self.loops[k]
        last = clip.codes[-1] if loop.closed else clip.codes[-2]
        channel, rate = op.channel, clip.codes_per_second
        if channel.blocked.any() or channel.codes[[0, -1]].tolist() != [clip.codes[0], last]:
            return resample_op(op, codes, rate, scheme, cuts)
        return cropped(resample_op(extended_op(closed_op(op, clip, loop)), codes, rate, scheme, cuts), *codes[[0, -1]])
