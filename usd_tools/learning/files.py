"""Collect what can be learned from of many files: search folders, name what cannot be read, refuse another rig."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pxr import Sdf, Usd

from usd_tools.console.errors import Messages, ToolError
from usd_tools.files.openusd_errors import reading
from usd_tools.files.paths import EXTENSIONS, files_below, same_file
from usd_tools.files.stages import open_stage
from usd_tools.learning.clips import TrainingClip, rig_difference, training_clip, with_joint_order
from usd_tools.learning.result import Skipped
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.clip import read_clips as read_skel_clips
from usd_tools.skel.find import find_animations, select_animations
from usd_tools.skel.time_codes import left_sparse
from usd_tools.skel.writer import MADE_BY


def find_files(inputs: Sequence[Path], messages: Messages) -> list[Path]:
    """Find the USD files that are named, and those in folders and in folders within them.

    Of a folder, hidden files are left out, and those that a tool of this package made: their motion is that of the
    files that they were made from.

    Parameters
    ----------
    inputs : sequence of Path
    messages : Messages
        Told of files that are left out.

    Returns
    -------
    files : list of Path
        Each once, in the order named; those of a folder in the order of their names.

    Raises
    ------
    ToolError
        If a folder has none.
    """
    files: list[Path] = []
    for path in inputs:
        found = _files_below(path, messages) if path.is_dir() else [path]
        if not found:
            raise ToolError(f"{path} contains no USD file, nor do its subfolders.")
        for file in found:
            if file in files or same_file(file, files):
                messages.warn(f"{file} is named twice; it is used once.")
            else:
                files.append(file)
    return files


def _files_below(folder: Path, messages: Messages) -> list[Path]:
    files = []
    for path in files_below(folder, EXTENSIONS):
        if _is_made_by_us(path):
            messages.warn(
                f"{path} was written by this package from another file, so it is skipped; name it to include it."
            )
        else:
            files.append(path)
    return files


def _is_made_by_us(path: Path) -> bool:
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path), metadataOnly=True)
    except Exception:  # reading it will say what is wrong with it
        return False
    return layer is not None and MADE_BY in layer.customLayerData


def read_clips(path: Path, prims: Sequence[str], messages: Messages, stage: Usd.Stage | None = None) -> list[SkelClip]:
    """Read the animations of a file, or of a stage that is open already.

    Raises
    ------
    ToolError
        If it cannot be read, has none, or `prims` chooses none.
    """
    try:
        with reading(path):
            sources = select_animations(path, find_animations(stage or open_stage(path)), prims)
            clips = read_skel_clips(sources, messages)
    except ToolError as error:
        raise ToolError(str(error) if str(path) in str(error) else f"{path}: {error}") from error
    for clip in clips:
        for note in (*clip.notes, *left_sparse(clip)):
            messages.warn(note)
    return clips


def training_clips(
    path: Path, clips: Sequence[SkelClip], messages: Messages
) -> tuple[list[tuple[SkelClip, TrainingClip]], list[Skipped]]:
    """Take from the animations of a file what can be learned from; warn of those that have nothing.

    Raises
    ------
    ToolError
        If none of them has anything.
    """
    found, skipped = [], []
    for clip in clips:
        try:
            found.append((clip, training_clip(path, clip, alone=len(clips) == 1)))
        except ToolError as error:
            if len(clips) == 1:
                raise
            skipped.append(Skipped(path.name, str(error)))
            messages.warn(f"skipped: {error}")
    if not found:
        raise ToolError(f"{path} has no animation to learn from.")
    return found, skipped


def collect_training_clips(
    files: Sequence[Path],
    prims: Sequence[str],
    skip_mismatched: bool,
    messages: Messages,
    advance: Callable[[float], None] = lambda amount: None,
) -> tuple[list[TrainingClip], list[Skipped]]:
    """Collect training clips of one rig from files; stages are released, so that memory holds only the motion.

    Parameters
    ----------
    files : sequence of Path
    prims : sequence of str
        Chooses animations in every file.
    skip_mismatched : bool
        Whether to skip animations whose rig differs from the first's.
    messages : Messages
        Told of what is skipped.
    advance : callable
        Told when another file is done.

    Returns
    -------
    clips : list of TrainingClip
        Joints in the order of the first.
    skipped : list of Skipped

    Raises
    ------
    ToolError
        If there is nothing to learn from, or an animation is of another rig and not to be skipped. If there is only
        one file, whatever is wrong with it.
    """
    collected: list[TrainingClip] = []
    skipped: list[Skipped] = []
    for path in files:
        try:
            found, lost = training_clips(path, read_clips(path, prims, messages), messages)
        except ToolError as error:
            if len(files) == 1:
                raise
            found, lost = [], [Skipped(path.name, str(error))]
            messages.warn(f"skipped: {error}")
        skipped += lost
        for _, clip in found:
            reason = rig_difference(clip, collected[0]) if collected else None
            if reason is None:
                collected.append(with_joint_order(clip, collected[0].skeleton.joints) if collected else clip)
            elif skip_mismatched:
                skipped.append(Skipped(path.name, f"{reason}."))
                messages.warn(f"skipped: {reason}.")
            else:
                raise ToolError(f"{reason}; leave it out, or add --skip-mismatched.")
        advance(1.0)
    if not collected:
        raise ToolError(f"None of the {len(files)} files has an animation to learn from; see the warnings.")
    return collected, skipped
