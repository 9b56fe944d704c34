"""One animation made sparse: which samples stay, the metric that rebuilds the others, and how well it does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd

from geomstats_anim import Animation, LearnedMetric, __version__, compress, interpolate, quality, uniform_keyframes
from geomstats_anim.keyframes.problem import KeyProblem, by_halving
from geomstats_anim.learning.compression import Compressed
from geomstats_anim.markers import Markers, world_errors
from geomstats_anim.names import LARGEST
from usd_tools.characters.planted import contacts_to_store
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import SearchProgress
from usd_tools.downsampling.measure import Measure
from usd_tools.downsampling.options import DownsampleOptions
from usd_tools.downsampling.thinning import Errors, SampleSelection, restored, sampled_alike
from usd_tools.downsampling.weights import WEIGHTS, thinned_weights, weights_error
from usd_tools.files.stages import stage_sha256
from usd_tools.metrics.attributes import read_source_codes
from usd_tools.metrics.explain import BY_JOINT, errors_by_joint
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.stored_contacts import StoredContacts
from usd_tools.skel.stored_metric import stored_metric
from usd_tools.skel.time_codes import codes_for, left_sparse

_ROUNDING = 1e-2
"""Share of a tolerance that is left to the rounding of what is written, at most."""

_ROUNDING_METRES = 5e-6


@dataclass(frozen=True, eq=False)
class DownsampledClip:
    """An animation made sparse.

    Parameters
    ----------
    selection : SampleSelection
        The source, and what there was to choose from.
    sparse : SkelClip
        What is written.
    metric : LearnedMetric
    errors : Errors
        Of what `usd_tools.upsample --times source` rebuilds.
    played : Errors
        Of what viewers show: slerp.
    uniform : list of array-like of int
        Frames of each stretch that slerp needs to be as good, equally spaced.
    criterion : str
        What "as good" means: a kind of quality, or "max".
    path : str
        Path of the SkelAnimation.
    skeleton_paths : tuple of str
        Paths of the Skeletons that it drives; prims are gone when what is written changes the composition.
    measure : Measure
    weights_error : float or None
        Largest error of the weights of blend shapes, rebuilt; None if they never change.
    contacts : StoredContacts or None
        What is planted on the ground; None if it is not to be stored.
    """

    selection: SampleSelection
    sparse: SkelClip
    metric: LearnedMetric
    errors: Errors
    played: Errors
    uniform: list[np.ndarray]
    criterion: str
    path: str
    skeleton_paths: tuple[str, ...]
    measure: Measure
    weights_error: float | None
    contacts: StoredContacts | None

    @property
    def clip(self) -> SkelClip:
        """The source."""
        return self.selection.clip

    @property
    def kept(self) -> np.ndarray:
        """Time codes of the samples that are left of those that were chosen from."""
        names = self.selection.names
        return self.sparse.channels[names[0]].codes if names else self.sparse.codes


def downsample_clip(
    path: Path,
    clip: SkelClip,
    options: DownsampleOptions,
    messages: Messages,
    progress: SearchProgress,
) -> DownsampledClip | None:
    """Choose the samples of an animation to keep, and learn the metric for them.

    Parameters
    ----------
    path : Path
        File that it is in.
    clip : SkelClip
    options : DownsampleOptions
    messages : Messages
        Told what a user should know.
    progress : SearchProgress
        Told of the choice of samples and of the search for a metric.

    Returns
    -------
    downsampled : DownsampledClip or None
        None if there are no samples to choose from.

    Raises
    ------
    ToolError
        If the options do not fit the animation.
    """
    clip = sampled_alike(clip)
    for note in (*clip.notes, *left_sparse(clip)):
        messages.warn(note)
    if not clip.is_animated:
        return None
    if options.tolerance is not None and clip.joints and not clip.source.rig:
        raise ToolError(
            f"{clip.path} has no skeleton, so --tolerance cannot be measured; bind it to its skeleton, or use --rate."
        )
    wanted = options.keep or options.keep_only
    keep = np.zeros(0) if wanted is None else codes_for(clip, wanted)
    selection = SampleSelection.of(clip, thinned_weights(clip, options.weights_tolerance, keep))
    if selection.kept_whole:
        messages.warn(
            f"{clip.path}: {' and '.join(selection.kept_whole)} change and are kept whole, since no error is defined "
            "for them."
        )
    animations = selection.animations
    measure = Measure(clip, options)
    allowance = None if options.tolerance is None else 0.01 * options.tolerance
    margin = 0.0 if allowance is None else min(_ROUNDING_METRES, _ROUNDING * allowance)
    while True:
        try:
            compressed = _compressed(
                clip, selection, animations, options, keep, measure.few, allowance and allowance - margin, progress
            )
        except ValueError as error:
            raise ToolError(f"{clip.path} cannot be downsampled with these options: {error}") from error
        sparse = selection.sparse(compressed.keyframes)
        dense = restored(sparse, compressed.metric, clip.codes)
        errors = measure.errors(dense, clip)
        over = 0.0 if options.tolerance is None else errors.largest - options.tolerance
        if over <= 0.0:
            break
        if measure.add_missed(animation_of(dense), animation_of(clip), allowance or 0.0):
            continue
        margin += 0.02 * over  # what is written is rounded, and other channels have a part in it
    played = measure.errors(restored(sparse, compressed.metric, clip.codes, "slerp"), clip)
    metric = replace(compressed.metric, provenance=_provenance(path, clip, sparse, compressed.metric, errors, played))
    uniform = _uniform(animations, errors, options, measure.markers)
    skeletons = tuple(str(prim.GetPath()) for prim in clip.source.skeletons)
    return DownsampledClip(
        selection,
        sparse,
        metric,
        errors,
        played,
        uniform,
        options.criterion,
        clip.path,
        skeletons,
        measure,
        _weights_error(selection, dense),
        contacts_to_store(clip, animations) if options.contacts else None,
    )


def _weights_error(selection: SampleSelection, rebuilt: SkelClip) -> float | None:
    if selection.weights is None:
        return None
    return weights_error(rebuilt.channels[WEIGHTS], selection.clip.channels[WEIGHTS])


def _compressed(
    clip: SkelClip,
    selection: SampleSelection,
    animations: Sequence[Animation],
    options: DownsampleOptions,
    codes: np.ndarray,
    markers: Markers,
    tolerance: float | None,
    progress: SearchProgress,
) -> Compressed:
    if not animations:
        return Compressed((), LearnedMetric.plain(clip.skeleton.joints, options.scheme))
    keep = only = None
    if options.keep is not None or options.keep_only is not None:
        word = "--keep" if options.keep_only is None else "--keep-only"
        lost = codes[~np.isin(codes, clip.codes)]
        if len(lost):
            raise ValueError(f"{word} {lost[0]:g} is not the time code of a sample")
        frames = selection.frames_at(codes)
        keep, only = (frames, None) if options.keep_only is None else (None, frames)
    return compress(
        animations,
        None if tolerance is not None or only is not None else _counts(animations, options, keep),
        tolerance,
        kind=options.kind,
        select=options.select,
        scheme=options.scheme,
        family=options.family,
        keep=keep,
        only=only,
        markers=markers,
        progress=progress.watch,
        choosing=progress.choose,
    )


def _counts(animations: Sequence[Animation], options: DownsampleOptions, keep: list[np.ndarray] | None) -> list[int]:
    """Decide how many samples of each stretch to keep: its share, and no less than must stay."""
    n_frames = np.array([animation.n_frames for animation in animations])
    rate = options.rate if options.rate is not None else (options.keys or 0) / n_frames.sum()
    shares = np.array([len(uniform_keyframes(int(n), min(rate, 1.0))) for n in n_frames])
    if options.select == "uniform":
        least = np.full(len(animations), 2)
    else:
        frames = [np.zeros(0)] * len(animations) if keep is None else keep
        problems = [KeyProblem.of(each, None, 1.0, keep=kept) for each, kept in zip(animations, frames, strict=True)]
        least = np.array([len(problem.fixed) for problem in problems])
    counts = np.maximum(shares, least)
    if options.keys is not None:
        if not least.sum() <= options.keys <= n_frames.sum():
            raise ValueError(
                f"--keys is {options.keys}, but {least.sum()} of {n_frames.sum()} samples must stay (ends of "
                f"stretches and holds, and --keep); use {least.sum()} to {n_frames.sum()}, or choose animations with "
                "--prim."
            )
        while counts.sum() != options.keys:  # rounding, and what must stay
            step = 1 if counts.sum() < options.keys else -1
            room = counts < n_frames if step > 0 else counts > least
            counts[np.argmax(np.where(room, -step * counts / n_frames, -np.inf))] += step
    return counts.tolist()


def _provenance(
    path: Path, clip: SkelClip, sparse: SkelClip, metric: LearnedMetric, errors: Errors, played: Errors
) -> dict[str, Any]:
    """Return where a metric comes from, and what it rebuilds."""
    return {
        "version": __version__,
        "purpose": "reconstruct",
        **metric.provenance,
        "source": path.name,
        "sha256": stage_sha256(clip.source.stage),
        "prims": [clip.path],
        "samples": len(clip.codes),
        "kept_samples": len(sparse.codes),
        "source_rate": clip.samples_per_second(),
        "source_range": [float(clip.codes[0]), float(clip.codes[-1])],
        "mean_degrees": round(float(errors.degrees.mean()), 6) if errors.degrees.size else 0.0,
        "largest_centimetres": round(errors.largest, 6),
        BY_JOINT: errors_by_joint(errors.joints, errors.degrees.mean(axis=0), played.degrees.mean(axis=0)),
    }


def _uniform(
    animations: Sequence[Animation], errors: Errors, options: DownsampleOptions, markers: Markers
) -> list[np.ndarray]:
    """Equally spaced frames, the fewest that halving finds, from which slerp is as good."""
    if not animations:
        return []
    n_frames = sum(animation.n_frames for animation in animations)
    kind = options.criterion
    if kind == LARGEST:
        allowed = 0.01 * max(errors.largest, options.tolerance or 0.0)
    else:
        allowed = errors.quality(kind) * len(errors.degrees)

    def error(kept: Sequence[np.ndarray]) -> float:
        found = []
        for animation, frames in zip(animations, kept, strict=True):
            rebuilt = interpolate(animation.at_frames(frames), animation.times, "slerp")
            if kind == LARGEST:
                found.append(float(world_errors(rebuilt, animation, markers).max()))
            else:
                found.append(animation.n_frames * quality(rebuilt, animation, kind))
        return max(found) if kind == LARGEST else sum(found)

    def kept(number: int) -> list[np.ndarray]:
        return [uniform_keyframes(animation.n_frames, number / n_frames) for animation in animations]

    return kept(by_halving(lambda number: error(kept(number)) <= allowed, 0, n_frames))


def verified(
    stage: Usd.Stage, path: Path, clips: Sequence[DownsampledClip], options: DownsampleOptions
) -> list[DownsampledClip]:
    """Read what was written, rebuild its animations, and measure what comes out of it.

    Parameters
    ----------
    stage : Usd.Stage
        That shows what was written.
    path : Path
        How to name it.
    clips : sequence of DownsampledClip
    options : DownsampleOptions

    Returns
    -------
    checked : list of DownsampledClip
        With the errors that were measured.

    Raises
    ------
    ToolError
        If one of the tolerances is exceeded.
    """
    sources = find_animations(stage)
    checked = []
    for each in clips:
        paths = set(each.skeleton_paths) or {each.path}
        source = next(
            source for source in sources if paths & {source.path, *(str(s.GetPath()) for s in source.skeletons)}
        )
        metric, codes = stored_metric(source) if each.clip.joints else each.metric, read_source_codes(source.prim)
        assert metric is not None and codes is not None
        rebuilt = restored(read_clip(source), metric, codes)
        errors = each.measure.errors(rebuilt, each.clip)
        if options.tolerance is not None and errors.largest > options.tolerance:
            raise ToolError(
                f"{path}: {each.path} is rebuilt only to within {errors.largest:g} cm, but --tolerance is "
                f"{options.tolerance:g}; please report this."
            )
        off = _weights_error(each.selection, rebuilt)
        if off is not None and off > options.weights_tolerance:
            raise ToolError(
                f"{path}: weights of {each.path} are rebuilt only to within {off:g}, but --weights-tolerance is "
                f"{options.weights_tolerance:g}; please report this."
            )
        checked.append(replace(each, errors=errors, weights_error=off))
    return checked
