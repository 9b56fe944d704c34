"""The trials of a comparison: a clip, rebuilt by a scheme from a share of its samples, and scored."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from geomstats_anim import Animation, LearnedMetric, MotionLibrary, quality, uniform_keyframes
from geomstats_anim import rotations as quat
from geomstats_anim.contacts import find_contacts, skating
from geomstats_anim.criteria import rotation_errors
from geomstats_anim.interpolation.learned_scheme import Help, Learned
from geomstats_anim.interpolation.schemes import make_curve
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.learning.learn import learn_metric
from geomstats_anim.markers import Markers, world_errors
from geomstats_anim.names import FAMILIES, LEARNED, PURPOSES
from usd_tools.comparison.options import SchemeChoice
from usd_tools.learning.clips import TrainingClip
from usd_tools.skel.sizes import bytes_numpy, bytes_usdc

AS_IT_IS, WITHOUT = "as it is", "without this clip"
"""Use of the library that a clip is scored by."""


@dataclass(frozen=True, eq=False)
class ScoringLibrary:
    """The library that a clip is scored by, for the scheme `learned`.

    Parameters
    ----------
    library : MotionLibrary or None
    used : str
        "as it is", or "without this clip".
    error : str or None
        Why there is none.
    file : dict
        Name and sha256 of the file.
    """

    library: MotionLibrary | None
    used: str
    error: str | None
    file: dict[str, str]


@dataclass(frozen=True)
class Trial:
    """One rebuilding of a clip.

    Parameters
    ----------
    clip : str
    rate : float
        Share of samples kept as uniform keys.
    choice : SchemeChoice
    purpose : str or None
        What its metric is learned for.
    unseen : bool
        Whether only the second half is rebuilt and scored, with a metric learned from the first.
    """

    clip: str
    rate: float
    choice: SchemeChoice
    purpose: str | None
    unseen: bool

    def __str__(self) -> str:
        """Name it."""
        unseen = f", second half, {self.purpose or 'nothing learned'}" if self.unseen else ""
        return f"{self.clip} at rate {self.rate:g}, {self.choice.word}{unseen}"


@dataclass(frozen=True)
class Row:
    """Scores of a trial; None where it failed, or where a column does not apply.

    Parameters
    ----------
    clip, rate, scheme : str, float, str
    keys : int
    q_loc, q_rot, q_hyb : float
        Quality as in the papers: summed over joints, averaged over frames; square metres and radians.
    mean_rotation_deg : float
        Angle between local rotations, averaged over the joints that move and over all frames, keys among them.
    mean_location_cm, max_location_cm : float
        Distance of bone ends, averaged over all joints and frames, and the largest.
    bytes_numpy : int
        Kept rotations and translations and learned parameters as .npy files of float32.
    bytes_usdc : int
        A usdc file of the kept samples and the learned metric, and nothing else.
    seconds_learn, seconds_interpolate : float
        The only columns that differ from run to run.
    out_of_sample : bool
        Whether it is scored on the second half of the clip, and anything learned is learned from the first. Else it is
        scored on the whole clip, which is in-sample for what is learned.
    family, purpose : str
        Of what is learned.
    frames, joints : int
        That are scored.
    slerped_segments : int
        Segments of single joints whose geodesic was not found.
    library : str
        For the scheme "learned": whether the library was used "as it is", since it does not know the clip, or "without
        this clip", learned anew. Its bytes are not counted.
    skate_cm_per_second, floating_cm : float
        How fast points that are planted on the ground in the original slide along it, and how far they are above or
        below their height there, on average. None where nothing is planted.
    usd : str
        File of the rebuilt clip, as seen from the folder.
    error : str
        Why the trial failed.
    """

    clip: str
    rate: float
    scheme: str
    keys: int | None = None
    q_loc: float | None = None
    q_rot: float | None = None
    q_hyb: float | None = None
    mean_rotation_deg: float | None = None
    mean_location_cm: float | None = None
    max_location_cm: float | None = None
    bytes_numpy: int | None = None
    bytes_usdc: int | None = None
    seconds_learn: float | None = None
    seconds_interpolate: float | None = None
    out_of_sample: bool = False
    family: str | None = None
    purpose: str | None = None
    frames: int | None = None
    joints: int | None = None
    slerped_segments: int | None = None
    library: str | None = None
    skate_cm_per_second: float | None = None
    floating_cm: float | None = None
    usd: str | None = None
    error: str | None = None


@dataclass(frozen=True, eq=False)
class TrialResult:
    """A trial, what it came to, and what was learned for it, or what a library did for its stretches."""

    trial: Trial
    row: Row
    metric: LearnedMetric | None = None
    helps: tuple[Help, ...] | None = None


def all_trials(clips: Sequence[str], rates: Sequence[float], choices: Sequence[SchemeChoice]) -> list[Trial]:
    """Every trial of a comparison, those out of sample beside those in sample."""
    return [
        Trial(clip, rate, choice, purpose, unseen)
        for clip in clips
        for rate in rates
        for choice in choices
        for unseen in (False, True)
        for purpose in (choice.purposes if unseen else choice.purposes[-1:])
    ]


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """Stretches of a clip, rebuilt from their keys.

    Parameters
    ----------
    keys : tuple of array-like of int
        Frames kept of each stretch.
    stretches : tuple of Animation
    slerped : int
        Segments of single joints whose geodesic was not found.
    helps : tuple of Help or None
        Of the stretches, where a library was used.
    """

    keys: tuple[np.ndarray, ...]
    stretches: tuple[Animation, ...]
    slerped: int
    helps: tuple[Help, ...] | None


def rebuild(
    stretches: Sequence[Animation],
    rate: float,
    scheme: str,
    metric: LearnedMetric | None,
    library: MotionLibrary | Sequence[Help] | None = None,
) -> Rebuilt:
    """Rebuild stretches from a share of their frames.

    Parameters
    ----------
    stretches : sequence of Animation
    rate : float
    scheme : str
        A name in `SCHEMES`.
    metric : LearnedMetric or None
    library : MotionLibrary, sequence of Help or None
        For the scheme "learned": the library, or what it does for each stretch.

    Returns
    -------
    rebuilt : Rebuilt
    """
    kept = tuple(uniform_keyframes(stretch.n_frames, rate) for stretch in stretches)
    libraries = library if isinstance(library, Sequence) else [library] * len(stretches)
    curves = [
        make_curve(stretch.at_frames(keys), scheme, metric, each)
        for stretch, keys, each in zip(stretches, kept, libraries, strict=True)
    ]
    helps = tuple(curve.help for curve in curves if isinstance(curve, Learned)) or None
    dense = tuple(curve(stretch.times) for curve, stretch in zip(curves, stretches, strict=True))
    return Rebuilt(kept, dense, sum(len(curve.fallbacks) for curve in curves), helps)


def measure(trial: Trial, take: TrainingClip, kind: str, scoring: ScoringLibrary | None = None) -> TrialResult:
    """Do what a trial says; what goes wrong is told in its row.

    Parameters
    ----------
    trial : Trial
    take : TrainingClip
    kind : str
        Quality that learning minimises.
    scoring : ScoringLibrary
        For the scheme "learned".

    Returns
    -------
    result : TrialResult
    """
    try:
        return _measured(trial, take, kind, scoring if trial.choice.scheme == LEARNED else None)
    except Exception as error:  # whatever it is, a comparison of hours must not be lost for one trial
        return failed(trial, error)


def failed(trial: Trial, error: Exception) -> TrialResult:
    """Return the result of a trial that failed, with the reason in its row."""
    kind = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
    return TrialResult(trial, replace(_row(trial), error=kind + " ".join(str(error).split())))


def _row(trial: Trial) -> Row:
    return Row(
        trial.clip,
        trial.rate,
        trial.choice.word,
        out_of_sample=trial.unseen,
        family=trial.choice.family,
        purpose=trial.purpose,
    )


def _measured(trial: Trial, take: TrainingClip, kind: str, scoring: ScoringLibrary | None) -> TrialResult:
    if scoring is not None and scoring.library is None:
        raise ValueError(scoring.error)
    library = None if scoring is None else scoring.library
    scored, placed = take.stretches, take.placed
    if trial.unseen:
        scored, placed = map(_second_halves, (scored, placed))
    metric, seconds_learn = None, 0.0
    if trial.purpose is not None:
        metric, seconds_learn = _learned(take, trial.rate, trial.choice, trial.unseen, kind, trial.purpose)
    rebuild(scored, trial.rate, trial.choice.scheme, metric, library)  # loads what is compiled, so that it is not timed
    begin = time.perf_counter()
    rebuilt = rebuild(scored, trial.rate, trial.choice.scheme, metric, library)
    end = time.perf_counter()
    keys = [stretch.at_frames(kept) for stretch, kept in zip(scored, rebuilt.keys, strict=True)]
    row = replace(
        _row(trial),
        keys=sum(map(len, rebuilt.keys)),
        **_scores(rebuilt.stretches, scored),
        **_contact_scores(rebuilt.stretches, placed, take.up),
        bytes_numpy=bytes_numpy(keys, metric),
        bytes_usdc=bytes_usdc(keys, metric),
        seconds_learn=seconds_learn,
        seconds_interpolate=end - begin,
        frames=sum(stretch.n_frames for stretch in scored),
        joints=scored[0].n_joints,
        slerped_segments=rebuilt.slerped,
        library=None if scoring is None else scoring.used,
    )
    return TrialResult(trial, row, metric, rebuilt.helps)


@lru_cache(maxsize=4)
def _learned(
    take: TrainingClip, rate: float, choice: SchemeChoice, first_half: bool, kind: str, purpose: str
) -> tuple[LearnedMetric, float]:
    """Learn a metric, and tell how many seconds it took; the fit that "predict" shrinks is that of "reconstruct"."""
    stretches = take.stretches
    if first_half:
        stretches = tuple(stretch.at_frames(slice(0, stretch.n_frames // 2 + 1)) for stretch in stretches)
    keys = [uniform_keyframes(stretch.n_frames, rate) for stretch in stretches]
    if purpose != PURPOSES[0] and sum(len(kept) - 1 for kept in keys) < 2:
        # a segment alone cannot tell how to predict
        joints = stretches[0].skeleton.joints
        return LearnedMetric.plain(joints, choice.scheme), 0.0
    fitted, seconds = None, 0.0
    if purpose != PURPOSES[0]:
        fitted, seconds = _learned(take, rate, choice, first_half, kind, PURPOSES[0])
    start = time.perf_counter()
    metric = learn_metric(
        stretches,
        keys,
        scheme=choice.scheme,
        family=choice.family or FAMILIES[0],
        purpose=purpose,
        kind=kind,
        fitted=fitted,
    )
    return metric, seconds + time.perf_counter() - start


def _scores(rebuilt: Sequence[Animation], reference: Sequence[Animation]) -> dict[str, Any]:
    """Scores over all stretches, every frame with the same weight."""
    pairs = list(zip(rebuilt, reference, strict=True))
    frames = [truth.n_frames for truth in reference]
    qualities = {
        f"q_{kind}": float(np.average([quality(new, truth, kind) for new, truth in pairs], weights=frames))
        for kind in ("loc", "rot", "hyb")
    }
    turns = turning(reference)
    angles = np.concatenate([rotation_errors(new, truth) for new, truth in pairs])[:, turns]
    distances = np.concatenate([world_errors(new, truth, Markers.of_ends(truth.skeleton)) for new, truth in pairs])
    return {
        **qualities,
        "mean_rotation_deg": float(np.degrees(angles.mean())) if turns.any() else 0.0,
        "mean_location_cm": float(100.0 * distances.mean()),
        "max_location_cm": float(100.0 * distances.max()),
    }


def _second_halves(stretches: Sequence[Animation]) -> tuple[Animation, ...]:
    return tuple(stretch.at_frames(slice(stretch.n_frames // 2, None)) for stretch in stretches)


def _contact_scores(rebuilt: Sequence[Animation], placed: Sequence[Animation], up: np.ndarray) -> dict[str, Any]:
    """Scores of the points that are planted in the original; none where there are none."""
    found = skating(rebuilt, placed, [find_contacts(stretch, up) for stretch in placed])
    return {} if found is None else {"skate_cm_per_second": found.skate, "floating_cm": found.floating}


def turning(stretches: Sequence[Animation]) -> np.ndarray:
    """Return which joints turn at all, shape=[B]."""
    first = stretches[0].rotations[:1]
    return np.any([(quat.distance(part.rotations, first) >= STILL).any(axis=0) for part in stretches], axis=0)
