"""The page: what browsers ask for is done by one thread, which also plays."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from usd_tools.characters.placement import up_axis
from usd_tools.console.errors import ToolError
from usd_tools.editing.edits import ChooseKeys, Edit, EveryNth, FreeKey, Mirror, PinKey, Reset, UseScheme, patterns
from usd_tools.editing.history import autosave_path, read_session, write_session
from usd_tools.editing.presets import PRESETS, read_presets, write_preset
from usd_tools.editing.saving import SaveOptions, styles_of
from usd_tools.editing.session import EditSession
from usd_tools.upsampling.joint_styles import Style
from usd_tools.viewer.clock import Clock
from usd_tools.viewer.controls import CHOSEN, EVERY_NTH, Controls
from usd_tools.viewer.inbox import Inbox
from usd_tools.viewer.joints import EVERY, joint_lines
from usd_tools.viewer.scene import SceneView
from usd_tools.viewer.search import Search
from usd_tools.viewer.timeline import Timeline
from usd_tools.viewer.view import View

if TYPE_CHECKING:
    import viser

PUSHES = 30.0
"""Pictures per second at most."""

DENSE = 10
"""A clip whose samples are its frames begins with every tenth as a key."""

_SETTLED, _CHARTED = 0.3, 0.25
"""Seconds after the last move of a slider until what was dragged is applied, and between two charts."""


class LivePage:
    """A session shown by a server; a `Listener` of its controls.

    Parameters
    ----------
    server : viser.ViserServer
    session : EditSession
    out : Path
        File that Save writes; edits are saved beside it.
    presets : Path
        Folder of the user's presets.
    """

    def __init__(self, server: viser.ViserServer, session: EditSession, out: Path, presets: Path) -> None:
        self.server, self.session, self._out, self._presets = server, session, out, presets
        self._inbox = Inbox()
        self._joints = session.skeleton.joints
        self._patterns = patterns(self._joints)
        self._lines = joint_lines(self._joints, session.skeleton.depths.tolist())
        self.clock = Clock(float(session.times[0]), float(session.times[-1]))
        self.frame, self._shown_frame = 0, -1
        self._pattern, self._dragged, self._dragged_at = "*", "", 0.0
        self._charted_at, self._is_charted = 0.0, False
        self._search: Search | None = None
        self._stopped = threading.Event()
        self.timeline = Timeline(server, len(session.times), self.seek, self.toggle)
        self.controls = Controls(server, self, self._lines, session.schemes, self._preset_names(), str(out))
        up = up_axis(session.clip)
        self.view = View(
            session,
            self.controls,
            self.timeline,
            lambda box, standing: SceneView(server, up, box, standing, self.clicked),
        )
        server.gui.add_command("Play or pause", hotkey="P").on_trigger(lambda _: self.toggle())
        self._begin()

    def _begin(self) -> None:
        """Start with keys between which there is something to see, or with the edits of last time if asked for."""
        if len(self.session.samples) == len(self.session.times) > 2 * DENSE:
            self.session.apply(EveryNth(DENSE))
        self.view.draw_bodies(self.frame)
        self._show_edits()
        if autosave_path(self._out).exists():
            modal = self.server.gui.add_modal("Edits that were not saved")
            with modal:
                again = self.server.gui.add_button("Take up the edits of last time")
                anew = self.server.gui.add_button("Begin anew")
            again.on_click(lambda _: self.take_up())
            again.on_click(lambda _: self._inbox.post(modal.close))
            anew.on_click(lambda _: self._inbox.post(modal.close))

    # The one thread

    def run(self) -> None:
        """Do what is asked for, and play, until `stop`."""
        while not self._stopped.is_set():
            begin = time.monotonic()
            self.work(1.0 / PUSHES if self.clock.is_playing else 0.1)
            self._do(self.tick)
            if self.clock.is_playing:
                time.sleep(max(0.0, 1.0 / PUSHES - (time.monotonic() - begin)))

    def stop(self) -> None:
        """End `run`, and a search if there is one."""
        self._stopped.set()
        if self._search is not None:
            self._search.end()

    def work(self, seconds: float = 0.0) -> None:
        """Do what was asked for, after waiting some seconds at most for something."""
        for action in self._inbox.wait(seconds):
            self._do(action)

    def _do(self, action: Callable[[], None]) -> None:
        try:
            action()
        except ToolError as error:
            self.notify("That did not work", str(error), "red")

    def notify(self, title: str, text: str, color: Any = None) -> None:
        """Show a sentence in every browser."""
        for client in self.server.get_clients().values():
            client.add_notification(title, text, color=color, auto_close_seconds=8.0)

    def tick(self) -> None:
        """Show what is to be seen now."""
        now, was_playing = time.monotonic(), self.clock.is_playing
        if self._dragged and now - self._dragged_at > _SETTLED:
            self._release()
        self.frame = int(np.abs(self.session.times - self.clock.at(now)).argmin())
        if self.frame != self._shown_frame:
            with self.server.atomic():
                self.view.show(self.frame, self._one_joint)
            self._shown_frame, self._is_charted = self.frame, False
        if was_playing != self.clock.is_playing:
            self.timeline.set_playing(False)
        if not self._is_charted and now - self._charted_at > _CHARTED:
            self.view.draw_charts(self.frame, self._one_joint)
            self._charted_at, self._is_charted = now, True

    # The time line

    def seek(self, frame: int) -> None:
        """Show a frame."""
        second = float(self.session.times[min(frame, len(self.session.times) - 1)])
        self._inbox.post(lambda: self.clock.seek(second, time.monotonic()), "seek")

    def toggle(self) -> None:
        """Play or pause."""

        def change() -> None:
            (self.clock.pause if self.clock.is_playing else self.clock.play)(time.monotonic())
            self.timeline.set_playing(self.clock.is_playing)

        self._inbox.post(change)

    def set_speed(self, speed: float) -> None:
        """Play at another speed."""
        self._inbox.post(lambda: self.clock.set_speed(speed, time.monotonic()), "speed")

    def set_loop(self, loops: bool) -> None:
        """Begin anew at the end, or stop there."""
        self._inbox.post(lambda: setattr(self.clock, "loops", loops), "loop")

    # Joints

    @property
    def chosen(self) -> list[int]:
        """Joints that the controls act on."""
        style = Style(self._pattern)
        return [i for i, joint in enumerate(self._joints) if style.matches(joint)]

    @property
    def _one_joint(self) -> int | None:
        chosen = self.chosen
        return chosen[0] if len(chosen) == 1 else None

    def clicked(self, name: str, origin: np.ndarray, direction: np.ndarray) -> None:
        """Choose the joint of a character that a ray meets."""

        def choose() -> None:
            joint = self.view.scene.joint_at(name, self.session.poses(name, self.frame), origin, direction)
            if joint is not None:
                self._choose(self._patterns[self._joints[joint]])

        self._inbox.post(choose, "choose")

    def choose_joint(self, line: str) -> None:
        """Choose a joint by its line in the list."""
        self.choose_pattern("*" if line == EVERY else self._patterns[self._joints[self._lines.index(line)]])

    def choose_pattern(self, pattern: str) -> None:
        """Choose the joints that match a glob."""
        self._inbox.post(lambda: self._choose(pattern), "choose")

    def _choose(self, pattern: str) -> None:
        self._release()
        before, self._pattern = self._pattern, pattern
        if not self.chosen:
            self._pattern = before
            raise ToolError(f"No joint matches {pattern!r}; the list has their names.")
        self._show_chosen()

    def drag(self, field: str, value: Any) -> None:
        """Preview a setting of the chosen joints; it is applied when it has settled."""

        def preview() -> None:
            if self._dragged not in ("", field):
                self._release()
            self.session.drag(Style(self._pattern, **{field: value}))
            self._dragged, self._dragged_at, self._shown_frame = field, time.monotonic(), -1
            self.view.show_errors(self.chosen)

        self._inbox.post(preview, f"drag {field}")

    def _release(self) -> None:
        """Apply what was dragged."""
        if self._dragged:
            self._dragged = ""
            self.session.release()
            self._keep()

    def reset(self, everything: bool) -> None:
        """Reset the chosen joints, or all."""
        self._inbox.post(lambda: self._apply(Reset("*" if everything else self._pattern)))

    def mirror(self) -> None:
        """Copy the chosen joints to the other side."""
        self._inbox.post(lambda: self._apply(Mirror(self._pattern)))

    # Edits

    def _apply(self, *edits: Edit) -> None:
        self._release()
        self.session.apply(*edits)
        self._keep()

    def _keep(self) -> None:
        """Keep the edits on disk, and show what they have changed."""
        write_session(autosave_path(self._out), self.session.to_json())
        self._show_edits()

    def _show_edits(self) -> None:
        self.timeline.set_keys(self.view.key_frames)
        self._show_chosen()

    def _show_chosen(self) -> None:
        """Show the settings and the errors of the chosen joints."""
        chosen, metric = self.chosen, self.session.metric
        i = chosen[0]
        axes = np.zeros(3) if metric.parameters.axes is None else np.degrees(metric.parameters.axes[i])
        values = {
            "alpha": float(metric.parameters.alpha[i]),
            "beta": float(metric.parameters.beta[i]),
            "tension": float(metric.tension[i]),
            "translation_tension": float(metric.translation_tension[i]),
            "axes": axes.tolist(),
            "invariance": metric.parameters.invariance[i],
        }
        self.controls.show_scheme(metric.scheme)
        self.controls.show_joint(self._lines[i] if len(chosen) == 1 else EVERY, self._pattern, values)
        self.view.draw_extras(self.frame, self._one_joint)
        self.view.show_errors(chosen)
        self._shown_frame = -1

    def step(self, word: str) -> None:
        """Undo or redo."""

        def go() -> None:
            self._release()
            (self.session.undo if word == "undo" else self.session.redo)()
            self._keep()

        self._inbox.post(go)

    def take_up(self) -> None:
        """Make the edits again that were kept on disk."""

        def replay() -> None:
            self.session.replay(read_session(autosave_path(self._out)))
            self._keep()

        self._inbox.post(replay)

    # In-betweens

    def use_scheme(self, scheme: str) -> None:
        """Interpolate by another scheme."""
        self._inbox.post(lambda: self._apply(UseScheme(scheme)))

    def _preset_names(self) -> list[str]:
        return [*PRESETS, *self._user_presets()]

    def _user_presets(self) -> dict[str, tuple[Edit, ...]]:
        return read_presets(self._presets) if self._presets.is_dir() else {}

    def use_preset(self, name: str) -> None:
        """Take a preset."""
        self._inbox.post(lambda: self._apply(*{**self._user_presets(), **PRESETS}[name]))

    def store_preset(self, name: str) -> None:
        """Store the present metric as a preset, a file in the user's folder."""

        def store() -> None:
            word = name.strip()
            if not word or Path(word).name != word or word.startswith(".") or word in PRESETS:
                raise ToolError(f"{name!r} cannot name a preset; choose a plain word that none of ours has.")
            self._presets.mkdir(parents=True, exist_ok=True)
            metric = self.session.metric
            write_preset(self._presets / f"{word}.json", [UseScheme(metric.scheme), Reset(), *styles_of(metric)])
            self.controls.set_presets(self._preset_names())

        self._inbox.post(store)

    def use_keys(self, kind: str, count: int) -> None:
        """Take other keys."""
        edit = EveryNth(count) if kind == EVERY_NTH else ChooseKeys(max(2, count)) if kind == CHOSEN else EveryNth(1)
        self._inbox.post(lambda: self._apply(edit))

    def pin(self, is_key: bool) -> None:
        """Make the sample that is shown a key, or free it."""

        def change() -> None:
            samples = self.session.samples
            code = float(samples[np.abs(samples - self.session.codes[self.frame]).argmin()])
            self._apply(PinKey(code) if is_key else FreeKey(code))

        self._inbox.post(change)

    def learn(self, purpose: str) -> None:
        """Learn a metric for the present keys, or end the search that runs."""

        def begin() -> None:
            if self._search is not None:
                self._search.end()
                return
            self._release()
            self._search = Search(self.session, purpose, self._inbox, self.controls.show_progress, self._learned)
            self._search.start()

        self._inbox.post(begin)

    def _learned(self, edit: Edit | None, sentence: str) -> None:
        self._search = None
        if edit is not None:
            self._apply(edit)
        elif sentence:
            self.notify("Nothing was learned", sentence, "red")

    def save(self, content: str) -> None:
        """Save, and say what commands would have made the file."""

        def write() -> None:
            self._release()
            result = self.session.save(self._out, SaveOptions(content=content))
            autosave_path(self._out).unlink(missing_ok=True)
            commands = [f"Made by: {command}" for command in result.commands]
            self.controls.show_saved([f"Wrote {result.path.name} ({content}).", *result.warnings, *commands])

        self._inbox.post(write)

    def change_view(self) -> None:
        """Show what the controls of the view say."""

        def draw() -> None:
            self.view.draw_bodies(self.frame)
            self.view.draw_extras(self.frame, self._one_joint)
            self._shown_frame = -1

        self._inbox.post(draw, "view")
