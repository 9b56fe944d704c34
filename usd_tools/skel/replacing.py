"""Replace the samples of animations, in a file or on an open stage: what the verbs that do so have in common."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from pxr import Usd

from usd_tools.console.errors import Messages, UsageError
from usd_tools.console.options import OutputOptions
from usd_tools.console.progress import ProgressCallback
from usd_tools.files.atomic import write_json
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_unheard, usd_warnings
from usd_tools.files.paths import extension
from usd_tools.files.stages import describe_dependencies, is_binary, open_stage, stage_path
from usd_tools.skel.edit_target import EditTargetLayer
from usd_tools.skel.find import AnimationSource, find_animations
from usd_tools.skel.output import Output
from usd_tools.skel.writer import AnimationLayer

Clip = TypeVar("Clip")


def nothing(_: Any) -> None:
    """Do nothing, as most verbs do before and after the work."""


class Work(NamedTuple, Generic[Clip]):
    """Hold what a verb does of its own; the rest is done here.

    Attributes
    ----------
    tool : str
        Such as "usd_tools.pack".
    result : type
        Its result: source, path, output, settings, file_bytes_before, file_bytes_after, animations, warnings and
        dependencies.
    select : callable
        From the path and all animations to those that are worked on.
    clips : callable
        From the path, animations, messages, progress and whether other variants are hidden to clips, at least one.
    source : callable
        From a clip to its animation.
    write : callable
        Called with a layer, clips, whether the file will be text, and messages.
    describe : callable
        From the clips that were written, and messages, to what the result holds of each.
    verify : callable
        From the stage that shows what was written, its path and the clips to clips as they are read from it.
        Optional, default: None, nothing is read again.
    check : callable
        Called with the output before any work is done, to refuse options.
        Optional, default: nothing more is refused.
    finish : callable
        Called with the clips when the output is there.
        Optional, default: that is all.
    """

    tool: str
    result: Callable[..., Any]
    select: Callable[[Path, list[AnimationSource]], list[AnimationSource]]
    clips: Callable[[Path, Sequence[AnimationSource], Messages, ProgressCallback | None, bool], list[Clip]]
    source: Callable[[Clip], AnimationSource]
    write: Callable[[AnimationLayer, Sequence[Clip], bool, Messages], None]
    describe: Callable[[Sequence[Clip], Messages], tuple[Any, ...]]
    verify: Callable[[Usd.Stage, Path, Sequence[Clip]], list[Clip]] | None = None
    check: Callable[[Output], None] = nothing
    finish: Callable[[Sequence[Clip]], None] = nothing

    def verified(self, stage: Usd.Stage, path: Path, clips: list[Clip]) -> list[Clip]:
        """Return clips as they are read from the stage that shows what was written, as far as that matters."""
        return clips if self.verify is None else self.verify(stage, path, clips)


@openusd_errors()
def replace_in_file(
    source: Path,
    out: Path | None,
    options: OutputOptions,
    work: Work[Clip],
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> Any:
    """Replace the samples of a file's animations in another file, or in the file itself.

    Raises
    ------
    UsageError
        If the output is not named.
    ToolError
        If something is wrong with the file, the options or the output; nothing is left behind then.
    """
    if out is None and not options.in_place:
        raise UsageError("name the output with -o/--out")
    messages = Messages(warn)
    target = Output(source, out, options)
    target.check()
    work.check(target)
    with usd_warnings(messages):
        stage = open_stage(source)
    target.check_layers(stage)
    size_before = source.stat().st_size
    with usd_warnings(messages), reading(source):
        everyone = find_animations(stage)
        sources = work.select(source, everyone)
        target = target.without_source(sources)
        clips = work.clips(source, sources, messages, progress, not target.copy)
        layer = target.layer(stage, work.tool, options.settings(), messages)
        layer.replace_samples([work.source(clip) for clip in clips], everyone)
        work.write(layer, clips, _is_text(target.path, options), messages)
        checked: list[Clip] = []

        def verify(beside: Path) -> None:
            with usd_unheard():  # the source has told what is wrong
                checked.extend(work.verified(open_stage(beside), target.path, clips))

        target.save(layer, verify)
    animations = work.describe(checked, messages)
    result = work.result(
        source=source.name,
        path=target.path,
        output=target.path.name,
        settings=options.settings(),
        file_bytes_before=size_before,
        file_bytes_after=target.path.stat().st_size,
        animations=animations,
        dependencies=describe_dependencies(target.path, messages),
        warnings=tuple(messages.warnings),
    )
    work.finish(checked)
    if options.report is not None:
        write_json(options.report, result.as_dict())
    return result


@openusd_errors()
def replace_on_stage(
    stage: Usd.Stage,
    options: OutputOptions,
    work: Work[Clip],
    progress: ProgressCallback | None,
    warn: Callable[[str], None] | None,
) -> Any:
    """Replace the samples of an open stage's animations, in the layer of its edit target.

    Raises
    ------
    ToolError
        If something is wrong with the stage or the options; the layer is as it was then.
    """
    messages, path, layer = Messages(warn), stage_path(stage), EditTargetLayer(stage)
    with usd_warnings(messages), reading(path):
        clips = work.clips(path, work.select(path, find_animations(stage)), messages, progress, True)
        with layer.editing():
            work.write(layer, clips, layer.layer.GetFileFormat().formatId == "usda", messages)
            checked = work.verified(stage, path, clips)
    animations = work.describe(checked, messages)
    return work.result(
        source=path.name,
        path=None,
        output=layer.name,
        settings=options.settings(),
        file_bytes_before=None,
        file_bytes_after=None,
        animations=animations,
        warnings=tuple(messages.warnings),
    )


def _is_text(path: Path, options: OutputOptions) -> bool:
    """Return whether a file that is written is text."""
    if extension(path) == ".usd":
        if options.in_place and not options.flatten:
            return not is_binary(path)
        return options.usd_format == "usda"
    return extension(path) == ".usda"
