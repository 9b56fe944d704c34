"""The work of `compare`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from usd_tools.comparison.distortion import METHODS, RateDistortion, acl_reference, rate_distortion
from usd_tools.comparison.options import CompareOptions
from usd_tools.comparison.report.report import write_report
from usd_tools.comparison.result import TOOL, CompareResult
from usd_tools.comparison.results import ComparedClip, named, write_rebuilt, write_results
from usd_tools.comparison.trials import ScoringLibrary, TrialResult, all_trials
from usd_tools.comparison.workers import measure_all
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.options import PrimOptions
from usd_tools.console.progress import Progress, ProgressCallback
from usd_tools.files.folders import check_folder, made_beside
from usd_tools.files.openusd_errors import openusd_errors, usd_warnings
from usd_tools.learning.files import find_files, read_clips, training_clips
from usd_tools.learning.result import Skipped


@openusd_errors()
def compare_files(
    sources: Sequence[Path],
    out: Path,
    options: CompareOptions,
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> CompareResult:
    """Compare schemes on files; see `usd_tools.compare.compare`."""
    messages = Messages(warn)
    check_folder(out, TOOL, ())
    with usd_warnings(messages):
        clips, skipped = read_compared(sources, options, messages)
        layers = [layer.realPath for each in clips for layer in each.clip.source.stage.GetUsedLayers()]
        check_folder(out, TOOL, [each.path for each in clips] + [path for path in layers if path])
        libraries = {} if options.library is None else _libraries(options.library, clips, options, messages)
        results = _measure(clips, libraries, options, messages, progress)
        points = _rate_distortion(clips, options, progress)
        with made_beside(out, TOOL) as folder:
            return _write(out, folder, clips, results, points, skipped, options, messages, progress)


def read_compared(
    sources: Sequence[Path], options: PrimOptions, messages: Messages
) -> tuple[list[ComparedClip], list[Skipped]]:
    """Read the clips of files and folders, each under a name of its own; what cannot be compared is named.

    Raises
    ------
    ToolError
        If nothing can be compared.
    """
    files = find_files(sources, messages)
    found, skipped = [], []
    for path in files:
        try:
            taken, lost = training_clips(path, read_clips(path, options.prim, messages), messages)
        except ToolError as error:
            if len(files) == 1:
                raise
            messages.warn(f"skipped: {error}")
            taken, lost = [], [Skipped(path.name, str(error))]
        found += [(path, clip, take) for clip, take in taken]
        skipped += lost
    if not found:
        raise ToolError(f"None of the {len(files)} files can be compared; see the warnings.")
    return named(found), skipped


def _libraries(
    path: Path, clips: Sequence[ComparedClip], options: CompareOptions, messages: Messages
) -> dict[str, ScoringLibrary]:
    """Read the library, and learn anew for the clips that are in it."""
    from usd_tools.comparison.left_out import scoring_libraries
    from usd_tools.libraries.files import LibraryFile

    return scoring_libraries(LibraryFile.read(path), clips, options.rates, messages)


def _measure(
    clips: Sequence[ComparedClip],
    libraries: Mapping[str, ScoringLibrary],
    options: CompareOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> list[TrialResult]:
    wanted = all_trials([each.name for each in clips], options.rates, options.choices)
    bar = Progress(progress, len(wanted), "Comparing")

    def done(result: TrialResult) -> None:
        if result.row.error is not None:
            messages.warn(f"{result.trial} failed: {result.row.error}")
        bar.advance(1.0, f"Comparing: {result.trial}")

    takes = {each.name: each.take for each in clips}
    return measure_all(wanted, takes, options.kind, libraries, options.address, options.cpus, done)


def _rate_distortion(
    clips: Sequence[ComparedClip], options: CompareOptions, progress: ProgressCallback | None
) -> list[RateDistortion]:
    """Count the bytes that each method needs for each clip within each tolerance."""
    bar = Progress(progress, len(clips) * len(METHODS) * len(options.tolerances), "Packing")
    points = []
    for each in clips:
        for method in METHODS:
            for tolerance in options.tolerances:
                points.append(rate_distortion(each.name, method, each.take.stretches, tolerance))
                bar.advance(1.0, f"Packing: {each.name}, {method}")
        known = (acl_reference(each.name, each.take.stretches, tolerance) for tolerance in options.tolerances)
        points += [point for point in known if point is not None]
    return points


def _write(
    out: Path,
    folder: Path,
    clips: Sequence[ComparedClip],
    results: Sequence[TrialResult],
    points: Sequence[RateDistortion],
    skipped: Sequence[Skipped],
    options: CompareOptions,
    messages: Messages,
    progress: ProgressCallback | None,
) -> CompareResult:
    """Fill the folder, which becomes `out`."""
    by_name = {each.name: each for each in clips}
    rows = []
    for result in results:
        row = result.row
        if not result.trial.unseen and row.error is None:
            row = replace(row, usd=write_rebuilt(folder, by_name[row.clip], result, TOOL, options.kind, messages))
        rows.append(row)
    described = tuple(
        {
            "clip": each.name,
            "file": each.take.file,
            "sha256": each.take.sha256,
            "prim": each.take.prim,
            "frames": each.take.n_frames,
            "joints": each.take.skeleton.n_joints,
            "stretches": len(each.take.stretches),
        }
        for each in clips
    )
    compared = CompareResult(
        out,
        options.settings(),
        described,
        tuple(asdict(each) for each in skipped),
        tuple(messages.warnings),
        tuple(rows),
        tuple(points),
    )
    write_results(folder, compared)
    write_report(folder, compared.head, clips, results, rows, points, Progress(progress, None, "Drawing").advance)
    return compared
