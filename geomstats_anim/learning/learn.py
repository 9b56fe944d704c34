"""`learn_metric`: from an animation, or several of one rig, and the keys to keep, to a metric."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from geomstats_anim._version import __version__
from geomstats_anim.animation import Animation
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.learning.fitting import Fit, fit
from geomstats_anim.learning.settings import LearnSettings
from geomstats_anim.learning.training_set import TrainingSet
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.names import DEFAULT_SCHEME


def learn_metric(
    animation: Animation | Sequence[Animation],
    keyframes: ArrayLike | Sequence[ArrayLike],
    search: str = "gradient",
    purpose: str = "reconstruct",
    family: str = "diagonal",
    invariance: str = "joint",
    scheme: str = DEFAULT_SCHEME,
    kind: str = "hyb",
    seed: int = 0,
    *,
    weights: str | ArrayLike | None = None,
    location_weight: float = 0.5,
    tune: TuneSettings | None = None,
    progress: Callable[[int, float], None] = lambda evaluations, value: None,
    fitted: LearnedMetric | None = None,
    rough: bool = False,
) -> LearnedMetric:
    r"""Learn the metric, and for a spline the tension, with which some frames of an animation rebuild it best.

    Kushner, Modi, Miolane, "Learning Riemannian metrics for interpolating animations", equation 6.

    Parameters
    ----------
    animation : Animation, or sequence of them
        The truth. Several must have the same joints.
    keyframes : array-like of int, shape=[K], or a sequence of them
        Frames that are kept, the first and the last included: one array for each animation.
    search : str
        "gradient": exact gradient, about a second. "tpe-joint": the papers' search over all parameters at once.
        "tpe": the same engine, one small search per joint. The last two need the extra `tune`.
        Optional, default: "gradient".
    purpose : str
        "reconstruct": fit these frames as well as possible, for a metric that travels with the animation.
        "predict": shrink the fit towards the bi-invariant metric, and a spline's tension towards 1, as far as
        cross-validation says, for frames nobody has seen.
        Optional, default: "reconstruct".
    family : str
        "diagonal", or "spd" for any symmetric positive definite matrix; or "coupled" for one over all joints, of low
        rank beside those of "spd", which takes about a minute and can only reconstruct.
        Optional, default: "diagonal".
    invariance : str
        "left", "right", "clip" (one for all joints) or "joint" (one per joint).
        Optional, default: "joint".
    scheme : str
        Interpolation scheme to learn for.
        Optional, default: "geodesic-spline".
    kind : str
        Quality to minimise: "loc", "rot" or "hyb".
        Optional, default: "hyb".
    seed : int
        Of the TPE searches; the gradient search has no randomness.
        Optional, default: 0.
    weights : None, "depth" or array-like, shape=[B]
        Optional, default: None.
    location_weight : float
        Optional, default: 0.5.
    tune : TuneSettings
        Trials, folder, cluster of the TPE searches, and workers for several animations.
        Optional, default: None.
    progress : callable
        Called with the number of evaluations and the best value so far.
    fitted : LearnedMetric
        What the same call with the purpose "reconstruct" has found, for "predict" to shrink.
        Optional, default: None, it is searched for.
    rough : bool
        Search less in the gradient search, for a metric near the best in a third of the time.
        Optional, default: False.

    Returns
    -------
    metric : LearnedMetric
        Its provenance holds `score`, `slerp_score`, and `plain_score`, which is the plain spline's, on the frames it
        was learned from, which are in-sample.

    Raises
    ------
    ValueError
        If a word is unknown or does not fit the others, the joints differ, there is only one segment to predict from,
        or nothing moves.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import Animation, Skeleton, learn_metric, uniform_keyframes
    >>> skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    >>> t = np.linspace(0.0, 1.0, 31)
    >>> turn = np.stack([np.sin(3 * t), np.cos(2 * t), t, 2 + np.sin(t)], axis=-1)[:, None]
    >>> swing = Animation(skeleton, t, turn / np.linalg.norm(turn, axis=-1, keepdims=True), np.zeros((31, 1, 3)))
    >>> metric = learn_metric(swing, uniform_keyframes(31, 0.2))
    >>> metric.provenance["score"] < metric.provenance["slerp_score"]
    True
    """
    settings = LearnSettings(
        search, purpose, family, invariance, scheme, kind, seed, weights, location_weight, tune, rough
    )
    training = TrainingSet.of(animation, keyframes)
    if purpose == "predict" and training.n_segments < 2:
        raise ValueError("There is only one segment between keys, which cannot tell how to predict; keep more keys.")
    found = fit(training, settings, progress, fitted)
    curve = found.curve
    metric = LearnedMetric(
        training.joints,
        curve.metric,
        curve.tension,
        scheme,
        kind,
        translation_tension=curve.translation_tension,
        coupling=curve.coupling,
    )
    return replace(metric, provenance=_provenance(metric, training, settings, found))


def _provenance(metric: LearnedMetric, training: TrainingSet, settings: LearnSettings, found: Fit) -> dict[str, Any]:
    """Return where a metric comes from, and its scores beside slerp and its scheme without learning."""
    return {
        "version": __version__,
        "search": settings.search,
        "purpose": settings.purpose,
        "family": settings.family,
        "invariance": settings.invariance,
        "seed": settings.seed,
        "evaluations": found.evaluations,
        "frames": [clip.n_frames for clip in training.animations],
        "keys": [len(kept) for kept in training.keyframes],
        "score": training.score(settings.scheme, metric, settings),
        "slerp_score": training.score("slerp", None, settings),
        "plain_score": training.score(DEFAULT_SCHEME, None, settings),
        **found.cross_validation,
    }
