"""The work of `learn`, on files or on an open stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pxr import Usd

from geomstats_anim.names import TRIALS
from usd_tools.console.errors import Messages, ToolError, UsageError
from usd_tools.console.progress import Progress, ProgressCallback, SearchProgress
from usd_tools.files.atomic import write_json, written_beside
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.paths import EXTENSIONS, check_output, extension, same_file
from usd_tools.files.stages import open_stage, stage_path
from usd_tools.learning.clips import TrainingClip
from usd_tools.learning.files import collect_training_clips, find_files, read_clips, training_clips
from usd_tools.learning.library import learn_library_file
from usd_tools.learning.options import LIBRARY_SUFFIX, LearnOptions
from usd_tools.learning.result import TOOL, LearnResult, MetricReport, Skipped
from usd_tools.learning.summary import describe, slerped_sentence
from usd_tools.learning.train import AssessedMetric, learn_and_assess
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.output import Output, check_report
from usd_tools.skel.writer import AnimationLayer


@openusd_errors()
def learn_files(
    sources: Sequence[Path],
    out: Path | None,
    options: LearnOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> LearnResult:
    """Learn from files; see `usd_tools.learn.learn`."""
    if out is None and not options.in_place:
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    if options.library:
        result = _learn_library(sources, out, options, messages, progress)
    elif out is not None and out.suffix == ".json":
        result = _learn_json(sources, out, options, messages, progress)
    else:
        result = _learn_usd(sources, out, options, messages, progress)
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def learn_open_stage(
    stage: Usd.Stage, options: LearnOptions, progress: ProgressCallback | None, warn: Callable[[str], None] | None
) -> LearnResult:
    """Learn from the animations of an open stage; see `usd_tools.learn.learn_stage`."""
    messages, path, layer = Messages(warn), stage_path(stage), EditTargetLayer(stage)
    with usd_warnings(messages), reading(path):
        clips, assessed, skipped = _learn_each(path, stage, options, messages, progress)
        with layer.editing():
            _write(layer, clips, assessed, messages)
    return _result(None, layer.name, options, assessed, skipped, messages)


def _learn_json(
    sources: Sequence[Path], out: Path, options: LearnOptions, messages: Messages, progress: ProgressCallback | None
) -> LearnResult:
    """Learn one metric for one rig, and write it to a file of its own."""
    with usd_warnings(messages):
        takes, skipped = _clips_of_one_rig(sources, out, options, messages, progress)
        assessed = [_learn(takes, options, messages, progress)]
    with written_beside(out) as beside:
        beside.write_text(assessed[0].metric.to_json(), encoding="utf-8")
    return _result(out, out.name, options, assessed, skipped, messages)


def _learn_library(
    sources: Sequence[Path],
    out: Path | None,
    options: LearnOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> LearnResult:
    """Learn a library of one rig, and write it to a file of its own."""
    if out is None or out.suffix != LIBRARY_SUFFIX:
        raise UsageError(f"--library needs an --out that ends in {LIBRARY_SUFFIX}")
    with usd_warnings(messages):
        clips, skipped = _clips_of_one_rig(sources, out, options, messages, progress)
        library = learn_library_file(clips, out, options, progress)
    return LearnResult(out, out.name, options.settings(), (), tuple(skipped), tuple(messages.warnings), library)


def _clips_of_one_rig(
    sources: Sequence[Path], out: Path, options: LearnOptions, messages: Messages, progress: ProgressCallback | None
) -> tuple[list[TrainingClip], list[Skipped]]:
    """Read the clips that one file of its own is learned from."""
    check_output(out, "--out")
    for_usd = {"--in-place": options.in_place, "--flatten": options.flatten, "--usdFormat": options.usd_format}
    for option, value in for_usd.items():
        if value:
            raise ToolError(f"{option} needs a USD file, but --out is {out}; leave one of them out.")
    check_report(options.report, out)
    files = find_files(sources, messages)
    for argument, path in (("--out", out), ("--report", options.report)):
        if path is not None and same_file(path, files):
            raise ToolError(f"{argument} {path} is an input; choose another name.")
    read = Progress(progress, len(files), "Reading")
    return collect_training_clips(files, options.prim, options.skip_mismatched, messages, read.advance)


def _learn_usd(
    sources: Sequence[Path],
    out: Path | None,
    options: LearnOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> LearnResult:
    """Learn a metric for each animation of one file."""
    if len(sources) > 1 or sources[0].is_dir():
        what = "--in-place changes" if out is None else f"--out {out} extends"
        raise ToolError(f"{what} one file; to learn one metric from several files, use an --out that ends in .json.")
    path = sources[0]
    if out is not None and extension(out) not in EXTENSIONS:
        raise ToolError(f"--out {out}: the name must end in {', '.join(EXTENSIONS)}, .json.")
    target = Output(path, out, options)
    target.check()
    with usd_warnings(messages), reading(path):
        stage = open_stage(path)
        target.check_layers(stage)
        clips, assessed, skipped = _learn_each(path, stage, options, messages, progress)
        layer = target.layer(stage, TOOL, options.settings(), messages)
        _write(layer, clips, assessed, messages)
        target.save(layer)
    return _result(target.path, target.path.name, options, assessed, skipped, messages)


def _learn_each(
    path: Path, stage: Usd.Stage, options: LearnOptions, messages: Messages, progress: ProgressCallback | None
) -> tuple[list[SkelClip], list[AssessedMetric], list[Skipped]]:
    """Learn a metric for each animation of a stage that has something to learn from."""
    taken, skipped = training_clips(path, read_clips(path, options.prim, messages, stage), messages)
    if len(taken) > 1 and (options.folder or options.resume):
        raise ToolError(f"A folder holds one search, but {path} has {len(taken)} animations; choose one with --prim.")
    assessed = [_learn([take], options, messages, progress) for _, take in taken]
    return [clip for clip, _ in taken], assessed, skipped


def _learn(
    takes: Sequence[TrainingClip], options: LearnOptions, messages: Messages, progress: ProgressCallback | None
) -> AssessedMetric:
    alone = sum(len(take.stretches) for take in takes) == 1
    if alone and options.search == "gradient" and (options.address or (options.cpus or 1) > 1):
        option = "--address" if options.address else "--cpus"
        messages.warn(f"{option} is for several clips; {takes[0]} is learned in this process.")
    trials = options.trials or TRIALS if options.search == "tpe-joint" else None
    assessed = learn_and_assess(takes, options, SearchProgress(progress, trials).watch)
    sentence = slerped_sentence(assessed)
    if sentence is not None:
        messages.warn(sentence)
    return assessed


def _write(
    layer: AnimationLayer, clips: Sequence[SkelClip], assessed: Sequence[AssessedMetric], messages: Messages
) -> None:
    for clip, each in zip(clips, assessed, strict=True):
        metric, _ = each.metric.for_joints(clip.joints)
        layer.store_metric(clip, metric, messages)


def _result(
    path: Path | None,
    output: str,
    options: LearnOptions,
    assessed: Sequence[AssessedMetric],
    skipped: Sequence[Skipped],
    messages: Messages,
) -> LearnResult:
    reports: tuple[MetricReport, ...] = tuple(map(describe, assessed))
    return LearnResult(path, output, options.settings(), reports, tuple(skipped), tuple(messages.warnings))
