"""The work of `metric`, on files and on open stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from pathlib import Path

from pxr import Usd

from geomstats_anim import LearnedMetric
from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import ProgressCallback
from usd_tools.console.text import did_you_mean, listed
from usd_tools.editing.edits import Edit, KeyEdit
from usd_tools.editing.presets import PRESETS, read_preset
from usd_tools.editing.state import edited_metric
from usd_tools.files.atomic import write_json, written_beside
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.paths import check_output, same_file
from usd_tools.files.stages import open_stage, stage_path
from usd_tools.metrics.validation import validate_metric
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.output import Output
from usd_tools.skel.stored_metric import stored_metric
from usd_tools.skel.writer import AnimationLayer
from usd_tools.styling.options import MetricOptions
from usd_tools.styling.result import TOOL, AnimationMetric, MetricResult
from usd_tools.upsampling.clips import check_styles_count
from usd_tools.upsampling.metric import apply_styles, check_styles, choose_metrics
from usd_tools.upsampling.options import StyleOptions


@openusd_errors()
def show_file(source: Path, prim: Sequence[str], warn: Callable[[str], None] | None) -> MetricResult:
    """Show the metrics of a file; see `usd_tools.metric.show_metric`."""
    messages = Messages(warn)
    with usd_warnings(messages), reading(source):
        return _shown(source, open_stage(source), prim, messages)


@openusd_errors()
def show_open_stage(stage: Usd.Stage, prim: Sequence[str], warn: Callable[[str], None] | None) -> MetricResult:
    """Show the metrics of an open stage; see `usd_tools.metric.show_metric_stage`."""
    messages, path = Messages(warn), stage_path(stage)
    with usd_warnings(messages), reading(path):
        return _shown(path, stage, prim, messages)


@openusd_errors()
def export_file(source: Path, out: Path, prim: Sequence[str], warn: Callable[[str], None] | None) -> MetricResult:
    """Write the metric of a file as JSON; see `usd_tools.metric.export_metric`."""
    if out.suffix != ".json":
        raise ToolError(f"--out {out}: a metric is exported as JSON, so the name must end in .json.")
    check_output(out, "--out")
    messages = Messages(warn)
    with usd_warnings(messages), reading(source):
        sources = select_animations(source, find_animations(open_stage(source)), prim)
        found = [(each.path, metric) for each in sources if (metric := stored_metric(each)) is not None]
    texts = {metric.to_json() for _, metric in found}
    if not texts:
        raise ToolError(f"{source} stores no metric; usd_tools.learn and usd_tools.metric set store one.")
    if len(texts) > 1:
        raise ToolError(f"{source} stores {len(texts)} metrics; choose one with --prim.")
    with written_beside(out) as beside:
        beside.write_text(texts.pop(), encoding="utf-8")
    animations = tuple(AnimationMetric(*each) for each in found)
    return MetricResult(source.name, out, out.name, {}, animations, tuple(messages.warnings))


@openusd_errors()
def set_file(
    source: Path,
    out: Path | None,
    options: MetricOptions,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> MetricResult:
    """Set the metrics of a file; see `usd_tools.metric.set_metric`."""
    if out is None and not options.in_place:
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    if isinstance(options.metric, Path) and same_file(target.path, [options.metric]):
        raise ToolError(f"--out {target.path} is where the metric comes from; choose another name.")
    with usd_warnings(messages), reading(source):
        stage = open_stage(source)
        target.check_layers(stage)
        clips, metrics = _set(source, stage, options, messages)
        layer = target.layer(stage, TOOL, options.settings(), messages)
        _write(layer, clips, metrics, messages)
        target.save(layer)
    result = _result(source, target.path, target.path.name, options, clips, metrics, messages)
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def set_open_stage(stage: Usd.Stage, options: MetricOptions, warn: Callable[[str], None] | None) -> MetricResult:
    """Set the metrics of an open stage; see `usd_tools.metric.set_metric_stage`."""
    messages, path, layer = Messages(warn), stage_path(stage), EditTargetLayer(stage)
    with usd_warnings(messages), reading(path):
        clips, metrics = _set(path, stage, options, messages)
        with layer.editing():
            _write(layer, clips, metrics, messages)
    return _result(path, None, layer.name, options, clips, metrics, messages)


def _shown(path: Path, stage: Usd.Stage, prim: Sequence[str], messages: Messages) -> MetricResult:
    animations = tuple(map(_show, select_animations(path, find_animations(stage), prim)))
    return MetricResult(path.name, None, None, {}, animations, tuple(messages.warnings))


def _show(source: AnimationSource) -> AnimationMetric:
    problems = validate_metric(source.prim)
    try:
        return AnimationMetric(source.path, stored_metric(source), tuple(problems))
    except ToolError as error:
        return AnimationMetric(source.path, None, tuple(dict.fromkeys([*problems, str(error)])))


def _set(
    path: Path, stage: Usd.Stage, options: MetricOptions, messages: Messages
) -> tuple[list[SkelClip], list[LearnedMetric]]:
    """Return the animations that have joints, and what their metrics are to be."""
    sources = select_animations(path, find_animations(stage), options.prim)
    clips = [clip for clip in map(read_clip, sources) if clip.joints]
    if not clips:
        raise ToolError(f"{path} has no animation with joints, so there is nothing that a metric is for.")
    metrics = _metrics(path, clips, options, messages)
    check_styles_count(options, clips, metrics)
    return clips, metrics


def _metrics(path: Path, clips: Sequence[SkelClip], options: MetricOptions, messages: Messages) -> list[LearnedMetric]:
    if options.preset is None:
        return [each.metric for each in choose_metrics(path, clips, options, messages)]
    edits = _edits(options.preset)
    check_styles(options.styles, clips)
    base = StyleOptions(metric=options.metric)
    metrics = [each.metric for each in choose_metrics(path, clips, base, messages)]
    styled = []
    for clip, metric in zip(clips, metrics, strict=True):
        metric = replace(reduce(edited_metric, edits, metric), quality="")
        styled.append(apply_styles(clip, metric, options))
    return styled


def _edits(preset: str | Path) -> Sequence[Edit]:
    if isinstance(preset, Path):
        edits = read_preset(preset)
        if any(isinstance(edit, KeyEdit) for edit in edits):
            raise ToolError(f"--preset {preset} chooses keys, which a metric does not have; use it in usd_tools.live.")
        return edits
    if preset not in PRESETS:
        near = did_you_mean(preset, PRESETS)
        raise UsageError(f"--preset must be {listed([*PRESETS, 'a JSON file'])}, not {preset!r}{near}")
    return PRESETS[preset]


def _write(
    layer: AnimationLayer, clips: Sequence[SkelClip], metrics: Sequence[LearnedMetric], messages: Messages
) -> None:
    for clip, metric in zip(clips, metrics, strict=True):
        layer.store_metric(clip, metric, messages)


def _result(
    source: Path,
    path: Path | None,
    output: str,
    options: MetricOptions,
    clips: Sequence[SkelClip],
    metrics: Sequence[LearnedMetric],
    messages: Messages,
) -> MetricResult:
    animations = tuple(AnimationMetric(clip.path, metric) for clip, metric in zip(clips, metrics, strict=True))
    return MetricResult(source.name, path, output, options.settings(), animations, tuple(messages.warnings))
