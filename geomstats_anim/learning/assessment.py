"""Scores of a learned metric in and out of sample, beside slerp and its scheme without learning."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation
from geomstats_anim.criteria import quality
from geomstats_anim.interpolation.schemes import SCHEMES
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.keyframes.problem import uniform_keyframes
from geomstats_anim.learned_metric import LearnedMetric, Score
from geomstats_anim.names import DEFAULT_SCHEME

_NEIGHBOURS = (2.0 / 3.0, 1.5)
"""Neighbouring rates, as multiples."""

_MIN_KEYS = 3

Learn = Callable[[Animation, np.ndarray], LearnedMetric]


def score(
    what: str,
    in_sample: bool,
    animation: Animation,
    keyframes: np.ndarray,
    metric: LearnedMetric,
    weights: str | ArrayLike | None = None,
) -> Score:
    """Rebuild an animation from keys with a metric, by the plain spline, and by slerp, and compare all with it."""
    keys = animation.at_frames(keyframes)

    def error(scheme: str, metric_used: LearnedMetric | None = None) -> float:
        rebuilt = SCHEMES[scheme](keys, metric_used)(animation.times)
        return quality(rebuilt, animation, metric.quality or "hyb", weights)

    return Score(what, in_sample, error(metric.scheme, metric), error("slerp"), error(DEFAULT_SCHEME))


def assess(
    animation: Animation,
    rate: float,
    metric: LearnedMetric,
    learn: Learn,
    weights: str | ArrayLike | None = None,
) -> list[Score]:
    """Score a metric that was learned from an animation at a rate, in and out of sample.

    Out of sample: what the same learning makes of the first half, scored on the second; and the metric itself at the
    neighbouring rates. What is too short for that, or does not move, is left out.

    Parameters
    ----------
    animation : Animation
    rate : float
        Share of frames kept as uniform keys.
    metric : LearnedMetric
        What was learned there.
    learn : callable
        Takes an animation and its keys, and learns as `metric` was learned.
    weights : None, "depth" or array-like, shape=[B]
        Optional, default: None.

    Returns
    -------
    scores : list of Score
    """
    n = animation.n_frames
    scores = [
        score(f"learned and scored at rate {rate:g}", True, animation, uniform_keyframes(n, rate), metric, weights)
    ]
    first, second = animation.at_frames(slice(0, n // 2 + 1)), animation.at_frames(slice(n // 2, n))
    moves = (quat.distance(first.rotations, first.rotations[:1]) >= STILL).any()
    if moves and min(first.n_frames, second.n_frames) * rate >= _MIN_KEYS:
        half = learn(first, uniform_keyframes(first.n_frames, rate))
        keys = uniform_keyframes(second.n_frames, rate)
        scores.append(score("learned on the first half, scored on the second", False, second, keys, half, weights))
    for factor in _NEIGHBOURS:
        other = rate * factor
        if other <= 0.75 and n * other >= _MIN_KEYS:
            keys = uniform_keyframes(n, other)
            what = f"learned at rate {rate:g}, scored at rate {other:.3g}"
            scores.append(score(what, False, animation, keys, metric, weights))
    return scores
