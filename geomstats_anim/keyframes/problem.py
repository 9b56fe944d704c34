"""Equally spaced keys, and the problem that optimal keys solve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim.animation import Animation
from geomstats_anim.criteria import joint_weights, kind_shares
from geomstats_anim.interpolation.curves import Metric
from geomstats_anim.interpolation.schemes import SCHEMES
from geomstats_anim.interpolation.tangents import STILL
from geomstats_anim.kernels.segment_errors import hold_starts
from geomstats_anim.keyframes.coarse_to_fine import cheapest_keys
from geomstats_anim.keyframes.dynamic_programming import Measure, UnreachableError, fewest
from geomstats_anim.keyframes.local_search import Judge, judge_of, moved, thinned
from geomstats_anim.learned_metric import LearnedMetric
from geomstats_anim.markers import Markers
from geomstats_anim.names import CRITERIA, KINDS, LARGEST

_HOLD_SECONDS = 0.25
"""A pose that stays for less is no hold, but animation on twos or threes."""


def uniform_keyframes(n_frames: int, rate: float) -> np.ndarray:
    """Choose equally spaced keys, as the papers do (Kushner, Modi, Miolane, section 4.1).

    Parameters
    ----------
    n_frames : int
        Frames of the animation, F.
    rate : float
        Share of the frames to keep, in (0, 1].

    Returns
    -------
    indices : array-like of int, shape=[K]
        max(2, round(rate F)) indices, equally spaced up to rounding, the first and the last frame included.

    Raises
    ------
    ValueError
        If there are fewer than two frames, or the rate is outside (0, 1].

    Examples
    --------
    >>> from geomstats_anim import uniform_keyframes
    >>> uniform_keyframes(10, 0.4)
    array([0, 3, 6, 9])
    """
    if n_frames < 2:
        raise ValueError(f"Keys need at least 2 frames, but there are {n_frames}.")
    if not 0.0 < rate <= 1.0:
        raise ValueError(f"The rate must be above 0 and at most 1, but it is {rate}.")
    n_keys = max(2, round(rate * n_frames))
    return np.round(np.linspace(0, n_frames - 1, n_keys)).astype(np.intp)


def by_halving(is_enough: Callable[[int], bool], too_few: int, enough: int) -> int:
    """Halve the way between a number that is too few and one that is enough, down to two neighbours; return the upper.

    It is the least that is enough, unless fewer are enough where more are not.
    """
    while enough - too_few > 1:
        middle = (too_few + enough) // 2
        too_few, enough = (too_few, middle) if is_enough(middle) else (middle, enough)
    return enough


def optimal_keyframes(
    animation: Animation,
    count: int | None = None,
    tolerance: float | None = None,
    *,
    kind: str | None = None,
    scheme: str = "slerp",
    metric: Metric | None = None,
    keep: ArrayLike = (),
    weights: str | ArrayLike | None = None,
    location_weight: float = 0.5,
    markers: Markers | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> np.ndarray:
    """Choose the keys from which an animation is rebuilt best, or the fewest from which it is rebuilt well enough.

    For slerp the choice is exact, by dynamic programming over the error of every segment, as in Roberts et al.,
    "Salient Poses" (2019), as long as no segment is several times longer than usual; a count is sought from coarse to
    fine where a clip is too long for that, see `coarse_to_fine`. For other schemes that choice is
    where a search begins which moves, removes and adds keys under the scheme itself.

    Parameters
    ----------
    animation : Animation
    count : int
        Keys to keep, K. Either this or the tolerance.
    tolerance : float
        Metres in the world that no marker may be away from its place in any frame. Scales are taken to be kept at
        all frames.
    kind : str
        What `count` keys should make least: "loc", "rot" or "hyb", see `quality`; or "max", the largest distance of a
        bone end, which is what a tolerance is about.
        Optional, default: "hyb" for a count, "max" for a tolerance.
    scheme : str
        A name in `SCHEMES`: what will rebuild the frames.
        Optional, default: "slerp".
    metric : MetricParameters or LearnedMetric
        For the geodesic schemes; `compress` learns it along with the keys.
        Optional, default: the bi-invariant metric.
    keep : array-like of int
        Frames that must be keys, besides the first, the last and both ends of every hold, which always are.
        Optional, default: none.
    weights : None, "depth" or array-like, shape=[B]
        Optional, default: None.
    location_weight : float
        Share of "loc" in "hyb".
        Optional, default: 0.5.
    markers : Markers
        Points that a tolerance, and "max", are about.
        Optional, default: every joint, and the end of its bone.
    progress : callable
        Called with the share of the work that is done, from 0 to 1, while a count is sought in many frames.

    Returns
    -------
    indices : array-like of int, shape=[K]
        Increasing. The same arguments give the same keys.

    Raises
    ------
    ValueError
        If there are fewer than two frames, both or none of `count` and `tolerance` are given, `count` is less than the
        frames that must stay or more than there are, or a word is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import Animation, Skeleton, optimal_keyframes
    >>> skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    >>> angle = np.interp(np.arange(11), [0, 3, 10], [0.0, 1.0, 1.5])  # fast, then slow
    >>> turn = np.stack([np.sin(angle / 2), 0 * angle, 0 * angle, np.cos(angle / 2)], axis=-1)[:, None]
    >>> swing = Animation(skeleton, np.arange(11) / 30, turn, np.zeros((11, 1, 3)))
    >>> optimal_keyframes(swing, count=3)
    array([ 0,  3, 10])
    """
    problem = KeyProblem.of(animation, count, tolerance, kind, keep, weights, location_weight, markers)
    if scheme not in SCHEMES:
        raise ValueError(f"There is no scheme {scheme!r}; the schemes are {', '.join(SCHEMES)}.")
    return problem.refined(problem.under_slerp(progress), scheme, metric)


@dataclass(frozen=True, eq=False)
class KeyProblem:
    """Number of keys to choose, the criterion, and the frames that must be among them.

    Parameters
    ----------
    animation : Animation
    measure : Measure
    count : int or None
    tolerance : float or None
    fixed : array-like of int
        Frames that must be keys.
    held : array-like of int
        Frames within a hold, which are no use as keys.
    """

    animation: Animation
    measure: Measure
    count: int | None
    tolerance: float | None
    fixed: np.ndarray
    held: np.ndarray

    @classmethod
    def of(
        cls,
        animation: Animation,
        count: int | None,
        tolerance: float | None,
        kind: str | None = None,
        keep: ArrayLike = (),
        weights: str | ArrayLike | None = None,
        location_weight: float = 0.5,
        markers: Markers | None = None,
    ) -> KeyProblem:
        """Check the arguments of `optimal_keyframes`."""
        n_frames = animation.n_frames
        if n_frames < 2:
            raise ValueError(f"Keys need at least 2 frames, but there are {n_frames}.")
        if (count is None) == (tolerance is None):
            raise ValueError(
                f"Either count or tolerance must be given, but count is {count} and tolerance is {tolerance}."
            )
        if tolerance is not None and not tolerance > 0.0:
            raise ValueError(f"The tolerance must be above 0 metres, but it is {tolerance}.")
        if tolerance is not None and kind not in (None, LARGEST):
            raise ValueError(f'A tolerance is about kind "{LARGEST}", but kind is {kind!r}; leave it out.')
        kind = kind or ("hyb" if tolerance is None else LARGEST)
        measure = _measure(kind, animation, weights, location_weight, markers)
        kept = np.asarray(keep)
        if kept.size and (not np.equal(kept, np.round(kept)).all() or kept.min() < 0 or kept.max() >= n_frames):
            raise ValueError(f"keep must hold frames from 0 to {n_frames - 1}, but it is {kept.tolist()}.")
        ends, inner = _holds(animation)
        fixed = np.unique(np.concatenate([[0, n_frames - 1], ends, kept.astype(np.intp)])).astype(np.intp)
        inner = inner[~np.isin(inner, fixed)]
        return cls(animation, measure, count, tolerance, fixed, inner)

    def under_slerp(self, progress: Callable[[float], None] = lambda share: None) -> np.ndarray:
        """Choose the best keys for slerp; see `optimal_keyframes`."""
        n_frames, count = self.animation.n_frames, self.count
        free = np.setdiff1d(np.arange(n_frames), self.held)
        if count is None:
            assert self.tolerance is not None
            try:
                return free[fewest(self.animation, free, np.isin(free, self.fixed), self.tolerance, self.measure)]
            except UnreachableError:  # holds move by more than the tolerance
                every = np.arange(n_frames)
                return fewest(self.animation, every, np.isin(every, self.fixed), self.tolerance, self.measure)
        if not len(self.fixed) <= count <= n_frames:
            raise ValueError(
                f"count is {count}, but {len(self.fixed)} of {n_frames} frames must stay: the ends, those of holds and "
                f"those of keep; say {len(self.fixed)} to {n_frames}."
            )
        if count == len(self.fixed):
            return self.fixed
        # what is left over goes into the holds
        free = np.union1d(free, self.held[: max(0, count - len(free))])
        forced = np.isin(free, self.fixed)
        return free[cheapest_keys(self.animation, free, forced, count, self.measure, progress)]

    def judge(self, scheme: str, metric: Metric | None) -> Judge:
        """Make the function that returns the cost of every frame under a scheme."""
        return judge_of(self.animation, self.measure, scheme, metric, self.tolerance)

    def is_within(self, keys: np.ndarray, metric: LearnedMetric) -> bool:
        """Return whether every frame is within the tolerance."""
        return bool(self.judge(metric.scheme, metric)(keys).max() <= 1.0)

    def refined(self, keys: np.ndarray, scheme: str, metric: Metric | None) -> np.ndarray:
        """Improve the best keys for slerp under a scheme; for a tolerance, their number changes."""
        if scheme == "slerp":
            return keys
        judge = self.judge(scheme, metric)
        if self.tolerance is not None:
            return thinned(judge, keys, self.fixed)
        return moved(judge, keys, self.fixed)


def _measure(
    kind: str,
    animation: Animation,
    weights: str | ArrayLike | None,
    location_weight: float,
    markers: Markers | None,
) -> Measure:
    by_joint = joint_weights(weights, animation.skeleton)
    if kind == LARGEST:
        return Measure(0.0 * by_joint, 0.0 * by_joint, markers or Markers.of_bones(animation.skeleton))
    if kind not in KINDS:
        raise ValueError(f"There is no kind {kind!r}; the kinds are {', '.join(CRITERIA)}.")
    shares = kind_shares(kind, location_weight)
    return Measure(shares.location * by_joint, shares.rotation * by_joint)


def _holds(animation: Animation) -> tuple[np.ndarray, np.ndarray]:
    """Return the frames at both ends of every hold of the whole skeleton, and those within."""
    first = np.zeros(animation.n_frames, dtype=np.intp)
    hold_starts(np.array(animation.rotations), np.array(animation.translations), STILL, first)
    starts = np.unique(first)
    stops = np.append(starts[1:], animation.n_frames) - 1
    long = animation.times[stops] - animation.times[starts] >= _HOLD_SECONDS
    starts, stops = starts[long], stops[long]
    inner = [np.arange(a + 1, b) for a, b in zip(starts, stops, strict=True)]
    return np.concatenate([starts, stops]), np.concatenate([*inner, np.zeros(0, dtype=np.intp)]).astype(np.intp)
