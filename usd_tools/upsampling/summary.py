"""Describe the work of `upsample`: lines on stdout, warnings, and plain values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim.interpolation.curves import Fallback
from usd_tools.console.text import counted, say, short_names
from usd_tools.libraries.help import help_sentence, shares
from usd_tools.metrics.attributes import summary
from usd_tools.skel.channels import Channel
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.rate_advice import written_at
from usd_tools.skel.resampling import Resampled
from usd_tools.skel.rotation_checks import WIDE_DEGREES, largest_step, rotation_steps, wide_steps
from usd_tools.skel.xforms import XformOp
from usd_tools.upsampling.metric import ChosenMetric
from usd_tools.upsampling.result import KeptContacts, UpsampledAnimation, UpsampleResult

_NAMED_CUTS = 5
"""Cuts that are named; the report lists all."""

_NAMED_JOINTS = 6
"""Likewise, of joints that are planted."""


@dataclass(frozen=True, eq=False)
class UpsampledClip:
    """One animation: its source, where its samples go, the metric, the new samples, and those of transform ops."""

    clip: SkelClip
    codes: np.ndarray
    chosen: ChosenMetric
    result: Resampled
    xforms: tuple[tuple[XformOp, Channel], ...] = ()
    contacts: KeptContacts | None = None

    @cached_property
    def degrees(self) -> np.ndarray:
        """Turns from each sample of the source to the next; see `rotation_steps`."""
        return rotation_steps(self.clip)

    @property
    def library(self) -> dict[str, Any] | None:
        """The library that was used: file, sha256, and its share by part of the body; None for other schemes."""
        file = self.chosen.library_file
        return None if file is None else {"file": file.name, "sha256": file.sha256, "shares": shares(self.result.helps)}

    @property
    def metric(self) -> LearnedMetric:
        """The metric as it is stored, with the library that was used."""
        metric, used = self.chosen.metric, self.library
        rest = {name: value for name, value in metric.provenance.items() if name != "library"}
        return replace(metric, provenance=rest if used is None else {**rest, "library": used})


def warnings_of(upsampled: UpsampledClip, verbose: bool, stretch: float = 1.0) -> list[str]:
    """Return what went wrong, or may have; time codes are multiplied by `stretch`, as in `describe`."""
    clip = upsampled.clip
    return [
        *_fallback_sentences(clip, upsampled.result.fallbacks, stretch),
        *_wide_sentences(upsampled, verbose, stretch),
        *_cut_sentences(clip, stretch),
    ]


def print_summary(result: UpsampleResult, verbose: bool) -> None:
    """Print a line for each animation, and one on what was written."""
    for animation in result.animations:
        _print_animation(animation, verbose)
    if result.path is None:
        say("Dry run: nothing was written.")
        return
    retimed = result.settings.get("retime") and not result.advice
    wrote = written_at(result.path, result.time_codes_per_second) if retimed else f"Wrote {result.path}."
    say(" ".join(filter(None, (wrote, result.advice, result.dependencies))))


def _print_animation(animation: UpsampledAnimation, verbose: bool) -> None:
    if animation.learned:
        say(animation.learned)
    if animation.library is not None:
        say(f"{animation.prim}: {help_sentence(animation.library)}")
    how = _how(animation) if animation.joints else "blend shapes, linear"
    transforms = f", {counted(len(animation.xforms), 'transform')}" if animation.xforms else ""
    say(f"{animation.prim}: {_growth(animation)}, {counted(animation.joints, 'joint')}{transforms}; {how}")
    if animation.contacts is not None:
        say(f"  {_contacts(animation.contacts)}")
    if verbose:
        say(f"  drives {', '.join(animation.skeletons) or 'no skeleton'}")
        if animation.metric_summary is not None:
            say(f"  {animation.metric_summary}")
        for name, channel in animation.channels.items():
            say(f"  {name}: {channel['samples_before']} -> {channel['samples_after']} samples")
        for xform in animation.xforms:
            say(f"  {xform['attribute']}: {xform['samples_before']} -> {xform['samples_after']} samples")


def _contacts(contacts: KeptContacts) -> str:
    """Return what was kept on the ground, in words."""
    if not contacts.joints:
        return "contacts: nothing is planted on the ground between two samples"
    names = short_names(contacts.joints)
    named = ", ".join(names[joint] for joint in contacts.joints[:_NAMED_JOINTS])
    more = f" and {len(contacts.joints) - _NAMED_JOINTS} more" if len(contacts.joints) > _NAMED_JOINTS else ""
    left = f"; {counted(contacts.left, 'time')} left to lift" if contacts.left else ""
    return (
        f"contacts: {named}{more} stay planted, {counted(contacts.kept, 'time')}{left}; moved by at most "
        f"{contacts.largest_cm:.1f} cm, joints turned by {contacts.largest_degrees:.1f} degrees"
    )


def _how(animation: UpsampledAnimation) -> str:
    if animation.metric is None:
        return animation.scheme
    if not animation.styles:
        return f"{animation.scheme}, {animation.metric} metric"
    styles = "; ".join(map(_style, animation.styles))
    if animation.metric == "identity":
        return f"{animation.scheme}, custom metric: {styles}"
    return f"{animation.scheme}, {animation.metric} metric with {styles}"


def _style(text: str) -> str:
    """Write a style as words: "alpha 4, beta .5", or "arm* alpha 4" where it is for some joints."""
    pattern, _, settings = text.rpartition(":")
    words = settings.replace("=0.", "=.").replace("=", " ").replace(",", ", ")
    return words if pattern == "*" else f"{pattern} {words}"


def _growth(animation: UpsampledAnimation) -> str:
    """Return the samples before and after; of each channel where they differ, as in what is only partly sparse."""
    growth: dict[tuple[int, int], list[str]] = {}
    for name, channel in animation.channels.items():
        growth.setdefault((channel["samples_before"], channel["samples_after"]), []).append(name)
    if len(growth) > 1:
        return ", ".join(f"{a} -> {b} samples of {' and '.join(names)}" for (a, b), names in growth.items())
    rates = f"{animation.rate_before:g} -> {animation.rate_after:g} per second"
    return f"{animation.samples_before} -> {animation.samples_after} samples, {rates}"


def _fallback_sentences(clip: SkelClip, fallbacks: Sequence[Fallback], stretch: float) -> list[str]:
    """Name every slerped segment, one sentence a joint and reason."""
    names = short_names(clip.joints)
    segments: dict[tuple[str, str], list[str]] = {}
    for fallback in fallbacks:
        start, end = (time * clip.codes_per_second * stretch for time in (fallback.start_time, fallback.end_time))
        segments.setdefault((fallback.joint, str(fallback.status)), []).append(f"{start:g} to {end:g}")
    return [
        f"{clip.path}: joint {names[joint]} uses slerp from time code {', '.join(where)}. {reason}"
        for (joint, reason), where in segments.items()
    ]


def _wide_sentences(upsampled: UpsampledClip, verbose: bool, stretch: float) -> list[str]:
    """Name the steps of which a file cannot tell the way: all of them, or the widest."""
    clip = upsampled.clip
    steps = sorted(wide_steps(clip, upsampled.degrees), key=lambda step: -step.degrees)
    told = [step.stretched(stretch) for step in (steps if verbose else steps[:1])]
    are = "is" if len(steps) == 2 else "are"
    more = (
        f", and {counted(len(steps) - 1, 'other step')} {are} over {WIDE_DEGREES:g}" if len(steps) > len(told) else ""
    )
    beyond = "a file cannot store which way a turn beyond 180 degrees went, so the shorter way is used."
    names = short_names(clip.joints)
    return [f"{clip.path}: {step.in_words(names)}{more}; {beyond}" for step in told]


def _cut_sentences(clip: SkelClip, stretch: float) -> list[str]:
    """Name the cuts that were found."""
    if clip.given_cuts is not None or not len(clip.cuts):
        return []
    where = [f"{start:g} to {end:g}" for start, end in clip.cuts[:_NAMED_CUTS] * stretch]
    more = f" and {len(clip.cuts) - len(where)} more" if len(clip.cuts) > len(where) else ""
    return [
        f"{clip.path}: the pose jumps from time code {', '.join(where)}{more}, so it is held there as at a cut; use "
        "--no-cuts to interpolate across, or --cut to set the cuts."
    ]


def describe(upsampled: UpsampledClip, stretch: float = 1.0) -> UpsampledAnimation:
    """Return what was done to an animation, as plain values.

    Parameters
    ----------
    upsampled : UpsampledClip
    stretch : float
        Time codes of the output for one of the source.
        Optional, default: 1.

    Returns
    -------
    animation : UpsampledAnimation
        With time codes of the output.
    """
    clip, chosen, degrees = upsampled.clip, upsampled.chosen, upsampled.degrees
    largest = largest_step(clip, degrees)
    styles = chosen.metric.provenance.get("styles", ())
    return UpsampledAnimation(
        prim=clip.path,
        skeletons=tuple(str(prim.GetPath()) for prim in clip.source.skeletons),
        joints=len(clip.joints),
        scheme=chosen.metric.scheme,
        metric=chosen.origin if chosen.is_used else None,
        metric_summary=summary(chosen.metric) if chosen.is_used else None,
        styles=tuple(styles) if chosen.is_used and isinstance(styles, list) else (),
        learned=chosen.learned,
        library=upsampled.library,
        joints_without_metric=chosen.missing,
        samples_before=len(clip.codes),
        samples_after=len(upsampled.codes),
        rate_before=clip.samples_per_second(),
        rate_after=clip.samples_per_second(upsampled.codes),
        first_time_code=float(clip.codes[0] * stretch),
        last_time_code=float(clip.codes[-1] * stretch),
        channels={
            name: {
                "samples_before": len(clip.channels[name].codes),
                "samples_after": len(channel.codes),
                "value_blocks": int(channel.blocked.sum()),
            }
            for name, channel in upsampled.result.channels.items()
        },
        stepped_pairs=int(clip.steps.sum()),
        cuts=tuple({"start": start, "end": end} for start, end in (clip.cuts * stretch).tolist()),
        xforms=tuple(
            {
                "attribute": str(op.attribute.GetPath()),
                "samples_before": len(op.channel.codes),
                "samples_after": len(channel.codes),
            }
            for op, channel in upsampled.xforms
        ),
        largest_step=None if largest is None else asdict(largest.stretched(stretch)),
        wide_steps=tuple(asdict(step.stretched(stretch)) for step in wide_steps(clip, degrees)),
        fallbacks=tuple(
            {
                "joint": fallback.joint,
                "start": fallback.start_time * clip.codes_per_second * stretch,
                "end": fallback.end_time * clip.codes_per_second * stretch,
                "status": fallback.status.name,
                "sentence": str(fallback.status),
            }
            for fallback in upsampled.result.fallbacks
        ),
        contacts=upsampled.contacts,
    )
