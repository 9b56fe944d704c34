"""EditSession: a clip, its keys and its metric under edits that can be undone, replayed and saved."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim import Animation, LearnedMetric, Skeleton, learn_metric
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.shortest import Effort
from geomstats_anim.interpolation.curves import Fallback
from geomstats_anim.markers import joint_matrices
from geomstats_anim.names import DEFAULT_SCHEME, LEARNABLE, LEARNED, OWN_SCHEMES, SCHEME_NAMES
from geomstats_anim.rotations import Array
from usd_tools.console.errors import Messages, ToolError
from usd_tools.console.progress import ProgressCallback, SearchProgress
from usd_tools.editing.edits import Edit, UseMetric
from usd_tools.editing.history import LibraryOrigin, SessionFile, Step
from usd_tools.editing.motion import EditableMotion
from usd_tools.editing.rebuilt import EditErrors, RebuiltMotion
from usd_tools.editing.saving import SaveOptions, SaveResult, save_edited
from usd_tools.editing.state import EditState, edited
from usd_tools.files.openusd_errors import openusd_errors, reading, usd_warnings
from usd_tools.files.stages import stage_sha256
from usd_tools.skel.clip import SkelClip

NAMES = ("ours", "original", "slerp")
"""Motions that a session can show: rebuilt with the metric, as in the file, slerp between the same keys."""


class EditSession:
    """Edit the in-betweens of one animation; there is no user interface in it.

    Open a file with `EditSession.open(path, prim)`. Then

    * `apply(*edits)` makes edits, one step of `undo()` and `redo()`. The edits are in `usd_tools.editing.edits`:
      `Style` (pattern of joints, alpha, beta, invariance, tension, translation_tension, axes), `UseScheme`,
      `UseMetric`, `Reset`, `Mirror`; for keys `EveryNth`, `ChooseKeys`, `KeepOnly`, `PinKey`, `FreeKey`. Presets are
      tuples of edits: `usd_tools.editing.presets.PRESETS`. `usd_tools.editing.edits.exactly(joint)` is the pattern of
      one joint.
    * `drag(*edits)` previews edits, quickly, over what is applied; each call takes the place of the last. `release()`
      applies what was dragged, thoroughly; `cancel()` forgets it. `apply` does all at once.
    * `poses(name, frames=..., times=...)` gives matrices of joints in the world for "ours", "original" and "slerp";
      `motion(name)` the `Animation` at the frames; `errors(name)` what is off, by joint and frame.
    * `learn(progress, ...)` learns a metric for the present keys and applies it as an edit.
    * `save(out, SaveOptions(content=...))` writes; `to_json()` and `replay(text)` store and restore the edits.

    A session is not locked: one thread at a time may change it. `learned` changes nothing, and may run beside.

    Attributes
    ----------
    path : Path
    clip : SkelClip
    skeleton : Skeleton
        Joints in the order of all arrays, shape=[B].
    samples : array-like, shape=[S]
        Time codes of the samples that can be keys.
    codes, times : array-like, shape=[F]
        Time codes and seconds of the frames: the samples, and whole frames between samples that are further apart.
    metric : LearnedMetric
        Present metric with its tensions and scheme, of all joints; while dragged, the one that is previewed.
    keys : array-like, shape=[K]
        Time codes of the present keys.
    edits : tuple of Edit
        All that were applied, in order.
    warnings : tuple of str
        What a user should know of the file.
    """

    def __init__(self, motion: EditableMotion, start: EditState, warnings: tuple[str, ...] = ()) -> None:
        self._motion, self.warnings = motion, warnings
        self._states = [start]
        self._steps: list[Step] = []
        self._undone: list[tuple[Step, EditState]] = []
        self._dragged: tuple[Step, EditState] | None = None
        self._slerp = LearnedMetric.plain(motion.skeleton.joints, "slerp")
        self._rebuilts: dict[str, RebuiltMotion] = {}

    @classmethod
    @openusd_errors()
    def open(
        cls,
        path: str | os.PathLike[str],
        prim: str | None = None,
        library: str | os.PathLike[str] | None = None,
        *,
        warn: Callable[[str], None] | None = None,
    ) -> EditSession:
        """Open the animation of a USD file.

        Parameters
        ----------
        path : path-like
        prim : str
            Path of the SkelAnimation, or of its Skeleton, or of a prim above.
            Optional, default: the only animation of the file, or the only one that drives a skeleton.
        library : path-like
            Library of in-betweens of the rig, with whose scheme "learned" the session begins.
            Optional, default: none, so that there is no such scheme.
        warn : callable
            Called with each warning as it comes.
            Optional, default: nobody is told.

        Returns
        -------
        session : EditSession

        Raises
        ------
        ToolError
            If the file cannot be read, it has several animations, or none that moves, or the library is of another rig.
        """
        path, messages = Path(path), Messages(warn)
        with usd_warnings(messages), reading(path):
            motion = EditableMotion.open(path, prim, None if library is None else Path(library), messages)
            start = EditState.start(motion, messages)
        return cls(motion, start, tuple(messages.warnings))

    @property
    def path(self) -> Path:
        """File that is edited."""
        return self._motion.path

    @property
    def clip(self) -> SkelClip:
        """Its animation, with rotations and translations sampled alike."""
        return self._motion.clip

    @property
    def skeleton(self) -> Skeleton:
        """Skeleton of the clip, metres."""
        return self._motion.skeleton

    @property
    def samples(self) -> np.ndarray:
        """Time codes of the samples that can be keys, shape=[S]."""
        return self._motion.samples

    @property
    def codes(self) -> np.ndarray:
        """Time codes of the frames, shape=[F]."""
        return self._motion.codes

    @property
    def times(self) -> np.ndarray:
        """Seconds of the frames, shape=[F]."""
        return self._motion.times

    @property
    def schemes(self) -> tuple[str, ...]:
        """Schemes that can be used: "learned" with a library only."""
        return OWN_SCHEMES if self._motion.library is None else SCHEME_NAMES

    @property
    def metric(self) -> LearnedMetric:
        """Present metric; its scheme is the one to interpolate with."""
        return self._state.metric

    @property
    def keys(self) -> np.ndarray:
        """Time codes of the present keys, shape=[K]."""
        return self.samples[self._state.is_key]

    @property
    def edits(self) -> tuple[Edit, ...]:
        """All edits that were applied, in order."""
        return tuple(edit for step in self._steps for edit in step)

    @property
    def can_undo(self) -> bool:
        """True if there is a step to undo."""
        return bool(self._steps)

    @property
    def can_redo(self) -> bool:
        """True if there is an undone step."""
        return bool(self._undone)

    @property
    def unconverged(self) -> tuple[Fallback, ...]:
        """Segments of ours that are slerped, since their geodesic was not found."""
        return self._rebuilt("ours").fallbacks

    @property
    def is_thorough(self) -> bool:
        """True if ours is what saving would write; False while a quick preview is shown."""
        return self._rebuilt("ours").effort == "thorough"

    def apply(self, *edits: Edit) -> None:
        """Make edits, all in one step of undo.

        Raises
        ------
        ToolError
            If one does not fit the clip; nothing is changed then.
        """
        state = self._edited(edits)
        self.cancel()
        self._steps.append(tuple(edits))
        self._states.append(state)
        self._undone.clear()

    def drag(self, *edits: Edit) -> None:
        """Preview edits over what is applied, in place of those dragged before.

        Arrays of a preview, such as its poses, are changed by the next edit: copy what is to last.

        Raises
        ------
        ToolError
            If one does not fit the clip.
        """
        self._dragged = (tuple(edits), self._edited(edits))

    def release(self) -> None:
        """Apply what was dragged, if anything was, thoroughly."""
        if self._dragged is not None:
            self.apply(*self._dragged[0])

    def cancel(self) -> None:
        """Forget what was dragged."""
        self._dragged = None

    def undo(self) -> None:
        """Undo the last step, if there is one."""
        self.cancel()
        if self._steps:
            self._undone.append((self._steps.pop(), self._states.pop()))

    def redo(self) -> None:
        """Make the step again that was undone last, if there is one."""
        self.cancel()
        if self._undone:
            step, state = self._undone.pop()
            self._steps.append(step)
            self._states.append(state)

    def motion(self, name: str = "ours") -> Animation:
        """Return a motion at the frames: "ours", "original" or "slerp"."""
        return self._motion.original if name == "original" else self._rebuilt(name).animation

    def poses(self, name: str = "ours", frames: np.ndarray | slice | int | None = None, times: Any = None) -> Array:
        """Place the joints of a motion in the world.

        Parameters
        ----------
        name : str
            "ours", "original" or "slerp".
        frames : array-like of int, slice or int
            Which frames.
            Optional, default: all of them.
        times : array-like, shape=[F]
            Seconds, increasing, instead of frames: exact at any time, held outside the range.

        Returns
        -------
        matrices : array-like, shape=[F, B, 3, 4]; or shape=[B, 3, 4] for one frame
            A point p of a joint's frame is at m[:, :3] p + m[:, 3], metres.
        """
        if times is not None:
            times = np.atleast_1d(np.asarray(times, dtype=np.float64))
            original = name == "original"
            return joint_matrices(self._motion.original_at(times) if original else self._rebuilt(name).at(times))
        matrices = self._motion.matrices if name == "original" else self._rebuilt(name).matrices
        return matrices if frames is None else matrices[frames]

    def errors(self, name: str = "ours") -> EditErrors:
        """Measure how far "ours" or "slerp" is from the original, by frame and joint."""
        return self._rebuilt(name).errors

    def angles(self, name: str, joint: int) -> Array:
        """Measure how far a joint of a motion is turned from its rest pose at the frames, shape=[F], degrees."""
        rotations = self._motion.original.rotations if name == "original" else self._rebuilt(name).rotations
        return np.degrees(quat.distance(rotations[:, joint], self.skeleton.rest_rotations[joint]))

    def learn(self, progress: ProgressCallback | None = None, **settings: Any) -> None:
        """Learn a metric for the present keys, and apply it as an edit; see `learned`."""
        self.apply(self.learned(progress, **settings))

    def learned(
        self,
        progress: ProgressCallback | None = None,
        *,
        purpose: str = "reconstruct",
        family: str = "diagonal",
        scheme: str | None = None,
    ) -> UseMetric:
        """Learn a metric for the present keys by its gradient, and return it as an edit.

        Parameters
        ----------
        progress : callable
            Called with the work done, None, and a text; what it raises cancels the search.
            Optional, default: nobody is told.
        purpose, family : str
            See `learn_metric`.
            Optional, default: "reconstruct", "diagonal".
        scheme : str
            Optional, default: the present one.

        Returns
        -------
        edit : UseMetric

        Raises
        ------
        ToolError
            If nothing can be learned from these keys.
        """
        state, motion = self._state, self._motion
        scheme = scheme or state.metric.scheme
        taught = DEFAULT_SCHEME if scheme == LEARNED else scheme  # a library turns the spline
        if taught not in LEARNABLE:
            raise ToolError(f"Nothing can be learned for {scheme}; choose {' or '.join(LEARNABLE)}.")
        animations = [part.animation for part in motion.parts]
        watch = SearchProgress(progress, None).watch
        keyframes = state.keyframes(motion)
        if state.is_key.all():
            raise ToolError("All samples are keys, so there is nothing to learn from; take fewer keys.")
        try:
            found = learn_metric(animations, keyframes, purpose=purpose, family=family, scheme=taught, progress=watch)
        except ValueError as error:
            raise ToolError(f"{self.clip.path}: {error}") from error
        return UseMetric(found.for_scheme(scheme))

    def save(self, out: str | os.PathLike[str], options: SaveOptions | None = None) -> SaveResult:
        """Write the present state to a USD file.

        Parameters
        ----------
        out : path-like
        options : SaveOptions
            Optional, default: the metric over the source.

        Returns
        -------
        result : SaveResult

        Raises
        ------
        ToolError
            If it cannot be written.
        """
        return save_edited(self._motion, self._states[-1], Path(out), options or SaveOptions())

    def to_json(self) -> str:
        """Return the edits as JSON, with what they were made for."""
        steps = tuple(self._steps)
        return SessionFile(self.path.name, self._sha256, self.clip.path, steps, self._library).to_json()

    def replay(self, text: str) -> None:
        """Go back to the start, and make the edits that `to_json` gave.

        Raises
        ------
        ToolError
            If they cannot be read, are of another clip, or do not fit; the session is as it was then.
        """
        stored = SessionFile.from_json(text)
        if stored.sha256 != self._sha256 or stored.prim != self.clip.path:
            raise ToolError(
                f"The session is of {stored.source}, {stored.prim}, and not of {self.path.name}, {self.clip.path}, as "
                "it is now; open that file."
            )
        if stored.library != self._library:
            wanted = "no library" if stored.library is None else f"the library {stored.library}"
            option = "without --library" if stored.library is None else "with it as --library"
            raise ToolError(f"The session was made with {wanted}; open the clip {option}.")
        states = self._states[:1]
        for step in stored.steps:
            states.append(self._edited(step, states[-1]))
        self._states, self._steps = states, list(stored.steps)
        self._undone = []
        self.cancel()

    @property
    def _state(self) -> EditState:
        return self._states[-1] if self._dragged is None else self._dragged[1]

    @property
    def _library(self) -> LibraryOrigin | None:
        library = self._motion.library
        return None if library is None else LibraryOrigin(library.name, library.sha256)

    @cached_property
    def _sha256(self) -> str:
        return stage_sha256(self.clip.source.stage)

    def _edited(self, edits: Step, state: EditState | None = None) -> EditState:
        state = self._states[-1] if state is None else state
        for edit in edits:
            state = edited(state, edit, self._motion)
        return state

    def _rebuilt(self, name: str) -> RebuiltMotion:
        """Return a motion for the present state, made of the one before where that is quicker."""
        if name not in ("ours", "slerp"):
            raise ValueError(f"There is no motion {name!r}; there are {', '.join(NAMES)}.")
        state = self._state if name == "ours" else replace(self._state, metric=self._slerp)
        before = self._rebuilts.get(name)
        effort: Effort = "thorough" if self._dragged is None else "quick"
        now = RebuiltMotion.of(self._motion, state) if before is None else before.following(state, effort)
        self._rebuilts[name] = now
        return now
