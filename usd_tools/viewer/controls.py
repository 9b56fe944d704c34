"""The controls of the page: what they show, and whom they tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any, Protocol

from geomstats_anim.names import INVARIANCES, MAX_TENSION
from usd_tools.editing.saving import CONTENTS
from usd_tools.viewer.joints import EVERY
from usd_tools.viewer.log_slider import LogSlider
from usd_tools.viewer.scene import COLORS

if TYPE_CHECKING:
    import viser

OVERLAID, SIDE_BY_SIDE = "overlaid", "side by side"
EVERY_NTH, ALL_SAMPLES, CHOSEN = "every n-th sample", "the file's samples", "n chosen samples"
PURPOSES = {"reconstruct": "rebuild this clip", "predict": "predict between its samples"}


class Listener(Protocol):
    """Whoever does what the controls ask for."""

    def choose_joint(self, line: str) -> None:
        """Choose a joint by its line in the list."""

    def choose_pattern(self, pattern: str) -> None:
        """Choose joints by a glob."""

    def drag(self, field: str, value: Any) -> None:
        """Preview a setting of the chosen joints."""

    def reset(self, everything: bool) -> None:
        """Reset the chosen joints, or all."""

    def mirror(self) -> None:
        """Copy the chosen joints to the other side."""

    def step(self, word: str) -> None:
        """Undo or redo."""

    def use_scheme(self, scheme: str) -> None:
        """Interpolate by another scheme."""

    def use_preset(self, name: str) -> None:
        """Take a preset."""

    def store_preset(self, name: str) -> None:
        """Store the present metric as a preset."""

    def use_keys(self, kind: str, count: int) -> None:
        """Take other keys."""

    def pin(self, is_key: bool) -> None:
        """Make the sample that is shown a key, or free it."""

    def learn(self, purpose: str) -> None:
        """Learn a metric for the present keys, or end the search that runs."""

    def save(self, content: str) -> None:
        """Save."""

    def change_view(self) -> None:
        """Show what the controls of the view say."""

    def set_speed(self, speed: float) -> None:
        """Play at another speed."""

    def set_loop(self, loops: bool) -> None:
        """Begin anew at the end, or stop there."""


class Controls:
    """Panel beside the view.

    Parameters
    ----------
    server : viser.ViserServer
    listener : Listener
    joints : sequence of str
        Lines of the list of joints.
    schemes, presets : sequence of str
        Their names.
    target : str
        File that Save writes.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        listener: Listener,
        joints: Sequence[str],
        schemes: Sequence[str],
        presets: Sequence[str],
        target: str,
    ) -> None:
        self._server, self._listener = server, listener
        self._gui: Any = server.gui  # viser's types say that values cannot be set
        self._gui.main_panel.dock_right()
        self._gui.main_panel.set_width(330.0)
        with self._gui.add_folder("Error from the original"):
            self.status = self._gui.add_html("")
        with self._gui.add_folder("Joint"):
            self._add_joint(joints)
        with self._gui.add_folder("In-betweens"):
            self._add_in_betweens(schemes, presets)
        with self._gui.add_folder("View", expand_by_default=False):
            self._add_view()
        with self._gui.add_folder("Save"):
            self._add_save(target)

    def _add_joint(self, joints: Sequence[str]) -> None:
        gui, listener = self._gui, self._listener
        self.joint = gui.add_dropdown("joint", (EVERY, *joints), hint="Or click on the character; type to search.")
        self.pattern = gui.add_text("or joints like", "*", hint="Glob such as *Arm*, matched against joint names.")
        halves = (0.0, "0"), (1.0, "1"), (MAX_TENSION, f"{MAX_TENSION:g}")
        self.alpha = LogSlider(gui, "alpha", "Cost of turns about the second axis; the first axis costs 1.")
        self.beta = LogSlider(gui, "beta", "Cost of turns about the third axis; the first axis costs 1.")
        self.tension = gui.add_slider(
            "tension",
            0.0,
            MAX_TENSION,
            0.02,
            1.0,
            marks=halves,
            hint="Smoothness at the keys: 0 corners, 1 velocity, 2 acceleration.",
        )
        self.translation_tension = gui.add_slider(
            "move tension", 0.0, MAX_TENSION, 0.02, 1.0, marks=halves, hint="The same for translations."
        )
        self.axes = gui.add_vector3("axes", (0.0, 0.0, 0.0), step=1.0, hint="Rotation vector of the axes, degrees.")
        self.invariance = gui.add_dropdown("side", INVARIANCES, hint="Invariance of the metric.")
        self.on_change(self.joint, listener.choose_joint)
        self.on_change(self.pattern, listener.choose_pattern)
        for field in ("alpha", "beta"):
            getattr(self, field).on_change(partial(listener.drag, field))
        for field in ("tension", "translation_tension", "axes", "invariance"):
            self.on_change(getattr(self, field), partial(listener.drag, field))
        resets = gui.add_button_group("reset", ("these", "all joints"))
        resets.on_click(lambda event: listener.reset(event.target.value == "all joints"))
        gui.add_button("Mirror to the other side").on_click(lambda _: listener.mirror())
        self.steps = gui.add_button_group("edits", ("undo", "redo"))
        self.steps.on_click(lambda event: listener.step(event.target.value))

    def _add_in_betweens(self, schemes: Sequence[str], presets: Sequence[str]) -> None:
        gui, listener = self._gui, self._listener
        self.scheme = gui.add_dropdown("scheme", tuple(schemes))
        self.on_change(self.scheme, listener.use_scheme)
        self.preset = gui.add_dropdown("preset", tuple(presets))
        gui.add_button("Use preset").on_click(lambda _: listener.use_preset(self.preset.value))
        self.preset_name = gui.add_text("store as", "")
        gui.add_button("Store preset").on_click(lambda _: listener.store_preset(self.preset_name.value))
        self.keys = gui.add_dropdown("keys", (EVERY_NTH, ALL_SAMPLES, CHOSEN))
        self.key_count = gui.add_number("n", 10, min=1, max=100_000, step=1)
        gui.add_button("Use keys").on_click(lambda _: listener.use_keys(self.keys.value, int(self.key_count.value)))
        pins = gui.add_button_group("this frame", ("pin", "free"))
        pins.on_click(lambda event: listener.pin(event.target.value == "pin"))
        self.purpose = gui.add_dropdown("learn to", tuple(PURPOSES.values()))
        self.learn = gui.add_button("Learn")
        self.learn.on_click(lambda _: listener.learn(_word(PURPOSES, self.purpose.value)))
        self.progress = gui.add_html("", visible=False)

    def _add_view(self) -> None:
        gui, changed = self._gui, self._listener.change_view
        self.speed = gui.add_slider("speed", 0.1, 2.0, 0.1, 1.0)
        self.on_change(self.speed, lambda value: self._listener.set_speed(float(value)))
        self.loop = gui.add_checkbox("loop", True)
        self.on_change(self.loop, self._listener.set_loop)
        self.shown = {name: gui.add_checkbox(name, True) for name in COLORS}
        self.layout = gui.add_dropdown("characters", (SIDE_BY_SIDE, OVERLAID))
        self.bones = gui.add_checkbox("bones instead of skin", False)
        self.colors = gui.add_checkbox("colours of the file", False)
        self.follow = gui.add_checkbox("follow", True)
        self.path = gui.add_checkbox("path of the joint", True)
        self.onion = gui.add_checkbox("onion skins at keys", False)
        every = (*self.shown.values(), self.layout, self.bones, self.colors, self.follow, self.path, self.onion)
        for control in every:
            self.on_change(control, lambda _: changed())

    def _add_save(self, target: str) -> None:
        gui = self._gui
        self.target = gui.add_text("to", target, disabled=True)
        self.content = gui.add_dropdown(
            "what", CONTENTS, hint="The metric over the source; keys with it; or dense samples."
        )
        gui.add_button("Save").on_click(lambda _: self._listener.save(self.content.value))
        self.saved = gui.add_html("")

    @staticmethod
    def on_change(control: Any, changed: Callable[[Any], None]) -> None:
        """Call when a browser changes a control, and not when the program does."""

        def update(event: Any) -> None:
            if event.client_id is not None:
                changed(event.target.value)

        control.on_update(update)

    def show_joint(self, line: str, pattern: str, values: dict[str, Any]) -> None:
        """Show the settings of the chosen joints."""
        with self._server.atomic():
            self.joint.value, self.pattern.value = line, pattern
            self.alpha.show(values["alpha"])
            self.beta.show(values["beta"])
            self.tension.value, self.translation_tension.value = values["tension"], values["translation_tension"]
            self.axes.value, self.invariance.value = tuple(values["axes"]), values["invariance"]

    def show_scheme(self, scheme: str) -> None:
        """Show which scheme interpolates."""
        self.scheme.value = scheme

    def show_status(self, lines: Sequence[tuple[str, str]]) -> None:
        """Show lines of text, each with the name of its character or ""."""
        self.status.content = _html(lines)

    def show_progress(self, text: str | None) -> None:
        """Show what a search does; None when it has ended."""
        self.learn.label = "Learn" if text is None else "End the search"
        self.progress.visible = text is not None
        self.progress.content = _html([("", text or "")])

    def show_saved(self, sentences: Sequence[str]) -> None:
        """Show what was saved."""
        self.saved.content = _html([("", sentence) for sentence in sentences])

    def set_presets(self, names: Sequence[str]) -> None:
        """List other presets."""
        self.preset.options = tuple(names)


def _word(words: dict[str, str], text: str) -> str:
    return next(word for word, each in words.items() if each == text)


def _html(lines: Sequence[tuple[str, str]]) -> str:
    """Write lines as HTML; what they say is text, whatever a file's names may be."""
    dots = {name: f'<span style="color:{COLORS[name]}">\u25cf</span> ' for name in COLORS}
    rows = (f"<div>{dots.get(name, '')}{escape(text)}</div>" for name, text in lines)
    return f'<div style="padding:.4em .9em;font-size:.85em;overflow-wrap:anywhere">{"".join(rows)}</div>'
