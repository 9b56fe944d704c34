"""Fitting a curve to animations and their keys, in this process or on several workers, and shrinking it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.learning.clips import Corpus
from geomstats_anim.learning.gradient import search_gradient
from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.learning.objective import Objective
from geomstats_anim.learning.settings import LearnSettings
from geomstats_anim.learning.shrinkage import Fold, blocks, shrink
from geomstats_anim.learning.training_set import TrainingSet
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.parameters import CurveParameters

Progress = Callable[[int, float], None]


class Fit(NamedTuple):
    """A curve, the evaluations it took to find, and what cross-validation says, for its provenance."""

    curve: CurveParameters
    evaluations: int
    cross_validation: dict[str, Any]


def fit(training: TrainingSet, settings: LearnSettings, progress: Progress, fitted: LearnedMetric | None = None) -> Fit:
    """Fit a curve, or take a fitted one, and shrink it where it has to predict.

    Parameters
    ----------
    training : TrainingSet
    settings : LearnSettings
    progress : callable
    fitted : LearnedMetric
        What the search finds, where it is known.
        Optional, default: None.

    Returns
    -------
    fit : Fit
    """
    clips, n_joints = training.objectives(settings), len(training.joints)
    with _workers(len(clips), settings.tune) as workers:
        if fitted is None:
            found = _find(_together(clips, workers), n_joints, settings, progress)
            curve, evaluations = found.curve, found.evaluations
        else:
            curve, evaluations = fitted.for_joints(training.joints)[0].curve, fitted.provenance.get("evaluations", 0)
        if settings.purpose == "reconstruct":
            return Fit(curve, evaluations, {})
        # a folder holds one search, that of all frames
        quiet = None if settings.tune is None else replace(settings.tune, folder=None, resume=False, wandb=None)
        roughly = replace(settings, tune=quiet, rough=True)
        plain = CurveParameters.plain(settings.scheme, n_joints)
        folds = _folds(clips, workers)
        shrinkage = shrink(folds, curve, plain, lambda fold: _find(fold, n_joints, roughly, progress))
    said: dict[str, Any] = {"shrinkage": shrinkage.factors.tolist()}
    if np.isfinite(shrinkage.score):
        said["cross_validated_score"] = shrinkage.score
        said["cross_validated_slerp_score"] = shrinkage.slerp_score
        said["cross_validated_plain_score"] = shrinkage.plain_score
    return Fit(shrinkage.curve, evaluations, said)


def _find(objective: Learnable, n_joints: int, settings: LearnSettings, progress: Progress) -> Found:
    """Run the search that is asked for."""
    words = (settings.family, settings.invariance, settings.scheme)
    if settings.search == "gradient":
        return search_gradient(objective, n_joints, *words, progress, settings.rough)
    from geomstats_anim.learning.tune import tpe

    search = tpe.search_tpe if settings.search == "tpe" else tpe.search_tpe_joint
    return search(objective, n_joints, *words, settings.seed, settings.tune, progress)


@contextmanager
def _workers(n_clips: int, tune: TuneSettings | None) -> Iterator[int]:
    """Have as many processes as are asked for and can be used; Ray is started for no less than two."""
    if tune is None:
        yield 1
        return
    from geomstats_anim.learning.tune import ray_runtime

    if n_clips == 1:
        if tune.address:  # there is nothing to spread, but a slip in it should not go unnoticed
            ray_runtime.check_reachable(tune.address)
        yield 1
        return
    if not ray_runtime.is_wanted(tune.address, tune.cpus):
        yield 1
        return
    with ray_runtime.running(tune.address, tune.cpus) as workers:
        yield workers


def _together(clips: Sequence[Objective], workers: int) -> Learnable:
    """Take several clips as one objective."""
    return clips[0] if len(clips) == 1 else Corpus(clips, min(workers, len(clips)))


def _folds(clips: Sequence[Objective], workers: int) -> list[Fold]:
    """Leave out a block of clips at a time; of a single clip, a block of segments."""
    if len(clips) == 1:
        return [Fold(clips[0].without(block), clips[0].only(block)) for block in blocks(clips[0].n_segments)]
    folds = []
    for group in blocks(len(clips)):
        rest = [clip for number, clip in enumerate(clips) if number not in group]
        folds.append(Fold(_together(rest, workers), _together([clips[number] for number in group], workers)))
    return folds
