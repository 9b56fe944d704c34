"""The clip of a session: samples that can be keys, frames that are shown, and the original at any time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geomstats_anim import Animation, Skeleton, interpolate
from geomstats_anim.markers import Markers, joint_matrices
from usd_tools.console.errors import Messages, ToolError
from usd_tools.downsampling.thinning import SampleSelection, sampled_alike
from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import AnimationSource, find_animations, select_animations
from usd_tools.skel.resampling import animation_of, at_rate, resample, without_cuts
from usd_tools.skel.source_codes import stored_source_codes

if TYPE_CHECKING:
    from usd_tools.libraries.files import LibraryFile

MAX_VALUES = 1 << 25
"""Rotations of a clip that can be edited; more would need gigabytes."""

_DENSE_ENOUGH = 0.75
"""Share of the stage's frames with samples from which on the samples themselves are shown."""


@dataclass(frozen=True, eq=False)
class Part:
    """One stretch of motion between value blocks, steps and cuts.

    Parameters
    ----------
    samples : slice
        Its samples among those of the clip.
    animation : Animation
        The same.
    frames : slice
        Its frames among those that are shown.
    """

    samples: slice
    animation: Animation
    frames: slice


@dataclass(frozen=True, eq=False)
class EditableMotion:
    """A clip opened for editing.

    Parameters
    ----------
    path : Path
        Its file.
    clip : SkelClip
        With rotations and translations sampled alike.
    selection : SampleSelection
        Samples that can be keys.
    codes : array-like, shape=[F]
        Time codes of the frames that are shown: the samples, and whole frames between samples that are further apart.
    original : Animation
        The clip as viewers show it, at the frames, in the world.
    library : LibraryFile or None
        Library of in-betweens for the clip's rig.
    library_path : Path or None
        Where it is.
    """

    path: Path
    clip: SkelClip
    selection: SampleSelection
    codes: np.ndarray
    original: Animation
    library: LibraryFile | None = None
    library_path: Path | None = None

    @classmethod
    def open(cls, path: Path, prim: str | None, library: Path | None, messages: Messages) -> EditableMotion:
        """Open the animation of a file; see `EditSession.open`."""
        source = _only(
            path, select_animations(path, find_animations(open_stage(path)), () if prim is None else (prim,))
        )
        clip = sampled_alike(read_clip(source))
        for note in clip.notes:
            messages.warn(note)
        selection = SampleSelection.of(clip, None)
        if not selection.names or not selection.spans:
            raise ToolError(f"{path}: {clip.path} has no joint that moves between samples, so nothing can be edited.")
        size = len(clip.codes) * clip.skeleton.n_joints
        if size > MAX_VALUES:
            raise ToolError(
                f"{path}: {clip.path} has {size} rotations, but at most {MAX_VALUES} can be edited; cut the clip."
            )
        codes, original = _original(clip, _shown_codes(clip))
        return cls(path, clip, selection, codes, original, _library(library, clip), library)

    @property
    def skeleton(self) -> Skeleton:
        """Skeleton of the clip, metres."""
        return self.clip.skeleton

    @cached_property
    def samples(self) -> np.ndarray:
        """Time codes of the samples that can be keys, shape=[S]."""
        return self.clip.channels[self.selection.names[0]].codes

    @property
    def times(self) -> np.ndarray:
        """Seconds of the frames, shape=[F]."""
        return self.original.times

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Return the stretches that curves lead through."""
        parts = []
        for span, animation in self.clip.stretches(self.selection.names):
            first, last = self.samples[span][[0, -1]]
            frames = slice(int(np.searchsorted(self.codes, first)), int(np.searchsorted(self.codes, last, "right")))
            parts.append(Part(span, animation, frames))
        return tuple(parts)

    @cached_property
    def matrices(self) -> np.ndarray:
        """Return where the original's joints are in the world, shape=[F, B, 3, 4]; see `joint_matrices`."""
        return joint_matrices(self.original)

    @cached_property
    def ends(self) -> Markers:
        """Return the ends of bones, whose distances are errors."""
        return Markers.of_ends(self.skeleton)

    @cached_property
    def held(self) -> Animation:
        """Return the original with every sample held until the next: what is shown where no curve leads."""
        shown = self.original
        last = np.maximum(np.searchsorted(self.samples, self.codes, side="right") - 1, 0)
        frame = np.minimum(np.searchsorted(self.codes, self.samples), len(self.codes) - 1)[last]
        return replace(shown, rotations=shown.rotations[frame], translations=shown.translations[frame])

    @cached_property
    def sampled(self) -> np.ndarray:
        """Return the frames at which the clip has a sample, so that an error is one, shape=[N]."""
        return np.flatnonzero(np.isin(self.codes, self.samples))

    def original_at(self, times: np.ndarray) -> Animation:
        """Return the clip as viewers show it, at any times in seconds, shape=[F]; held outside its range."""
        shown = interpolate(self.original, times, "slerp")
        return replace(shown, world=self.clip.placements(times * self.clip.codes_per_second))


def _original(clip: SkelClip, codes: np.ndarray) -> tuple[np.ndarray, Animation]:
    """Return a clip as viewers show it, in the world, and at which of some time codes: those that are not blocked."""
    dense = resample(without_cuts(clip), codes, "slerp").channels
    shown = animation_of(replace(clip, channels={**clip.channels, **dense}, given_cuts=clip.cuts))
    codes = codes[np.isin(codes / clip.codes_per_second, shown.times)]
    return codes, replace(shown, world=clip.placements(codes))


def _library(path: Path | None, clip: SkelClip) -> LibraryFile | None:
    """Read a library, and refuse one of another rig."""
    if path is None:
        return None
    from usd_tools.libraries.files import LibraryFile

    library = LibraryFile.read(path)
    library.check(clip)
    return library


def _only(path: Path, sources: list[AnimationSource]) -> AnimationSource:
    """Return the animation, of several the only one that drives a skeleton."""
    if len(sources) > 1:
        sources = [source for source in sources if source.skeletons] or sources
    if len(sources) > 1:
        names = ", ".join(source.path for source in sources[:5])
        raise ToolError(f"{path} has {len(sources)} animations; choose one with --prim: {names}.")
    return sources[0]


def _shown_codes(clip: SkelClip) -> np.ndarray:
    """Return the time codes of the frames that are shown."""
    stored = stored_source_codes(clip.source.prim, clip.codes)
    if stored is not None:
        return np.union1d(clip.codes, stored.codes)
    rate = clip.source.stage.GetFramesPerSecond()
    if not (np.isfinite(rate) and rate > 0.0) or clip.samples_per_second() >= _DENSE_ENOUGH * rate:
        return clip.codes
    return at_rate(clip, min(rate, clip.codes_per_second))
