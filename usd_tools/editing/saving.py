"""Write what a session has made: the metric over the source, the keys with it, or dense samples."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim import LearnedMetric
from geomstats_anim.interpolation.learned_scheme import Learned
from geomstats_anim.names import BENT, LEARNED, WITH_METRIC
from geomstats_anim.parameters import CurveParameters
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.options import OutputOptions, one_of, option
from usd_tools.downsampling.thinning import restored, write_sparse
from usd_tools.editing.edits import patterns
from usd_tools.editing.motion import EditableMotion
from usd_tools.editing.rebuilt import RebuiltMotion
from usd_tools.editing.state import EditState
from usd_tools.files.openusd_errors import openusd_errors, usd_warnings
from usd_tools.libraries.help import shares
from usd_tools.skel.find import find_animations
from usd_tools.skel.output import Output
from usd_tools.skel.resampling import with_codes
from usd_tools.upsampling.joint_styles import Style

TOOL = "usd_tools.live"
CONTENTS = ("metric", "keys", "dense")


@dataclass(frozen=True, kw_only=True)
class SaveOptions(OutputOptions):
    """Options of saving.

    Parameters
    ----------
    content : str
        "metric": the metric over the source, whose samples stay. "keys": the keys as the only samples, with the metric
        that rebuilds the others, as `downsample` writes them. "dense": a sample at every frame, rebuilt from the keys.
        Optional, default: "metric".
    """

    content: str = option(CONTENTS[0], one_of(CONTENTS))


@dataclass(frozen=True)
class SaveResult:
    """Record of what was saved.

    Parameters
    ----------
    path : Path
        File that was written.
    content : str
    commands : tuple of str
        Command lines that would have made the same motion; KEYS.usdc is a file in between.
    warnings : tuple of str
    """

    path: Path
    content: str
    commands: tuple[str, ...]
    warnings: tuple[str, ...]


@openusd_errors()
def save_edited(motion: EditableMotion, state: EditState, out: Path, options: SaveOptions) -> SaveResult:
    """Write what a state makes of a clip; see `EditSession.save`."""
    messages, clip, stage = Messages(), motion.clip, motion.clip.source.stage
    if options.in_place:
        raise ToolError("A session writes beside its source; name another file.")
    target = Output(motion.path, out, options)
    target.check()
    target.check_layers(stage)
    metric, _ = _with_origin(state.metric, motion, state).for_joints(clip.joints)
    with usd_warnings(messages):
        everyone = find_animations(stage)
        if options.content == "keys":
            target = target.without_source([clip.source])
        layer = target.layer(stage, TOOL, options.settings(), messages)
        if options.content == "keys":
            layer.replace_samples([clip.source], everyone)
            write_sparse(layer, clip, motion.selection.sparse(state.keyframes(motion)), metric, messages)
        elif options.content == "dense":
            sparse = motion.selection.sparse(state.keyframes(motion))
            codes = with_codes(clip, motion.codes)
            dense = restored(sparse, state.metric, codes, library=state.library(motion)).channels
            sampled = {name: channel for name, channel in dense.items() if len(channel.codes)}
            constant = {name: channel.default for name, channel in dense.items() if not len(channel.codes)}
            layer.write_animation(clip.source, sampled, {**clip.missing, **constant}, metric, messages)
        else:
            layer.store_metric(clip, metric, messages)
        target.save(layer)
    commands = _commands(motion, state, metric, target.path, options.content)
    return SaveResult(target.path, options.content, commands, tuple(messages.warnings))


def _with_origin(metric: LearnedMetric, motion: EditableMotion, state: EditState) -> LearnedMetric:
    """Say in the provenance of a metric which library is used with it, and how it differs from the bi-invariant one."""
    origin = {name: value for name, value in metric.provenance.items() if name != "library"}
    if motion.library is not None and metric.scheme == LEARNED:
        curves = RebuiltMotion.of(motion, state).curves
        helps = shares([curve.help for curve in curves if isinstance(curve, Learned)])
        origin["library"] = {"file": motion.library.name, "sha256": motion.library.sha256, "shares": helps}
    styles = [str(style) for style in styles_of(metric)]
    if styles and not metric.quality:
        origin["styles"] = styles
    return replace(metric, provenance=origin)


def _commands(
    motion: EditableMotion, state: EditState, metric: LearnedMetric, out: Path, content: str
) -> tuple[str, ...]:
    """Say which command lines would have made a file: the keys first, then the metric and the samples."""
    prim = ["--prim", motion.clip.path] if len(find_animations(motion.clip.source.stage)) > 1 else []
    commands, source = [], str(motion.path)
    if content != "metric" and not state.is_key.all():
        keys = _numbers(motion.samples[state.is_key])
        commands.append(["downsample", source, "-o", "KEYS.usdc", f"--keep-only={keys}", *prim])
        source = "KEYS.usdc"
    words = ["metric", "set", source]
    if content == "dense":
        times = "source" if commands else _numbers(motion.codes)
        words = ["upsample", source, f"--times={times}", "--no-xforms"]
    if metric.scheme == LEARNED and content == "dense":
        words += ["--library", str(motion.library_path)]
    commands.append([*words, "-o", str(out), *_metric_words(metric), *prim])
    return tuple(f"python -m usd_tools.{shlex.join(words)}" for words in commands)


def _numbers(codes: np.ndarray) -> str:
    return ",".join(repr(float(code)).removesuffix(".0") for code in codes)


def _metric_words(metric: LearnedMetric) -> list[str]:
    """Spell a metric as options of `upsample` and `metric set`."""
    words = ["--scheme", metric.scheme]
    if metric.scheme not in WITH_METRIC:
        return words
    words += ["--metric", "identity"]
    for style in styles_of(metric):
        words += ["--joint", str(style)]
    return words


def styles_of(metric: LearnedMetric) -> Sequence[Style]:
    """Spell a metric as styles of single joints; those at the scheme's defaults need none."""
    usual, names = CurveParameters.plain(metric.scheme, 1), patterns(metric.joints)
    parameters, found = metric.parameters, []
    for i, joint in enumerate(metric.joints):
        settings: dict[str, tuple[Any, Any]] = {
            "alpha": (float(parameters.alpha[i]), 1.0),
            "beta": (float(parameters.beta[i]), 1.0),
            "invariance": (parameters.invariance[i], "left"),
        }
        if metric.scheme in BENT:  # no other has a tension
            settings["tension"] = float(metric.tension[i]), float(usual.tension[0])
            settings["translation_tension"] = float(metric.translation_tension[i]), float(usual.translation_tension[0])
        changed: dict[str, Any] = {name: value for name, (value, default) in settings.items() if value != default}
        if parameters.axes is not None and parameters.axes[i].any():
            changed["axes"] = tuple(np.degrees(parameters.axes[i]).tolist())
        if changed:
            found.append(Style(names[joint], **changed))
    return found
