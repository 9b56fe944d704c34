"""View of a session on the page: characters, marks, errors, charts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geomstats_anim import Animation
from usd_tools.characters.body import Body, body_of, bounds
from usd_tools.console.text import counted
from usd_tools.editing.session import EditSession
from usd_tools.viewer.controls import SIDE_BY_SIDE, Controls
from usd_tools.viewer.scene import COLORS, ORIGINAL, OURS, SLERP, SceneView
from usd_tools.viewer.timeline import Timeline

if TYPE_CHECKING:
    from collections.abc import Callable

_BOUNDED, _ONIONS, _PATH = 200, 12, 2000
"""Frames that the box of a clip is measured on, onion skins and points of a path, at most."""


class View:
    """Session as the page shows it.

    Parameters
    ----------
    session : EditSession
    controls : Controls
        Say what is shown, and show errors.
    timeline : Timeline
    make_scene : callable
        Makes a `SceneView` for the box of the original, and that of its first frame, shape=[2, 3], metres.
    """

    def __init__(
        self,
        session: EditSession,
        controls: Controls,
        timeline: Timeline,
        make_scene: Callable[[np.ndarray, np.ndarray], SceneView],
    ) -> None:
        self._session, self._controls, self._timeline = session, controls, timeline
        original = session.motion(ORIGINAL)
        self._bodies = {as_bones: body_of(session.clip, original, as_bones) for as_bones in (False, True)}
        some = np.unique(np.linspace(0, original.n_frames - 1, _BOUNDED).astype(int))
        box, standing = (_box(self._bodies[False], original.at_frames(at)) for at in (some, slice(0, 1)))
        extent = standing[1] - standing[0]
        self._width = max(0.6 * float(extent.max()), 1.1 * float(extent[0]))
        self._start = self._middle(0)
        self.scene = make_scene(box, standing)

    def _middle(self, frame: int) -> np.ndarray:
        """Return the middle of the original's joints, shape=[3]."""
        return self._session.poses(ORIGINAL, frame)[:, :, 3].mean(axis=0)

    @property
    def visible(self) -> list[str]:
        """Characters that are shown."""
        return [name for name, box in self._controls.shown.items() if box.value]

    @property
    def key_frames(self) -> np.ndarray:
        """Frames that are keys, shape=[K]."""
        return np.flatnonzero(np.isin(self._session.codes, self._session.keys))

    def show(self, frame: int, joint: int | None) -> None:
        """Show a frame, and the chosen joint's place in it."""
        session, controls = self._session, self._controls
        poses = {name: session.poses(name, frame) for name in self.visible}
        follow = self._middle(frame) - self._start if controls.follow.value else None
        self.scene.show(poses, follow, None if joint is None else session.poses(OURS, frame)[joint, :, 3])
        is_key = ", key" if session.codes[frame] in session.keys else ""
        self._timeline.show(frame, f"{session.times[frame]:.2f} s, time code {session.codes[frame]:g}{is_key}")

    def draw_bodies(self, frame: int) -> None:
        """Draw the characters as the controls say."""
        controls, visible = self._controls, self.visible
        side_by_side = controls.layout.value == SIDE_BY_SIDE
        for name in COLORS:
            opacity = 0.55 if not side_by_side and name != OURS else None
            body = self._bodies[controls.bones.value]
            self.scene.set_body(name, body, self._session.poses(name, frame), opacity, controls.colors.value)
        self.scene.set_visible(visible)
        self.scene.set_side_by_side(visible if side_by_side else None, self._width)

    def draw_extras(self, frame: int, joint: int | None) -> None:
        """Draw the mark of the joint, its path, and onion skins."""
        session, controls, paths = self._session, self._controls, {}
        self.scene.set_mark(None if joint is None else session.poses(OURS, frame)[joint, :, 3])
        if joint is not None and controls.path.value:
            step = -(-len(session.times) // _PATH)
            paths = {name: session.poses(name)[::step, joint, :, 3] for name in self.visible}
        self.scene.set_paths(paths)
        keys = self.key_frames if controls.onion.value and OURS in self.visible else np.zeros(0, dtype=int)
        some = keys[np.unique(np.linspace(0, len(keys) - 1, _ONIONS).astype(int))] if len(keys) else keys
        self.scene.set_onion(session.poses(OURS, some))

    def show_errors(self, chosen: list[int]) -> None:
        """Show how far ours and slerp are from the original, and ours in the chosen joints."""
        session, lines = self._session, []
        for name in (OURS, SLERP):
            errors = session.errors(name)
            lines.append((name, _summary(errors.centimetres, errors.degrees)))
            if name == OURS and 0 < len(chosen) < session.skeleton.n_joints:
                own = _summary(errors.centimetres[:, chosen], errors.degrees[:, chosen])
                lines.append(("", f"{counted(len(chosen), 'chosen joint')}: {own}"))
        lines.append(("", f"{len(session.keys)} keys of {len(session.samples)} samples"))
        if session.unconverged:
            lines.append(("", f"{counted(len(session.unconverged), 'segment')} slerped: no geodesic was found"))
        if not session.is_thorough:
            lines.append(("", "quick preview"))
        self._controls.show_status(lines)

    def draw_charts(self, frame: int, joint: int | None) -> None:
        """Draw the error over time, and the angle of the chosen joint."""
        session, errors = self._session, {}
        for name in (SLERP, OURS):
            found = session.errors(name)
            column = found.centimetres.mean(axis=1) if joint is None else found.centimetres[:, joint]
            errors[name] = np.interp(session.times, session.times[found.frames], column)
        self._timeline.draw(self._timeline.error, session.times, errors, self.key_frames, frame)
        if joint is not None:
            angles = {name: session.angles(name, joint) for name in (ORIGINAL, OURS)}
            self._timeline.draw(self._timeline.angle, session.times, angles, self.key_frames, frame)


def _summary(centimetres: np.ndarray, degrees: np.ndarray) -> str:
    lengths, angles = ([figure(float(each)) for each in (v.mean(), v.max())] for v in (centimetres, degrees))
    return f"{lengths[0]} cm, {angles[0]}°; largest {lengths[1]} cm, {angles[1]}°"


def figure(value: float) -> str:
    """Write a number in three digits: errors of small characters are seen, and those of large ones stay short."""
    return f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


def _box(body: Body, animation: Animation) -> np.ndarray:
    """Measure the box of a body, or of a metre around its skeleton if nothing is drawn of it."""
    if body.parts:
        return bounds(body, animation)
    places = animation.translations.reshape(-1, 3)
    return np.stack([places.min(axis=0) - 0.5, places.max(axis=0) + 0.5])
