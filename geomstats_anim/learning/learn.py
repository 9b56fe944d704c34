"""`learn_metric`: from an animation, or several of one rig, and the keys to keep, to a metric."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim._version import __version__
from geomstats_anim.animation import Animation
from geomstats_anim.criteria import quality
from geomstats_anim.interpolation.schemes import SCHEMES
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.learning.gradient import search_gradient
from geomstats_anim.learning.learnable import Found, Learnable
from geomstats_anim.learning.objective import Objective
from geomstats_anim.learning.shrinkage import Fold, blocks, shrink
from geomstats_anim.names import DEFAULT_SCHEME, PURPOSES, SEARCHES, WITH_METRIC
from geomstats_anim.parameters import CurveParameters

if TYPE_CHECKING:
    from geomstats_anim.learning.tune.settings import TuneSettings


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
        "tpe": the same engine, one small search a joint. The last two need the extra `tune`.
        Optional, default: "gradient".
    purpose : str
        "reconstruct": fit these frames as well as possible, for a metric that travels with the animation.
        "predict": shrink the fit towards the bi-invariant metric, and a spline's tension towards 1, as far as
        cross-validation says, for frames nobody has seen.
        Optional, default: "reconstruct".
    family : str
        "diagonal", or "spd" for any symmetric positive definite matrix.
        Optional, default: "diagonal".
    invariance : str
        "left", "right", "clip" (one for all joints) or "joint" (one a joint).
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
        Its provenance holds `score`, `slerp_score`, and `plain_score`, which is the scheme's without learning, on the
        frames it was learned from, which are in-sample.

    Raises
    ------
    ValueError
        If a word is unknown, the joints differ, there is only one segment to predict from, or nothing moves.

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
    for name, word, words in (
        ("search", search, SEARCHES),
        ("purpose", purpose, PURPOSES),
        ("scheme", scheme, WITH_METRIC),
    ):
        if word not in words:
            raise ValueError(f"There is no {name} {word!r}; the choices are {', '.join(words)}.")
    if isinstance(animation, Animation):
        animations, keys = [animation], [_frames(cast(ArrayLike, keyframes))]
    else:
        animations = list(animation)
        keys = [_frames(kept) for kept in cast(Sequence[ArrayLike], keyframes)]
    _check(animations, keys, purpose)
    joints = animations[0].skeleton.joints
    clips = [Objective(clip, kept, kind, weights, location_weight) for clip, kept in zip(animations, keys, strict=True)]

    def find(objective: Learnable, settings: TuneSettings | None, rough: bool = rough) -> Found:
        if search == "gradient":
            return search_gradient(objective, len(joints), family, invariance, scheme, progress, rough)
        from geomstats_anim.learning.tune import tpe

        run = tpe.search_tpe if search == "tpe" else tpe.search_tpe_joint
        return run(objective, len(joints), family, invariance, scheme, seed, settings or tpe.TuneSettings(), progress)

    with _workers(len(clips), tune) as workers:
        if fitted is None:
            found = find(_together(clips, workers), tune)
            curve, evaluations = found.curve, found.evaluations
        else:
            curve, evaluations = fitted.for_joints(joints)[0].curve, fitted.provenance.get("evaluations", 0)
        extra: dict[str, Any] = {}
        if purpose == "predict":
            # a folder holds one search, that of all frames
            quiet = None if tune is None else replace(tune, folder=None, resume=False, wandb=None)
            plain = CurveParameters.plain(scheme, len(joints))
            shrinkage = shrink(_folds(clips, workers), curve, plain, lambda fold: find(fold, quiet, rough=True))
            curve = shrinkage.curve
            extra = {"shrinkage": shrinkage.factors.tolist()}
            if np.isfinite(shrinkage.score):
                extra["cross_validated_score"] = shrinkage.score
                extra["cross_validated_slerp_score"] = shrinkage.slerp_score
                extra["cross_validated_plain_score"] = shrinkage.plain_score

    metric = LearnedMetric(joints, curve.metric, curve.tension, scheme, kind, {}, curve.translation_tension)

    def score(scheme_name: str, metric: LearnedMetric | None = None) -> float:
        total = 0.0
        for clip, kept in zip(animations, keys, strict=True):
            rebuilt = SCHEMES[scheme_name](clip.at_frames(kept), metric)(clip.times)
            total += clip.n_frames * quality(rebuilt, clip, kind, weights, location_weight)
        return total / sum(clip.n_frames for clip in animations)

    provenance = {
        "version": __version__,
        "search": search,
        "purpose": purpose,
        "family": family,
        "invariance": invariance,
        "seed": seed,
        "evaluations": evaluations,
        "frames": [clip.n_frames for clip in animations],
        "keys": [len(kept) for kept in keys],
        "score": score(scheme, metric),
        "slerp_score": score("slerp"),
        "plain_score": score(scheme),
        **extra,
    }
    return replace(metric, provenance=provenance)


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


def _frames(keyframes: ArrayLike) -> np.ndarray:
    """Take indices, and refuse what is not whole."""
    frames = np.asarray(keyframes)
    if frames.size and not np.equal(frames, np.round(frames)).all():
        raise ValueError(f"keyframes must be whole numbers, but one is {frames[frames != np.round(frames)][0]}.")
    return frames.astype(np.intp)


def _check(animations: Sequence[Animation], keys: Sequence[np.ndarray], purpose: str) -> None:
    """Refuse what nothing can be learned from."""
    if not animations or len(animations) != len(keys):
        raise ValueError(
            f"There are {len(animations)} animations and keys for {len(keys)}; one set for each is needed."
        )
    joints = animations[0].skeleton.joints
    for number, (clip, kept) in enumerate(zip(animations, keys, strict=True)):
        if clip.skeleton.joints != joints:
            raise ValueError(f"Animation {number} has other joints than the first.")
        if len(kept) < 2 or kept[0] != 0 or kept[-1] != clip.n_frames - 1 or (np.diff(kept) <= 0).any():
            raise ValueError(f"The keys of animation {number} must increase from frame 0 to frame {clip.n_frames - 1}.")
    if purpose == "predict" and sum(len(kept) - 1 for kept in keys) < 2:
        raise ValueError("There is only one segment between keys, which cannot tell how to predict; keep more keys.")
    if all(len(kept) == clip.n_frames for clip, kept in zip(animations, keys, strict=True)):
        raise ValueError("Every frame is a key, so there is nothing to rebuild; keep fewer keys.")
    if not any(turns(clip) for clip in animations):
        raise ValueError("No joint turns, so there is nothing to learn.")


def turns(animation: Animation) -> bool:
    """Whether any joint turns."""
    return bool((quat.distance(animation.rotations, animation.rotations[:1]) >= STILL).any())


def _together(clips: Sequence[Objective], workers: int) -> Learnable:
    if len(clips) == 1:
        return clips[0]
    from geomstats_anim.learning.clips import Corpus

    return Corpus(clips, min(workers, len(clips)))


def _folds(clips: Sequence[Objective], workers: int) -> list[Fold]:
    """Leave out a block of clips at a time; of a single clip, a block of segments."""
    if len(clips) == 1:
        return [Fold(clips[0].without(block), clips[0].only(block)) for block in blocks(clips[0].n_segments)]
    folds = []
    for group in blocks(len(clips)):
        rest = [clip for number, clip in enumerate(clips) if number not in group]
        folds.append(Fold(_together(rest, workers), _together([clips[number] for number in group], workers)))
    return folds
