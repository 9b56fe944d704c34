"""Which metric and scheme each animation gets: what the user asks for, what the file stores, what is styled by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from geomstats_anim import SCHEMES, LearnedMetric
from geomstats_anim.names import DEFAULT_SCHEME, WITH_METRIC
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.text import did_you_mean, short_names
from usd_tools.metrics.attributes import read_metric
from usd_tools.skel.clip import SkelClip
from usd_tools.upsampling.joint_styles import Style, styled, unmatched

_WORDS = ("stored", "identity", "learn")


@dataclass(frozen=True, eq=False)
class EffectiveMetric:
    """What an animation is interpolated with.

    Parameters
    ----------
    metric : LearnedMetric
        For the animation's joints, in its order; its scheme is the one to use.
    origin : str
        "stored", "identity", "learned" or the name of a file.
    missing : tuple of str
        Joints of which a stored or given metric knows nothing.
    """

    metric: LearnedMetric
    origin: str
    missing: tuple[str, ...]

    @property
    def is_used(self) -> bool:
        """Whether the scheme has a metric at all."""
        return self.metric.scheme in WITH_METRIC


def effective_metrics(
    path: Path,
    clips: Sequence[SkelClip],
    wanted: str | None,
    scheme: str | None,
    styles: Sequence[Style],
    messages: Messages,
) -> list[EffectiveMetric]:
    """Find the metric and the scheme for each animation.

    Parameters
    ----------
    path : Path
        File that the animations are in.
    clips : sequence of SkelClip
    wanted : str or None
        "stored", "identity", "learn", a JSON file, or None for the stored one where there is one, else the identity.
    scheme : str or None
        A name in `SCHEMES`, or None for the one that the metric was made for.
    styles : sequence of Style
        Applied to all.
    messages : Messages
        Told of joints that are missing.

    Returns
    -------
    metrics : list of EffectiveMetric

    Raises
    ------
    ToolError
        If a metric is not there or malformed, its scheme is not known, or a style or the file matches no joint.
    """
    every_joint = [joint for clip in clips for joint in clip.joints]
    lost = unmatched(styles, every_joint)
    if lost is not None:
        near = did_you_mean(lost.pattern, [*short_names(every_joint).values(), *every_joint])
        raise ToolError(f"--joint {lost.pattern} matches no joint{near or f'; the file has {_a_few(every_joint)}.'}")
    from_file = None if wanted in (None, *_WORDS) else _read_file(Path(str(wanted)))
    if from_file is not None and not set(from_file.joints) & set(every_joint):
        raise ToolError(f"--metric {wanted} has an entry for no joint of this file, which has {_a_few(every_joint)}.")
    return [_effective(path, clip, wanted, from_file, scheme, styles, messages) for clip in clips]


def _effective(
    path: Path,
    clip: SkelClip,
    wanted: str | None,
    from_file: LearnedMetric | None,
    scheme: str | None,
    styles: Sequence[Style],
    messages: Messages,
) -> EffectiveMetric:
    base, origin = from_file, Path(str(wanted)).name
    if wanted == "learn" and clip.joints:
        from usd_tools.upsampling.self_taught import taught_by_itself

        base, origin = taught_by_itself(path, clip, scheme, messages), "learned"
    elif from_file is None:
        base, origin = (None if wanted in ("identity", "learn") else read_metric(clip.source.prim)), "stored"
    if base is None and wanted == "stored":
        raise ToolError(f"{clip.path} stores no metric; leave --metric out, or choose the animation with --prim.")
    missing: tuple[str, ...] = ()
    if base is None:
        metric, origin = LearnedMetric.plain(clip.joints, DEFAULT_SCHEME), "identity"
    else:
        metric, missing = base.for_joints(clip.joints)
        if missing:
            messages.warn(f"{clip.path}: the metric knows nothing of {', '.join(missing)}; the identity is used there.")
    if scheme is None and metric.scheme not in SCHEMES:
        raise ToolError(
            f"{clip.path}: the metric asks for the scheme {metric.scheme!r}, which this program does not have; "
            f"choose --scheme {', '.join(SCHEMES)}."
        )
    try:
        metric = styled(metric.for_scheme(scheme or metric.scheme), styles)
    except ValueError as error:
        raise ToolError(f"{clip.path} cannot be styled so: {error}") from error
    return EffectiveMetric(metric, origin, missing)


def _read_file(path: Path) -> LearnedMetric:
    try:
        return LearnedMetric.from_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ToolError(
            f"--metric {path}: there is no such file; say stored, identity, learn or a JSON file."
        ) from error
    except OSError as error:
        raise ToolError(f"--metric {path} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise ToolError(f"--metric {path}: {error}") from error


def _a_few(joints: Sequence[str], count: int = 5) -> str:
    names = list(dict.fromkeys(joint.rsplit("/", 1)[-1] for joint in joints))
    if not names:
        return "no joints at all"
    return ", ".join(names[:count]) + (f" and {len(names) - count} more" if len(names) > count else "")
