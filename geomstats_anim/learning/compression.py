"""Keys and the metric that rebuilds the frames between them, chosen together.

Metrics are learned roughly: where the keys are matters more than the last per cent that a longer search would find. And
for moving keys a diagonal one is near enough.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation
from geomstats_anim.interpolation.schemes import SCHEMES
from geomstats_anim.keyframes.problem import KeyProblem, by_halving, uniform_keyframes
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.learning.learn import learn_metric
from geomstats_anim.learning.training_set import turns
from geomstats_anim.markers import Markers
from geomstats_anim.names import SELECTIONS, WITH_METRIC

_ROUNDS = 3
"""Most times that a metric is learned for the fewest keys so far, and keys are removed under it."""

_FRAMES_BETWEEN_KEYS = 32
"""Frames from key to key, on average, that a metric is learned from at least; of far more, some are left out."""

_LEAST_GAIN = 0.05
"""Share of the keys that must have been gained for the metric to be learned once more."""


@dataclass(frozen=True, eq=False)
class Compressed:
    """Keys of animations, and the metric that rebuilds the other frames.

    Parameters
    ----------
    keyframes : tuple of array-like of int
        Frames that are kept, of each animation.
    metric : LearnedMetric
        What rebuilds the others; its scheme is the one to use.
    """

    keyframes: tuple[np.ndarray, ...]
    metric: LearnedMetric


def compress(
    animations: Sequence[Animation],
    counts: Sequence[int] | None = None,
    tolerance: float | None = None,
    *,
    kind: str | None = None,
    select: str = "optimal",
    scheme: str = "geodesic-spline",
    family: str | None = None,
    keep: Sequence[ArrayLike] | None = None,
    only: Sequence[ArrayLike] | None = None,
    markers: Markers | None = None,
    progress: Callable[[int, float], None] = lambda evaluations, value: None,
    choosing: Callable[[float], None] = lambda share: None,
) -> Compressed:
    """Choose keys and learn the metric for them, in turn, until neither improves.

    Parameters
    ----------
    animations : sequence of Animation
        Of one rig; one metric serves them all.
    counts : sequence of int
        Keys to keep of each. Either this, or the tolerance, or `only`.
    tolerance : float
        Metres in the world that no marker may be away from its place in any frame; the fewest keys are sought.
    kind : str
        As in `optimal_keyframes`.
        Optional, default: "hyb" for counts, "max" for a tolerance.
    select : str
        "optimal", or "uniform": equally spaced, as in the papers.
        Optional, default: "optimal".
    scheme : str
        A name in `SCHEMES`; "geodesic" and "geodesic-spline" are learned.
        Optional, default: "geodesic-spline".
    family : str
        As in `learn_metric`.
        Optional, default: "spd" for counts, "diagonal" for a tolerance, where the other saves hardly any keys.
    keep : sequence of array-like of int
        Frames of each that must be kept.
        Optional, default: none.
    only : sequence of array-like of int
        Frames of each that are kept, exactly these and both ends; then only the metric is sought.
        Optional, default: None.
    markers : Markers
        As in `optimal_keyframes`.
        Optional, default: every joint, and the end of its bone.
    progress : callable
        Called with the number of evaluations of a search for a metric, and the best value so far.
    choosing : callable
        Called with the share of the choice of the first keys that is done, where a long clip makes that take long.

    Returns
    -------
    compressed : Compressed

    Raises
    ------
    ValueError
        As `optimal_keyframes`; and if there is no such selection, or it is uniform and frames must be kept, or there is
        not one count for each animation, or their joints differ.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import Animation, Skeleton, compress
    >>> skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    >>> t = np.linspace(0.0, 1.0, 31)
    >>> turn = np.stack([np.sin(3 * t), np.cos(2 * t), t, 2 + np.sin(t)], axis=-1)[:, None]
    >>> swing = Animation(skeleton, t, turn / np.linalg.norm(turn, axis=-1, keepdims=True), np.zeros((31, 1, 3)))
    >>> len(compress([swing], tolerance=0.01).keyframes[0])
    4
    """
    if scheme not in SCHEMES:
        raise ValueError(f"There is no scheme {scheme!r}; the schemes are {', '.join(SCHEMES)}.")
    _check(animations, counts, select, keep)
    exactly = None if only is None else _with_ends(animations, only)
    if exactly is not None:
        counts = [len(kept) for kept in exactly]
    problems = [
        KeyProblem.of(
            animation,
            None if counts is None else counts[i],
            tolerance,
            kind,
            () if keep is None else keep[i],
            markers=markers,
        )
        for i, animation in enumerate(animations)
    ]
    plain = LearnedMetric.plain(animations[0].skeleton.joints, scheme)
    # what is best for all joints and frames is far quicker to find than what is best for the worst, and near
    kind = "hyb" if problems[0].measure.largest else kind or "hyb"
    family = family or ("spd" if tolerance is None else "diagonal")
    learn: Fit = _nothing if scheme not in WITH_METRIC else partial(_fit, animations, scheme, kind, progress, family)
    if exactly is not None:
        return Compressed(tuple(exactly), _cheapest(problems, exactly, plain, learn(exactly)))
    if select == "uniform":
        return _uniform(problems, plain, learn)
    start = [problem.under_slerp(choosing) for problem in problems]
    return (_best if tolerance is None else _fewest)(problems, start, plain, learn)


def _check(
    animations: Sequence[Animation],
    counts: Sequence[int] | None,
    select: str,
    keep: Sequence[ArrayLike] | None,
) -> None:
    """Refuse arguments of `compress` that do not fit together."""
    if select not in SELECTIONS:
        raise ValueError(f"There is no selection {select!r}; the choices are {', '.join(SELECTIONS)}.")
    if select == "uniform" and keep is not None and any(np.size(frames) for frames in keep):
        raise ValueError("Frames of keep need select to be optimal; uniform keys are where they are.")
    if not animations or len(counts or animations) != len(animations):
        raise ValueError(
            f"There are {len(animations)} animations and {len(counts or ())} counts; one count for each is needed."
        )
    if any(animation.skeleton.joints != animations[0].skeleton.joints for animation in animations):
        raise ValueError("The animations have different joints; compress those of one rig at a time.")


def _with_ends(animations: Sequence[Animation], only: Sequence[ArrayLike]) -> list[np.ndarray]:
    """Return frames of each animation, increasing, with the first and the last among them."""
    kept = []
    for animation, frames in zip(animations, only, strict=True):
        frames = np.union1d(frames, [0, animation.n_frames - 1])
        if frames[0] < 0 or frames[-1] >= animation.n_frames or (frames != np.round(frames)).any():
            raise ValueError(f"only must hold frames from 0 to {animation.n_frames - 1}, but it is {frames.tolist()}.")
        kept.append(frames.astype(np.intp))
    return kept


def _fit(
    animations: Sequence[Animation],
    scheme: str,
    kind: str,
    progress: Callable[[int, float], None],
    usual_family: str,
    keyframes: Sequence[np.ndarray],
    family: str | None = None,
) -> LearnedMetric | None:
    """Learn a metric roughly, if there is anything to learn from."""
    pairs = zip(animations, keyframes, strict=True)
    sparse = [_thinned(animation, kept) for animation, kept in pairs if len(kept) < animation.n_frames]
    if not any(turns(animation) for animation, _ in sparse):
        return None
    return learn_metric(
        [animation for animation, _ in sparse],
        [kept for _, kept in sparse],
        family=family or usual_family,
        scheme=scheme,
        kind=kind,
        progress=progress,
        rough=True,
    )


def _thinned(animation: Animation, keyframes: np.ndarray) -> tuple[Animation, np.ndarray]:
    """Leave out equally many of the frames between keys where they are far more than tell the shape of a curve."""
    stride = animation.n_frames // (_FRAMES_BETWEEN_KEYS * len(keyframes))
    if stride < 2:
        return animation, keyframes
    frames = np.union1d(np.arange(0, animation.n_frames, stride), keyframes)
    return animation.at_frames(frames), np.searchsorted(frames, keyframes)


def _nothing(keyframes: Sequence[np.ndarray], family: str | None = None) -> None:
    """Learn nothing, for a scheme without a metric."""


class Fit(Protocol):
    """A function that learns a metric."""

    def __call__(self, keyframes: Sequence[np.ndarray], family: str | None = None) -> LearnedMetric | None:
        """Learn a metric for some keys, of the usual family unless another is given; None if nothing turns."""
        ...


def _cheapest(
    problems: Sequence[KeyProblem], kept: Sequence[np.ndarray], *metrics: LearnedMetric | None
) -> LearnedMetric:
    """Choose the metric with the least sum of costs; None is where nothing was learned."""

    def cost(metric: LearnedMetric) -> float:
        pairs = zip(problems, kept, strict=True)
        return sum(float(problem.judge(metric.scheme, metric)(keys).sum()) for problem, keys in pairs)

    return min(filter(None, metrics), key=cost)


def _uniform(problems: Sequence[KeyProblem], plain: LearnedMetric, fit: Fit) -> Compressed:
    """Keep equally spaced keys, for a tolerance at the smallest rate that halving finds."""

    def at(rate: float) -> list[np.ndarray]:
        return [uniform_keyframes(problem.animation.n_frames, rate) for problem in problems]

    def fits(kept: Sequence[np.ndarray], metric: LearnedMetric) -> bool:
        return all(problem.is_within(keys, metric) for problem, keys in zip(problems, kept, strict=True))

    if problems[0].tolerance is None:
        kept = [
            uniform_keyframes(each.animation.n_frames, (each.count or 2) / each.animation.n_frames) for each in problems
        ]
        return Compressed(tuple(kept), _cheapest(problems, kept, plain, fit(kept)))
    most = max(problem.animation.n_frames for problem in problems)
    kept = at(by_halving(lambda count: fits(at(count / most), plain), 1, most) / most)
    metric = fit(kept) or plain
    return Compressed(tuple(kept), metric if fits(kept, metric) else plain)


def _best(problems: Sequence[KeyProblem], start: list[np.ndarray], plain: LearnedMetric, fit: Fit) -> Compressed:
    """Keep the number of keys, and make the error least."""
    diagonal = _cheapest(problems, start, plain, fit(start, "diagonal"))
    kept = _refined(problems, start, diagonal)
    return Compressed(tuple(kept), _cheapest(problems, kept, plain, diagonal, fit(kept)))


def _fewest(problems: Sequence[KeyProblem], start: list[np.ndarray], plain: LearnedMetric, fit: Fit) -> Compressed:
    """Stay within the tolerance, with as few keys as can be."""
    found = [Compressed(tuple(_refined(problems, start, plain)), plain)]
    if plain.scheme == "geodesic-spline":  # without tension it is slerp, for which the first keys are the fewest
        found.append(Compressed(tuple(start), LearnedMetric.plain(plain.joints, plain.scheme, tension=0.0)))
    best = min(found, key=_size)
    for _ in range(_ROUNDS):
        metric = fit(best.keyframes)
        if metric is None:
            break
        learned = Compressed(tuple(_refined(problems, best.keyframes, metric)), metric)
        gained = _size(best) - _size(learned)
        if gained > 0:
            best = learned
        if gained < _LEAST_GAIN * _size(best):
            break
    return best


def _refined(problems: Sequence[KeyProblem], kept: Sequence[np.ndarray], metric: LearnedMetric) -> list[np.ndarray]:
    return [problem.refined(keys, metric.scheme, metric) for problem, keys in zip(problems, kept, strict=True)]


def _size(compressed: Compressed) -> int:
    return sum(map(len, compressed.keyframes))
