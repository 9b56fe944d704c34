"""What `upsample` says of its work: lines on stdout, warnings on stderr, and plain values for the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from geomstats_anim.interpolation.curves import Fallback
from usd_tools.console.errors import Messages
from usd_tools.console.text import counted
from usd_tools.metrics.attributes import summary
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.resampling import Resampled
from usd_tools.skel.rotation_checks import WIDE_DEGREES, largest_step, rotation_steps, wide_steps
from usd_tools.upsampling.metric import EffectiveMetric


@dataclass(frozen=True, eq=False)
class Job:
    """One animation: what is there, where samples go, with which metric, and the result."""

    clip: SkelClip
    codes: np.ndarray
    effective: EffectiveMetric
    result: Resampled


def tell(job: Job, verbose: bool, messages: Messages) -> None:
    """Say on stdout what happens to an animation, and on stderr what went wrong."""
    clip, metric = job.clip, job.effective.metric
    how = _how(job.effective) if clip.joints else "blend shapes, linear"
    joints = counted(len(clip.joints), "joint")
    print(f"{clip.path}: {_growth(job)}, {joints}; {how}")
    for sentence in _fallback_sentences(clip, job.result.fallbacks):
        messages.warn(sentence)
    for sentence in _wide_sentences(clip, verbose):
        messages.warn(sentence)
    if verbose:
        print(f"  drives {', '.join(str(prim.GetPath()) for prim in clip.source.skeletons) or 'no skeleton'}")
        if job.effective.is_used:
            print(f"  {summary(metric)}")
        for name, channel in clip.channels.items():
            after = len(job.result.channels[name].codes) if name in job.result.channels else len(channel.codes)
            print(f"  {name}: {len(channel.codes)} -> {after} samples")


def _how(effective: EffectiveMetric) -> str:
    if not effective.is_used:
        return effective.metric.scheme
    styles = ", styled" if "styles" in effective.metric.provenance else ""
    return f"{effective.metric.scheme}, {effective.origin} metric{styles}"


def _growth(job: Job) -> str:
    """Tell the samples before and after; channel by channel where they differ, as in what is only partly sparse."""
    growth: dict[tuple[int, int], list[str]] = {}
    for name, channel in job.result.channels.items():
        growth.setdefault((len(job.clip.channels[name].codes), len(channel.codes)), []).append(name)
    if len(growth) > 1:
        return ", ".join(f"{a} -> {b} samples of {' and '.join(names)}" for (a, b), names in growth.items())
    clip = job.clip
    rates = f"{clip.samples_per_second():g} -> {clip.samples_per_second(job.codes):g} a second"
    return f"{len(clip.codes)} -> {len(job.codes)} samples, {rates}"


def _fallback_sentences(clip: SkelClip, fallbacks: Sequence[Fallback]) -> list[str]:
    """Name every slerped segment, one sentence a joint and reason."""
    segments: dict[tuple[str, str], list[str]] = {}
    for fallback in fallbacks:
        start, end = (time * clip.codes_per_second for time in (fallback.start_time, fallback.end_time))
        segments.setdefault((fallback.joint, fallback.status.sentence), []).append(f"{start:g} to {end:g}")
    return [
        f"{clip.path}: joint {joint} is slerped from time code {', '.join(where)}: {reason}"
        for (joint, reason), where in segments.items()
    ]


def _wide_sentences(clip: SkelClip, verbose: bool) -> list[str]:
    """Name the steps of which a file cannot tell the way: all of them, or the widest."""
    steps = sorted(wide_steps(clip, rotation_steps(clip)), key=lambda step: -step.degrees)
    told = steps if verbose else steps[:1]
    are = "is" if len(steps) == 2 else "are"
    more = (
        f", and {counted(len(steps) - 1, 'other step')} {are} over {WIDE_DEGREES:g}" if len(steps) > len(told) else ""
    )
    beyond = "beyond 180 degrees a file cannot tell which way round it went; the shorter way is taken."
    return [f"{clip.path}: {step}{more}; {beyond}" for step in told]


def described(job: Job) -> dict[str, Any]:
    """Tell what was done to an animation, as plain values."""
    clip, degrees = job.clip, rotation_steps(job.clip)
    largest = largest_step(clip, degrees)
    return {
        "prim": clip.path,
        "skeletons": [str(prim.GetPath()) for prim in clip.source.skeletons],
        "joints": len(clip.joints),
        "scheme": job.effective.metric.scheme,
        "metric": job.effective.origin if job.effective.is_used else None,
        "metric_summary": summary(job.effective.metric) if job.effective.is_used else None,
        "joints_without_metric": list(job.effective.missing),
        "samples_before": len(clip.codes),
        "samples_after": len(job.codes),
        "rate_before": clip.samples_per_second(),
        "rate_after": clip.samples_per_second(job.codes),
        "first_time_code": float(clip.codes[0]),
        "last_time_code": float(clip.codes[-1]),
        "channels": {
            name: {
                "samples_before": len(clip.channels[name].codes),
                "samples_after": len(channel.codes),
                "value_blocks": int(channel.blocked.sum()),
            }
            for name, channel in job.result.channels.items()
        },
        "stepped_pairs": int(clip.steps.sum()),
        "largest_step": None if largest is None else asdict(largest),
        "wide_steps": [asdict(step) for step in wide_steps(clip, degrees)],
        "fallbacks": [
            {
                "joint": fallback.joint,
                "start": fallback.start_time * clip.codes_per_second,
                "end": fallback.end_time * clip.codes_per_second,
                "status": fallback.status.name,
                "sentence": fallback.status.sentence,
            }
            for fallback in job.result.fallbacks
        ],
    }
