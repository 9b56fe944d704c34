"""The metric and scheme of each animation: as asked for, as stored in the file, as learned here, as set by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from geomstats_anim import LearnedMetric
from geomstats_anim.names import DEFAULT_SCHEME, LEARNABLE, LEARNED, SCHEME_NAMES, WITH_METRIC
from geomstats_anim.strict_json import read_text
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import ProgressCallback
from usd_tools.console.text import did_you_mean, short_names
from usd_tools.files.paths import EXTENSIONS, extension
from usd_tools.files.stages import open_stage
from usd_tools.metrics.attributes import uncoupled
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.find import find_animations
from usd_tools.skel.stored_metric import stored_metric
from usd_tools.upsampling.joint_styles import Style, styled, unmatched
from usd_tools.upsampling.options import StyleOptions

if TYPE_CHECKING:
    from geomstats_anim.learning.library.motion_library import MotionLibrary
    from usd_tools.libraries.files import LibraryFile

LEARNING_RATE = 0.5
"""Share of samples that are keys when a clip teaches itself: twice the spacing, and the only one near it with truth."""


@dataclass(frozen=True, eq=False)
class ChosenMetric:
    """The metric that an animation is interpolated with.

    Parameters
    ----------
    metric : LearnedMetric
        For the animation's joints, in its order; its scheme is the one to use.
    origin : str
        "stored", "identity", "learned" or the name of a file.
    missing : tuple of str
        Joints of which a stored or given metric has no entry.
    learned : str
        What learning brought, a sentence; "" if nothing was learned.
    library_file : LibraryFile or None
        For the scheme "learned".
    """

    metric: LearnedMetric
    origin: str
    missing: tuple[str, ...]
    learned: str = ""
    library_file: LibraryFile | None = None

    @property
    def library(self) -> MotionLibrary | None:
        """The library itself."""
        return None if self.library_file is None else self.library_file.library

    @property
    def is_used(self) -> bool:
        """True if the scheme has a metric at all."""
        return self.metric.scheme in WITH_METRIC


def choose_metrics(
    path: Path,
    clips: Sequence[SkelClip],
    options: StyleOptions,
    messages: Messages,
    progress: ProgressCallback | None = None,
    library: LibraryFile | None = None,
) -> list[ChosenMetric]:
    """Choose the metric and the scheme for each animation.

    Parameters
    ----------
    path : Path
        File that the animations are in.
    clips : sequence of SkelClip
    options : StyleOptions
        Its metric, scheme and styles.
    messages : Messages
        Told of joints that are missing.
    progress : ProgressCallback
        Of learning.
        Optional, default: none.
    library : LibraryFile
        For the scheme "learned", which it implies.
        Optional, default: none.

    Returns
    -------
    metrics : list of ChosenMetric

    Raises
    ------
    ToolError
        If a metric is not there or malformed, its scheme is not known, a style or the file matches no joint, or
        the library is of another rig.
    """
    every_joint = [joint for clip in clips for joint in clip.joints]
    check_styles(options.styles, clips)
    from_file = _read_file(options.metric) if isinstance(options.metric, Path) else None
    if from_file is not None and not set(from_file.joints) & set(every_joint):
        raise ToolError(
            f"--metric {options.metric} has an entry for no joint of this file, which has {_a_few(every_joint)}."
        )
    return [_choose(path, clip, from_file, library, options, messages, progress) for clip in clips]


def check_styles(styles: Sequence[Style], clips: Sequence[SkelClip]) -> None:
    """Refuse a style that matches no joint of any clip.

    Raises
    ------
    ToolError
    """
    every_joint = [joint for clip in clips for joint in clip.joints]
    lost = unmatched(styles, every_joint)
    if lost is not None:
        near = did_you_mean(lost.pattern, [*short_names(every_joint).values(), *every_joint])
        raise ToolError(f"--joint {lost.pattern} matches no joint{near or f'; the file has {_a_few(every_joint)}.'}")


def apply_styles(clip: SkelClip, metric: LearnedMetric, options: StyleOptions) -> LearnedMetric:
    """Give a metric for a clip's joints the scheme and the styles that are asked for.

    Raises
    ------
    ToolError
        If the scheme does not exist, or a style makes no metric.
    """
    if options.scheme is None and metric.scheme not in SCHEME_NAMES:
        raise ToolError(
            f"{clip.path}: the metric names the scheme {metric.scheme!r}, which does not exist; choose --scheme "
            f"{', '.join(SCHEME_NAMES)}."
        )
    try:
        return styled(metric.for_scheme(options.scheme or metric.scheme), options.styles)
    except ValueError as error:
        raise ToolError(f"{clip.path}: invalid --alpha, --beta or --joint: {error}") from error


def _choose(
    path: Path,
    clip: SkelClip,
    from_file: LearnedMetric | None,
    library: LibraryFile | None,
    options: StyleOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> ChosenMetric:
    base, origin, learned = from_file, "stored", ""
    if isinstance(options.metric, Path):
        origin = options.metric.name
    elif options.metric == "learn" and clip.joints:
        origin = "learned"
        scheme = DEFAULT_SCHEME if options.scheme == LEARNED else options.scheme
        base, learned = learn_from_clip(path, clip, scheme, messages, progress)
    elif options.metric not in ("identity", "learn"):
        base = stored_metric(clip.source)
        if base is None and options.metric == "stored":
            raise ToolError(f"{clip.path} stores no metric; leave --metric out, or choose the animation with --prim.")
    missing: tuple[str, ...] = ()
    if base is None:
        metric, origin = LearnedMetric.plain(clip.joints, DEFAULT_SCHEME), "identity"
    else:
        metric, missing = base.for_joints(clip.joints)
        if missing:
            names = short_names(clip.joints)
            lost = f"joint{'' if len(missing) == 1 else 's'} {', '.join(names[joint] for joint in missing)}"
            messages.warn(f"{clip.path}: the metric has no entry for {lost}; using the identity there.")
    if library is not None and clip.joints:
        library.check(clip)
        metric = metric.for_scheme(LEARNED)
    return ChosenMetric(apply_styles(clip, metric, options), origin, missing, learned, library)


def learn_from_clip(
    path: Path, clip: SkelClip, scheme: str | None, messages: Messages, progress: ProgressCallback | None
) -> tuple[LearnedMetric, str]:
    """Learn a metric from the animation that is to be upsampled.

    Every other sample is a key, and the metric is sought that predicts the samples between: the same task as putting
    a new sample into every gap, at twice the spacing. It is for frames that nobody has seen, so the purpose is to
    predict: cross-validation shrinks the metric towards the bi-invariant one, unless it is sure of a gain.

    Parameters
    ----------
    path : Path
        File that the animation is in.
    clip : SkelClip
    scheme : str or None
        Scheme to learn for; None for the usual one.
    messages : Messages
        Told if there is nothing to learn from, so that the identity is used.
    progress : ProgressCallback or None

    Returns
    -------
    metric : LearnedMetric
    learned : str
        What it brings, a sentence; "" if there is nothing to learn from.

    Raises
    ------
    ToolError
        If nothing can be learned for the scheme.
    """
    from usd_tools.console.progress import SearchProgress
    from usd_tools.learning.clips import training_clip
    from usd_tools.learning.options import LearnOptions
    from usd_tools.learning.train import learn_and_assess

    if scheme is not None and scheme not in LEARNABLE:
        raise ToolError(f"--metric learn needs --scheme {' or '.join(LEARNABLE)}, not {scheme}.")
    options = LearnOptions(rate=LEARNING_RATE, purpose="predict", scheme=scheme or DEFAULT_SCHEME)
    try:
        found = learn_and_assess([training_clip(path, clip)], options, SearchProgress(progress, None).watch)
    except ToolError as error:
        messages.warn(f"{str(error).rstrip('.')}; using the identity.")
        return LearnedMetric.plain(clip.joints, options.scheme), ""
    if found.is_plain:
        plain = "the plain spline" if options.scheme == "geodesic-spline" else "slerp"
        gained = f"no metric reliably predicts the others better than {plain}, which is kept"
    else:
        unseen = found.cross_validated
        assert unseen is not None
        tie = ", a tie" if unseen.ties else ""
        gained = f"cross-validated, it predicts the others {unseen.beside_rival}{tie}"
    return found.metric, f"{clip.path}: fit on every other sample; {gained}."


def _read_file(path: Path) -> LearnedMetric:
    if extension(path) in EXTENSIONS:
        return _read_usd(path)
    try:
        return uncoupled(LearnedMetric.from_json(read_text(path)), f"--metric {path}")
    except FileNotFoundError as error:
        raise ToolError(
            f"--metric {path}: there is no such file; use stored, identity, learn, a JSON file or a USD file."
        ) from error
    except OSError as error:
        raise ToolError(f"--metric {path} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise ToolError(f"--metric {path}: {error}") from error


def _read_usd(path: Path) -> LearnedMetric:
    """Read the metric that a USD file stores, the only one or the same for all of its animations."""
    found = [metric for source in find_animations(open_stage(path)) if (metric := stored_metric(source)) is not None]
    texts = {metric.to_json() for metric in found}
    if not texts:
        raise ToolError(f"{path} stores no metric; usd_tools.learn and usd_tools.metric set store one.")
    if len(texts) > 1:
        raise ToolError(f"{path} stores {len(texts)} metrics; write one to a JSON file with usd_tools.metric export.")
    return found[0]


def _a_few(joints: Sequence[str], count: int = 5) -> str:
    names = list(short_names(list(dict.fromkeys(joints))).values())
    if not names:
        return "no joints at all"
    return ", ".join(names[:count]) + (f" and {len(names) - count} more" if len(names) > count else "")
