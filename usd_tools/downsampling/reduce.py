"""One animation made sparse: which samples stay, the metric that rebuilds the others, and how well it does."""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim import Animation, LearnedMetric, __version__, compress, interpolate, quality, uniform_keyframes
from geomstats_anim.criteria import location_errors
from geomstats_anim.keyframes.problem import KeyProblem, by_halving
from geomstats_anim.learning.compression import Compressed
from geomstats_anim.names import LARGEST
from usd_tools.console.arguments import TimeCodes
from usd_tools.console.errors import Messages, ToolError
from usd_tools.downsampling.thinning import Errors, Thinning, restored, sampled_alike
from usd_tools.files.stages import open_stage
from usd_tools.metrics.attributes import read_metric, read_source_codes
from usd_tools.metrics.explain import BY_JOINT, errors_by_joint
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.time_codes import codes_for, left_sparse

_ROUNDING = 1e-2
"""Share of a tolerance that is left to the rounding of what is written, at most."""

_ROUNDING_METRES = 5e-6


@dataclass(frozen=True)
class Wanted:
    """How many samples to keep, and what to choose them by; the words are those of the command line.

    Parameters
    ----------
    rate : float or None
    keys : int or None
    tolerance : float or None
        Centimetres.
    select, scheme : str
    family, kind : str or None
    keep : TimeCodes or None
    """

    rate: float | None
    keys: int | None
    tolerance: float | None
    select: str
    scheme: str
    family: str | None
    kind: str | None
    keep: TimeCodes | None

    @classmethod
    def of(cls, args: argparse.Namespace) -> Wanted:
        """Take it from the command line."""
        return cls(args.rate, args.keys, args.tolerance, args.select, args.scheme, args.family, args.kind, args.keep)

    @property
    def criterion(self) -> str:
        """Kind of quality for comparisons at equal error: "max" for a tolerance."""
        return self.kind or ("hyb" if self.tolerance is None else "max")


@dataclass(frozen=True, eq=False)
class Reduced:
    """An animation made sparse.

    Parameters
    ----------
    thinning : Thinning
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
    """

    thinning: Thinning
    sparse: SkelClip
    metric: LearnedMetric
    errors: Errors
    played: Errors
    uniform: list[np.ndarray]
    criterion: str

    @property
    def clip(self) -> SkelClip:
        """The source."""
        return self.thinning.clip

    @property
    def kept(self) -> np.ndarray:
        """Time codes of the samples that are left of those that were chosen from."""
        names = self.thinning.names
        return self.sparse.channels[names[0]].codes if names else self.sparse.codes


def reduce_clip(
    path: Path,
    clip: SkelClip,
    wanted: Wanted,
    messages: Messages,
    watch: Callable[[int, float], None] = lambda evaluations, value: None,
) -> Reduced | None:
    """Choose the samples of an animation to keep, and learn the metric for them.

    Parameters
    ----------
    path : Path
        File that it is in.
    clip : SkelClip
    wanted : Wanted
    messages : Messages
        Told what a user should know.
    watch : callable
        Called with the number of evaluations and the best value so far of the search for a metric.

    Returns
    -------
    reduced : Reduced or None
        None if there are no samples to choose from.

    Raises
    ------
    ToolError
        If it cannot be done as wanted.
    """
    clip = sampled_alike(clip)
    for note in (*clip.notes, *left_sparse(clip)):
        messages.warn(note)
    if not (clip.is_animated and clip.joints):
        return None
    thinning = Thinning.of(clip)
    if thinning.kept_whole:
        messages.warn(
            f"{clip.path}: {' and '.join(thinning.kept_whole)} change and are kept whole, as nothing judges them."
        )
    animations = thinning.animations
    allowance = None if wanted.tolerance is None else 0.01 * wanted.tolerance
    margin = 0.0 if allowance is None else min(_ROUNDING_METRES, _ROUNDING * allowance)
    while True:
        try:
            compressed = _compressed(clip, thinning, animations, wanted, allowance and allowance - margin, watch)
        except ValueError as error:
            raise ToolError(f"{clip.path} cannot be made sparse so: {error}") from error
        sparse = thinning.sparse(compressed.keyframes)
        errors = Errors.between(restored(sparse, compressed.metric, clip.codes), clip)
        over = 0.0 if wanted.tolerance is None else errors.centimetres.max(initial=0.0) - wanted.tolerance
        if over <= 0.0:
            break
        margin += 0.02 * over  # what is written is rounded, and other channels have a part in it
    played = Errors.between(restored(sparse, compressed.metric, clip.codes, "slerp"), clip)
    metric = replace(compressed.metric, provenance=_provenance(path, clip, sparse, compressed.metric, errors, played))
    uniform = _uniform(animations, errors, wanted)
    return Reduced(thinning, sparse, metric, errors, played, uniform, wanted.criterion)


def _compressed(
    clip: SkelClip,
    thinning: Thinning,
    animations: Sequence[Animation],
    wanted: Wanted,
    tolerance: float | None,
    watch: Callable[[int, float], None],
) -> Compressed:
    if not animations:
        return Compressed((), LearnedMetric.plain(clip.skeleton.joints, wanted.scheme))
    keep = None
    if wanted.keep is not None:
        codes = codes_for(clip, wanted.keep)
        keep = thinning.frames_at(codes)
        lost = codes[~np.isin(codes, clip.codes)]
        if len(lost):
            raise ValueError(f"--keep {lost[0]:g} is no time code of a sample")
    return compress(
        animations,
        None if tolerance is not None else _counts(animations, wanted, keep),
        tolerance,
        kind=wanted.kind,
        select=wanted.select,
        scheme=wanted.scheme,
        family=wanted.family,
        keep=keep,
        progress=watch,
    )


def _counts(animations: Sequence[Animation], wanted: Wanted, keep: list[np.ndarray] | None) -> list[int]:
    """Decide how many samples of each stretch to keep: its share, and no less than must stay."""
    n_frames = np.array([animation.n_frames for animation in animations])
    rate = wanted.rate if wanted.rate is not None else (wanted.keys or 0) / n_frames.sum()
    shares = np.array([len(uniform_keyframes(int(n), min(rate, 1.0))) for n in n_frames])
    if wanted.select == "uniform":
        least = np.full(len(animations), 2)
    else:
        frames = [np.zeros(0)] * len(animations) if keep is None else keep
        problems = [KeyProblem.of(each, None, 1.0, keep=kept) for each, kept in zip(animations, frames, strict=True)]
        least = np.array([len(problem.fixed) for problem in problems])
    counts = np.maximum(shares, least)
    if wanted.keys is not None:
        if not least.sum() <= wanted.keys <= n_frames.sum():
            raise ValueError(
                f"--keys is {wanted.keys}, but {least.sum()} of {n_frames.sum()} samples must stay: the ends of "
                f"stretches and holds, and those of --keep; say {least.sum()} to {n_frames.sum()}, or "
                "choose animations with --prim."
            )
        while counts.sum() != wanted.keys:  # rounding, and what must stay
            step = 1 if counts.sum() < wanted.keys else -1
            room = counts < n_frames if step > 0 else counts > least
            counts[np.argmax(np.where(room, -step * counts / n_frames, -np.inf))] += step
    return counts.tolist()


def _provenance(
    path: Path, clip: SkelClip, sparse: SkelClip, metric: LearnedMetric, errors: Errors, played: Errors
) -> dict[str, Any]:
    """Tell where a metric comes from, and what it rebuilds."""
    return {
        "version": __version__,
        "purpose": "reconstruct",
        **metric.provenance,
        "source": path.name,
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "prims": [clip.path],
        "samples": len(clip.codes),
        "kept_samples": len(sparse.codes),
        "source_rate": clip.samples_per_second(),
        "source_range": [float(clip.codes[0]), float(clip.codes[-1])],
        "mean_degrees": round(float(errors.degrees.mean()), 6) if errors.degrees.size else 0.0,
        "largest_centimetres": round(float(errors.centimetres.max(initial=0.0)), 6),
        BY_JOINT: errors_by_joint(errors.joints, errors.degrees.mean(axis=0), played.degrees.mean(axis=0)),
    }


def _uniform(animations: Sequence[Animation], errors: Errors, wanted: Wanted) -> list[np.ndarray]:
    """Equally spaced frames, the fewest that halving finds, from which slerp is as good."""
    if not animations:
        return []
    n_frames = sum(animation.n_frames for animation in animations)
    kind = wanted.criterion
    if kind == LARGEST:
        allowed = max(0.01 * errors.centimetres.max(initial=0.0), 0.01 * (wanted.tolerance or 0.0))
    else:
        allowed = errors.quality(kind) * len(errors.degrees)

    def error(kept: Sequence[np.ndarray]) -> float:
        found = []
        for animation, frames in zip(animations, kept, strict=True):
            rebuilt = interpolate(animation.at_frames(frames), animation.times, "slerp")
            if kind == LARGEST:
                found.append(float(location_errors(rebuilt, animation).max()))
            else:
                found.append(animation.n_frames * quality(rebuilt, animation, kind))
        return max(found) if kind == LARGEST else sum(found)

    def kept(number: int) -> list[np.ndarray]:
        return [uniform_keyframes(animation.n_frames, number / n_frames) for animation in animations]

    return kept(by_halving(lambda number: error(kept(number)) <= allowed, 0, n_frames))


def verified(path: Path, reduced: Sequence[Reduced], wanted: Wanted) -> list[Reduced]:
    """Read a written file, rebuild its animations, and measure what comes out of it.

    Raises
    ------
    ToolError
        If a tolerance is exceeded.
    """
    stage = open_stage(path)
    stage.Reload()  # OpenUSD may still hold what the file was before
    clips = [read_clip(source) for source in find_animations(stage)]
    checked = []
    for each in reduced:
        paths = {str(prim.GetPath()) for prim in each.clip.source.skeletons} or {each.clip.path}
        written = next(
            clip for clip in clips if paths & {clip.path, *(str(s.GetPath()) for s in clip.source.skeletons)}
        )
        metric, codes = read_metric(written.source.prim), read_source_codes(written.source.prim)
        assert metric is not None and codes is not None
        errors = Errors.between(restored(written, metric, codes), each.clip)
        if wanted.tolerance is not None and errors.centimetres.max(initial=0.0) > wanted.tolerance:
            raise ToolError(
                f"{path}: {each.clip.path} is rebuilt to {errors.centimetres.max():g} cm only, for --tolerance "
                f"{wanted.tolerance:g}; please report this."
            )
        checked.append(replace(each, errors=errors))
    return checked
