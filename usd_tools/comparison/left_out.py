"""Find the libraries that clips are scored by: never one that has learned from the clip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim import MotionLibrary, learn_library, uniform_keyframes
from geomstats_anim.learning.library.gap_model import nearest_models
from geomstats_anim.learning.library.samples import GAP_RATE
from usd_tools.comparison.results import ComparedClip
from usd_tools.comparison.trials import AS_IT_IS, WITHOUT, ScoringLibrary
from usd_tools.console.errors import Messages, ToolError
from usd_tools.learning.clips import TrainingClip, with_joint_order
from usd_tools.learning.files import read_clips, training_clips
from usd_tools.libraries.files import LibraryFile


def scoring_libraries(
    file: LibraryFile, clips: Sequence[ComparedClip], rates: Sequence[float], messages: Messages
) -> dict[str, ScoringLibrary]:
    """Return the library for each clip, by its name; one that has learned from the clip learns anew without it.

    Its other clips are taken from those that are compared, or from files of their names in the same folders, and known
    by their sha256.

    Parameters
    ----------
    file : LibraryFile
    clips : sequence of ComparedClip
    rates : sequence of float
        Shares of the samples that are kept: only what these need is learned anew.
    messages : Messages
        Told which clips are left out.

    Returns
    -------
    libraries : dict of str to ScoringLibrary
    """
    said = {"file": file.name, "sha256": file.sha256}
    known = _learned_from(file.library.provenance)
    if not known:
        messages.warn(f"{file.name} does not name the clips that it has learned from, so that none can be left out.")
    source = _Source(file, known, clips)
    found = {}
    for each in clips:
        try:
            file.check(each.clip)
            if each.take.sha256 not in {sha256 for _, sha256, _ in known}:
                found[each.name] = ScoringLibrary(file.library, AS_IT_IS, None, said)
                continue
            library = source.without(each, rates)
            messages.warn(f"{each.name} is in {file.name}: it is scored by a library of the other clips alone.")
            found[each.name] = ScoringLibrary(library, WITHOUT, None, said)
        except (ToolError, ValueError, KeyError) as error:
            found[each.name] = ScoringLibrary(None, AS_IT_IS, str(error), said)
    return found


def _learned_from(provenance: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return file, sha256 and prim of the clips of a library; none where a stranger's header holds something else."""
    columns = [provenance.get(name) for name in ("files", "sha256", "prims")]
    lists = [column for column in columns if isinstance(column, list | tuple)]
    if len(lists) < 3 or len(set(map(len, lists))) > 1 or not all(isinstance(x, str) for row in lists for x in row):
        return []
    return list(zip(*lists, strict=True))


class _Source:
    """The clips that a library has learned from, as far as they are found."""

    def __init__(self, file: LibraryFile, known: Sequence[tuple[str, str, str]], clips: Sequence[ComparedClip]) -> None:
        self._file, self._known = file, known
        self._found = {(each.take.sha256, each.take.prim): each.take for each in clips}
        self._folders = list(dict.fromkeys(each.path.parent for each in clips))

    def without(self, clip: ComparedClip, rates: Sequence[float]) -> MotionLibrary:
        """Learn from all clips but one.

        Raises
        ------
        ToolError
            If another cannot be found, or there is none.
        """
        rest = [each for each in self._known if each[1] != clip.take.sha256]
        takes = [self._take(*each) for each in rest]
        missing = [name for (name, _, _), take in zip(rest, takes, strict=True) if take is None]
        if missing or not rest:
            lack = f"{missing[0]} cannot be found; compare them together" if rest else "it has no other"
            raise ToolError(
                f"{clip.name} is in {self._file.name}, and is scored by a library of its other clips, but {lack}."
            )
        library = self._file.library
        joints = library.skeleton.joints
        stretches = [part for take in takes if take is not None for part in with_joint_order(take, joints).stretches]
        seed = library.provenance.get("seed")
        return learn_library(
            stretches, library.vertical, _gaps(library, clip.take, rates), seed if isinstance(seed, int) else 0
        )

    def _take(self, name: str, sha256: str, prim: str) -> TrainingClip | None:
        """Find a clip among those that are compared, or in the folders that they are in."""
        for folder in self._folders:
            path = folder / Path(name).name
            if (sha256, prim) in self._found or not path.is_file():
                continue
            quiet = Messages(None)
            for _, take in training_clips(path, read_clips(path, (), quiet), quiet)[0]:
                self._found.setdefault((take.sha256, take.prim), take)
        return self._found.get((sha256, prim))


def _gaps(library: MotionLibrary, take: TrainingClip, rates: Sequence[float]) -> list[int]:
    """Return the lengths of segments that a clip needs: those between its keys, and twice them."""
    needed: set[int] = set()
    for stretch in take.stretches:
        for rate in rates:
            for part in (stretch, stretch.at_frames(slice(stretch.n_frames // 2, None))):
                gaps = GAP_RATE * np.diff(part.times[uniform_keyframes(part.n_frames, rate)])
                needed.update(nearest_models(library.models, np.concatenate([gaps, 2.0 * gaps])).tolist())
    return [model.gap for i, model in enumerate(library.models) if i in needed] or [library.models[0].gap]
