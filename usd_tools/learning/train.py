"""One metric, learned from takes of one rig, and what it is worth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from geomstats_anim import SCHEMES, Animation, LearnedMetric, learn_metric, uniform_keyframes
from geomstats_anim.contacts import Skating, find_contacts, skating
from geomstats_anim.criteria import rotation_errors
from geomstats_anim.learned_metric import Score
from geomstats_anim.learning.assessment import assess
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.names import DEFAULT_SCHEME
from geomstats_anim.parameters import CurveParameters
from usd_tools.console.errors import ToolError
from usd_tools.learning.clips import TrainingClip
from usd_tools.learning.options import LearnOptions
from usd_tools.metrics.explain import BY_JOINT, errors_by_joint

Watch = Callable[[int, float], None]


def keyframes_of(stretch: Animation, options: LearnOptions) -> np.ndarray:
    """Return the frames of a stretch that are kept as keys."""
    return uniform_keyframes(stretch.n_frames, options.rate)


def fit(
    stretches: Sequence[Animation], options: LearnOptions, watch: Watch = lambda evaluations, value: None
) -> LearnedMetric:
    """Learn one metric.

    Raises
    ------
    ValueError
        If there is nothing to learn.
    """
    tune = TuneSettings(
        trials=options.trials,
        folder=options.resume or options.folder,
        resume=options.resume is not None,
        address=options.address,
        cpus=options.cpus,
        wandb=options.wandb,
    )
    return learn_metric(
        stretches,
        [keyframes_of(stretch, options) for stretch in stretches],
        options.search,
        options.purpose,
        options.family,
        options.invariance,
        options.scheme,
        options.kind,
        options.seed,
        weights=options.weights,
        tune=tune,
        progress=watch,
    )


@dataclass(frozen=True)
class JointError:
    """Mean rotation error of a joint where its metric was learned, degrees."""

    joint: str
    learned: float
    slerp: float

    @property
    def gain(self) -> float:
        """Degrees nearer than slerp."""
        return self.slerp - self.learned


@dataclass(frozen=True, eq=False)
class AssessedMetric:
    """A metric, the clips that it was learned from, and its scores.

    Parameters
    ----------
    takes : tuple of TrainingClip
    metric : LearnedMetric
        Its provenance says all that is here, in short.
    scores : tuple of Score
        In-sample first.
    joints : tuple of JointError
        Those that turn.
    slerped : int
        Segments of single joints whose geodesic was not found, so that they are slerped.
    skating : mapping of str to Skating
        How points skate and float that are planted in the clips: "learned", "plain" (the spline) and "slerp". Empty
        where nothing is planted.
    """

    takes: tuple[TrainingClip, ...]
    metric: LearnedMetric
    scores: tuple[Score, ...]
    joints: tuple[JointError, ...]
    slerped: int
    skating: Mapping[str, Skating]

    @property
    def is_plain(self) -> bool:
        """True if nothing came of it: the bi-invariant metric, whose geodesics are slerp, with the usual tension."""
        metric = self.metric
        usual = CurveParameters.plain(metric.scheme, len(metric.joints))
        same_tensions = (metric.tension == usual.tension) & (metric.translation_tension == usual.translation_tension)
        return bool((metric.parameters.moments == 1.0).all() and same_tensions.all())

    @property
    def cross_validated(self) -> Score | None:
        """Score of metrics learned and shrunk likewise on blocks that were left out; None if it is fitted freely."""
        names = ("cross_validated_score", "cross_validated_slerp_score", "cross_validated_plain_score")
        if not all(name in self.metric.provenance for name in names):
            return None
        return Score("blocks left out", False, *(self.metric.provenance[name] for name in names))

    @property
    def loses(self) -> bool:
        """True if it loses anywhere out of sample to what needs no learning."""
        return any(score.loses for score in self.scores if not score.in_sample)


def learn_and_assess(
    takes: Sequence[TrainingClip], options: LearnOptions, watch: Watch = lambda evaluations, value: None
) -> AssessedMetric:
    """Learn one metric from takes of one rig, and assess it.

    Parameters
    ----------
    takes : sequence of TrainingClip
        The same joints in the same order.
    options : LearnOptions
    watch : callable
        Called with the number of evaluations and the best value so far.

    Returns
    -------
    assessed : AssessedMetric

    Raises
    ------
    ToolError
        If nothing can be learned at this rate, or a search cannot run.
    """
    stretches = [stretch for take in takes for stretch in take.stretches]
    _check_rate(takes, stretches, options)
    try:
        metric = fit(stretches, options, watch)
        scores = _scores(stretches, options, metric)
    except (ValueError, RuntimeError, ModuleNotFoundError, ConnectionError) as error:
        raise ToolError(" ".join(str(error).split())) from error
    joints, slerped = _by_joint(stretches, options, metric)
    provenance = _provenance(takes, options, metric, scores, joints)
    skates = _skating(takes, options, metric)
    return AssessedMetric(tuple(takes), replace(metric, provenance=provenance), scores, joints, slerped, skates)


def _check_rate(takes: Sequence[TrainingClip], stretches: Sequence[Animation], options: LearnOptions) -> None:
    keys = [keyframes_of(stretch, options) for stretch in stretches]
    n_keys, n_frames = sum(map(len, keys)), sum(stretch.n_frames for stretch in stretches)
    where = str(takes[0]) if len(takes) == 1 else f"{len(takes)} animations"
    if n_keys - len(keys) < 2:
        enough = np.ceil(300.0 / n_frames) / 100.0
        raise ToolError(
            f"--rate {options.rate:g} keeps {n_keys} of the {n_frames} samples of {where}, which is one segment; use "
            f"at least {enough:g}."
        )
    if n_keys == n_frames:
        raise ToolError(f"--rate {options.rate:g} keeps all {n_frames} samples of {where}; use a smaller --rate.")


def _scores(stretches: Sequence[Animation], options: LearnOptions, metric: LearnedMetric) -> tuple[Score, ...]:
    """Scores over all stretches, every frame with the same weight."""

    @cache
    def of_first_halves() -> LearnedMetric:
        # With TPE this would take as long again; the gradient finds the same metrics, and better ones.
        quick = replace(options, search="gradient", trials=None, folder=None, resume=None, wandb=None)
        try:
            return fit([stretch.at_frames(slice(0, stretch.n_frames // 2 + 1)) for stretch in stretches], quick)
        except ValueError:  # nothing to learn in there
            return LearnedMetric.plain(metric.joints, metric.scheme)

    found: dict[tuple[str, bool], list[tuple[int, Score]]] = {}
    for stretch in stretches:
        for score in assess(stretch, options.rate, metric, lambda *_: of_first_halves()):
            found.setdefault((score.what, score.in_sample), []).append((stretch.n_frames, score))
    means = []
    for (what, in_sample), scores in found.items():
        values = [(score.learned, score.slerp, score.plain) for _, score in scores]
        mean = np.average(values, axis=0, weights=[frames for frames, _ in scores])
        means.append(Score(what, in_sample, *mean.tolist()))
    return tuple(means)


def _by_joint(
    stretches: Sequence[Animation], options: LearnOptions, metric: LearnedMetric
) -> tuple[tuple[JointError, ...], int]:
    """Errors of the joints that turn, and the number of segments that are slerped."""
    errors: dict[str, list[np.ndarray]] = {metric.scheme: [], "slerp": []}
    slerped = 0
    for stretch in stretches:
        keys = stretch.at_frames(keyframes_of(stretch, options))
        for scheme in errors:
            curve = SCHEMES[scheme](keys, metric if scheme == metric.scheme else None)
            slerped += len(curve.fallbacks)
            errors[scheme].append(rotation_errors(curve(stretch.times), stretch))
    learned, slerp = (np.degrees(np.concatenate(found).mean(axis=0)).round(4) for found in errors.values())
    joints = (JointError(*row) for row in zip(metric.joints, learned.tolist(), slerp.tolist(), strict=True))
    return tuple(joint for joint in joints if joint.slerp > 0.0), slerped


def _skating(takes: Sequence[TrainingClip], options: LearnOptions, metric: LearnedMetric) -> dict[str, Skating]:
    """Measure the planted points of all clips, rebuilt by the metric and by what needs none."""
    placed = [(stretch, find_contacts(stretch, take.up)) for take in takes for stretch in take.placed]
    placed = [(stretch, contacts) for stretch, contacts in placed if len(contacts.joints)]
    if not placed:
        return {}
    schemes: dict[str, tuple[str, LearnedMetric | None]] = {
        "learned": (metric.scheme, metric),
        "plain": (DEFAULT_SCHEME, None),
        "slerp": ("slerp", None),
    }
    originals, contacts = zip(*placed, strict=True)
    measured = {}
    for name, (scheme, used) in schemes.items():
        rebuilt = [
            SCHEMES[scheme](stretch.at_frames(keyframes_of(stretch, options)), used)(stretch.times)
            for stretch in originals
        ]
        measured[name] = skating(rebuilt, originals, contacts)
    return {name: found for name, found in measured.items() if found is not None}


def _provenance(
    takes: Sequence[TrainingClip],
    options: LearnOptions,
    metric: LearnedMetric,
    scores: Sequence[Score],
    joints: Sequence[JointError],
) -> Mapping[str, Any]:
    """Return what `learn_metric` says, and where the metric comes from: one file is a word, several are a list."""
    provenance = dict(metric.provenance)
    shrinkage = dict(zip(metric.joints, provenance.pop("shrinkage", ()), strict=False))
    files = list(dict.fromkeys((take.file, take.sha256) for take in takes))
    names, sums = [file for file, _ in files], [sha256 for _, sha256 in files]
    unseen = [score for score in scores if not score.in_sample]
    by_joint = errors_by_joint(
        [error.joint for error in joints],
        np.array([error.learned for error in joints]),
        np.array([error.slerp for error in joints]),
    )
    if shrinkage:
        by_joint["shrinkage"] = [shrinkage[error.joint] for error in joints]
    return {
        "source": names[0] if len(names) == 1 else names,
        "sha256": sums[0] if len(sums) == 1 else sums,
        "prims": [take.prim for take in takes],
        "rate": options.rate,
        **({"weights": options.weights} if options.weights else {}),
        **provenance,
        "out_of_sample": {
            "what": [score.what for score in unseen],
            "scores": [score.learned for score in unseen],
            "slerp_scores": [score.slerp for score in unseen],
            "plain_scores": [score.plain for score in unseen],
        },
        BY_JOINT: by_joint,
    }
