"""Interpolate several clips, each with its metric, with one progress."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import Resampled, resample
from usd_tools.upsampling.metric import ChosenMetric


def interpolated(
    clips: Sequence[SkelClip],
    targets: Sequence[np.ndarray],
    metrics: Sequence[ChosenMetric],
    progress: ProgressCallback | None,
) -> list[Resampled]:
    """Interpolate clips at time codes, each with its metric; see `resample`."""
    work = [len(codes) * max(1, len(clip.joints)) for clip, codes in zip(clips, targets, strict=True)]
    bar = Progress(progress, sum(work), "Interpolating")
    results = []
    for clip, codes, chosen, amount in zip(clips, targets, metrics, work, strict=True):

        def advance(share: float, amount: int = amount) -> None:
            bar.advance(share * amount)

        results.append(resample(clip, codes, chosen.metric.scheme, chosen.metric, chosen.library, advance))
    return results
