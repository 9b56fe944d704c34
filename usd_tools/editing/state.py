"""State that edits change: the metric and the keys. Every edit gives a new state, so that undoing is going back."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geomstats_anim import LearnedMetric, MetricParameters, optimal_keyframes
from geomstats_anim.names import DEFAULT_SCHEME, LEARNED, SCHEME_NAMES
from geomstats_anim.parameters import CurveParameters
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.text import did_you_mean, short_names
from usd_tools.editing.edits import (
    ChooseKeys,
    Edit,
    EveryNth,
    FreeKey,
    KeepOnly,
    KeyEdit,
    Mirror,
    PinKey,
    Reset,
    UseMetric,
    UseScheme,
)
from usd_tools.editing.motion import EditableMotion
from usd_tools.skel.stored_metric import stored_metric
from usd_tools.upsampling.joint_styles import Style, styled, unmatched

if TYPE_CHECKING:
    from geomstats_anim.learning.library.motion_library import MotionLibrary

_SIDES = (("left", "right"), ("l", "r"))
"""Words for the sides of a body, as parts of joint names."""


@dataclass(frozen=True, eq=False)
class EditState:
    """Metric and keys.

    Parameters
    ----------
    metric : LearnedMetric
        For all joints of the skeleton, with the scheme.
    is_key : array-like of bool, shape=[S]
        Which samples are keys.
    """

    metric: LearnedMetric
    is_key: np.ndarray

    @classmethod
    def start(cls, motion: EditableMotion, messages: Messages) -> EditState:
        """Return the state before any edit: the metric that the file stores, the scheme of a library if there is one.

        All samples are keys.

        Told are joints of which that metric has no entry.

        Raises
        ------
        ToolError
            If it cannot be read, or its scheme does not exist.
        """
        joints, path = motion.skeleton.joints, motion.clip.path
        metric, stored = LearnedMetric.plain(joints, DEFAULT_SCHEME), stored_metric(motion.clip.source)
        if stored is not None:
            _check_scheme(stored, f"{path}: the metric")
            metric, _ = stored.for_joints(joints)
            missing = [joint for joint in motion.clip.joints if joint not in stored.joints]
            if missing:
                names = short_names(joints)
                lost = ", ".join(names[joint] for joint in missing)
                messages.warn(f"{path}: the metric has no entry for {lost}; using the identity there.")
            if metric.scheme == LEARNED and motion.library is None:
                messages.warn(f"{path}: the scheme {LEARNED} needs a library, see --library; using {DEFAULT_SCHEME}.")
                metric = metric.for_scheme(DEFAULT_SCHEME)
        if motion.library is not None:
            metric = metric.for_scheme(LEARNED)
        return cls(metric, np.ones(len(motion.samples), dtype=bool))

    def keyframes(self, motion: EditableMotion) -> list[np.ndarray]:
        """Return the frames of each stretch that are keys."""
        return [np.flatnonzero(self.is_key[part.samples]) for part in motion.parts]

    def library(self, motion: EditableMotion) -> MotionLibrary | None:
        """Return the library that the scheme uses; None for a scheme without one."""
        return motion.library.library if motion.library is not None and self.metric.scheme == LEARNED else None


def edited(state: EditState, edit: Edit, motion: EditableMotion) -> EditState:
    """Apply an edit.

    Raises
    ------
    ToolError
        If it does not fit the clip.
    """
    if isinstance(edit, KeyEdit):
        return replace(state, is_key=_with_ends(_keys(state, edit, motion), motion))
    metric = edited_metric(state.metric, edit)
    if metric.scheme == LEARNED and motion.library is None:
        raise ToolError(f"The scheme {LEARNED} needs a library; open the clip with --library FILE.")
    return replace(state, metric=metric)


def edited_metric(metric: LearnedMetric, edit: Edit) -> LearnedMetric:
    """Apply an edit that is not of keys to a metric.

    Raises
    ------
    ToolError
        If it does not fit the metric's joints.
    """
    joints = metric.joints
    if isinstance(edit, UseMetric):
        if not set(edit.metric.joints) & set(joints):
            raise ToolError("The metric has an entry for no joint of this clip.")
        _check_scheme(edit.metric, "The metric")
        return edit.metric.for_joints(joints)[0]
    if isinstance(edit, UseScheme):
        return metric.for_scheme(edit.scheme)
    pattern = edit.pattern  # type: ignore[union-attr]
    if unmatched([Style(pattern)], joints) is not None:
        near = did_you_mean(pattern, [*short_names(joints).values(), *joints])
        raise ToolError(f"{pattern!r} matches no joint{near or '.'}")
    if isinstance(edit, Mirror):
        return _mirrored(metric, pattern)
    style = _reset(edit.pattern, metric.scheme) if isinstance(edit, Reset) else edit
    assert isinstance(style, Style)
    try:
        changed = styled(metric, [style])
    except ValueError as error:
        raise ToolError(f"{style} cannot be applied: {error}") from error
    # the session remembers its edits, so the metric need not
    return replace(changed, provenance=metric.provenance)


def _check_scheme(metric: LearnedMetric, what: str) -> None:
    if metric.scheme not in SCHEME_NAMES:
        raise ToolError(
            f"{what} names the scheme {metric.scheme!r}, which cannot be used here; the schemes are "
            f"{', '.join(SCHEME_NAMES)}."
        )


def _reset(pattern: str, scheme: str) -> Style:
    usual = CurveParameters.plain(scheme, 1)
    tension, translation_tension = float(usual.tension[0]), float(usual.translation_tension[0])
    return Style(pattern, 1.0, 1.0, "left", tension, translation_tension, (0.0, 0.0, 0.0))


def _mirrored(metric: LearnedMetric, pattern: str) -> LearnedMetric:
    place = {joint: i for i, joint in enumerate(metric.joints)}
    pairs = [(i, place.get(counterpart(joint), i)) for joint, i in place.items() if Style(pattern).matches(joint)]
    pairs = [(one, other) for one, other in pairs if one != other]
    if not pairs:
        raise ToolError(f"{pattern!r} matches no joint with a counterpart on the other side.")
    source = np.arange(len(place))
    source[[other for _, other in pairs]] = [one for one, _ in pairs]
    old = metric.parameters
    parameters = MetricParameters(
        old.alpha[source],
        old.beta[source],
        None if old.axes is None else old.axes[source],
        tuple(old.invariance[i] for i in source),
    )
    tensions = {"tension": metric.tension[source], "translation_tension": metric.translation_tension[source]}
    return replace(metric, parameters=parameters, quality="", **tensions)


def counterpart(joint: str) -> str:
    """Return the name of the joint on the other side: words for left and right, exchanged in the whole path."""
    words = re.split(r"(?<=[a-z])(?=[A-Z])|(?<=[^A-Za-z])(?=[A-Za-z])|(?<=[A-Za-z])(?=[^A-Za-z])", joint)
    return "".join(_other_side(word) for word in words)


def _other_side(word: str) -> str:
    for left, right in (*_SIDES, *((right, left) for left, right in _SIDES)):
        if word.lower() == left:
            return right.upper() if word.isupper() else right.title() if word.istitle() else right
    return word


def _keys(state: EditState, edit: Edit, motion: EditableMotion) -> np.ndarray:
    samples = motion.samples
    is_key = np.zeros(len(samples), dtype=bool)
    if isinstance(edit, EveryNth):
        for part in motion.parts:
            is_key[part.samples][:: edit.n] = True
    elif isinstance(edit, KeepOnly):
        is_key[_samples(np.array(edit.codes), samples)] = True
    elif isinstance(edit, PinKey | FreeKey):
        is_key = state.is_key.copy()
        is_key[_samples(np.array([edit.code]), samples)] = isinstance(edit, PinKey)
    elif isinstance(edit, ChooseKeys):
        if edit.count > len(samples):
            raise ToolError(f"{edit.count} keys cannot be chosen of {len(samples)} samples.")
        for part, count in zip(motion.parts, _shares(edit.count, motion), strict=True):
            try:
                is_key[part.samples][optimal_keyframes(part.animation, count)] = True
            except ValueError as error:
                raise ToolError(f"{edit.count} keys cannot be chosen: {error}") from error
    return is_key


def _with_ends(is_key: np.ndarray, motion: EditableMotion) -> np.ndarray:
    """Make keys of the ends of stretches, and of samples in none: no curve leads to them."""
    kept = np.ones(len(is_key), dtype=bool)
    for part in motion.parts:
        kept[part.samples.start + 1 : part.samples.stop - 1] = False
    return is_key | kept


def _shares(count: int, motion: EditableMotion) -> list[int]:
    """Distribute keys over the stretches by their length."""
    sizes = np.array([part.animation.n_frames for part in motion.parts])
    shares: Sequence[int] = np.round(count * sizes / sizes.sum()).astype(int).tolist()
    return [int(np.clip(share, 2, size)) for share, size in zip(shares, sizes.tolist(), strict=True)]


def _samples(codes: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Find the samples at time codes; what is off by rounding is there."""
    after = np.clip(np.searchsorted(samples, codes), 1, len(samples) - 1)
    nearest = np.where(codes - samples[after - 1] < samples[after] - codes, after - 1, after)
    far = np.flatnonzero(np.abs(samples[nearest] - codes) > 1e-6 * np.maximum(1.0, np.abs(codes)))
    if len(far):
        code, near = codes[far[0]], samples[nearest[far[0]]]
        raise ToolError(f"There is no sample at time code {code:g}; the nearest is at {near:g}.")
    return nearest
