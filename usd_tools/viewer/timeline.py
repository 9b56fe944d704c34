"""The time line under the view: play, scrub, key marks, and the chosen joint's angle and error over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from usd_tools.figures.style import INK
from usd_tools.viewer.controls import Controls
from usd_tools.viewer.scene import COLORS, ORIGINAL, OURS, SLERP

if TYPE_CHECKING:
    import viser

MAX_POINTS = 1500
"""Of a plotted line; a longer one is thinned, peaks kept."""

_MAX_MARKS = 120
_HEIGHT, _WIDTH = 190.0, 700.0
_TICKS = {"keys": INK, "now": "#d81b60"}


class Timeline:
    """Panel under the view.

    Parameters
    ----------
    server : viser.ViserServer
    n_frames : int
    on_scrub : callable
        Called with a frame.
    on_play : callable
        Called when the button is pressed.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        n_frames: int,
        on_scrub: Callable[[int], None],
        on_play: Callable[[], None],
    ) -> None:
        self._gui: Any = server.gui
        panel = self._gui.add_panel()
        with panel.add_tab("Time"):
            self.play = self._gui.add_button("Play", order=0.0)
            self.play.on_click(lambda _: on_play())
            last = max(1, n_frames - 1)
            self.scrub: Any = self._gui.add_slider("frame", 0, last, 1, 0, order=1.0, hint="Marks are keys.")
            Controls.on_change(self.scrub, lambda value: on_scrub(int(value)))
            self.moment: Any = self._gui.add_text("time", "", disabled=True, order=2.0)
        with panel.add_tab("Error, cm"):
            self.error = self._add_chart((SLERP, OURS))
        with panel.add_tab("Angle, degrees"):
            self.angle = self._add_chart((ORIGINAL, OURS))
        panel.float(x=15.0, y=-15.0, width=_WIDTH, height=_HEIGHT)

    def _add_chart(self, names: tuple[str, ...]) -> Any:
        series: list[Any] = [{"label": "s"}]
        series += [{"label": name, "stroke": COLORS[name], "width": 2, "points": {"show": False}} for name in names]
        series += [{"label": label, "stroke": color, "points": {"show": False}} for label, color in _TICKS.items()]
        return self._gui.add_uplot(
            tuple(np.arange(2.0) for _ in series),
            tuple(series),
            height=110,
            scales={"x": {"time": False}, "y": {"auto": True}},
            legend={"show": False},
        )

    def set_keys(self, frames: np.ndarray) -> None:
        """Mark the frames that are keys, or some of very many."""
        from viser._messages import GuiSliderMark

        seen = frames[:: -(-len(frames) // _MAX_MARKS) or 1].tolist()
        # viser has no public way to change marks, and a new slider misses what browsers send to the old one
        self.scrub._marks = tuple(GuiSliderMark(value=float(frame), label=None) for frame in seen)

    def show(self, frame: int, text: str) -> None:
        """Show which frame is seen."""
        self.scrub.value = frame
        self.moment.value = text

    def set_playing(self, is_playing: bool) -> None:
        """Show what the button does."""
        self.play.label = "Pause" if is_playing else "Play"

    def draw(self, chart: Any, times: np.ndarray, lines: Mapping[str, np.ndarray], keys: np.ndarray, now: int) -> None:
        """Draw lines of one chart, shape=[F], with ticks at the keys and a line at what is seen."""
        *_, last = lines.values()
        seen = np.union1d(thinned(last, MAX_POINTS), [now])
        top = max(float(max(line.max() for line in lines.values())), 1e-9)
        ticks = [np.where(np.isin(seen, keys), 0.08 * top, 0.0), np.where(seen == now, top, 0.0)]
        chart.data = (times[seen], *(line[seen] for line in lines.values()), *ticks)


def thinned(values: np.ndarray, count: int) -> np.ndarray:
    """Choose indices of a line so that its lowest and highest values stay in every stretch.

    Parameters
    ----------
    values : array-like, shape=[F]
    count : int
        About how many to keep.

    Returns
    -------
    indices : array-like of int
        Increasing; all of them where there are no more than `count`.
    """
    if len(values) <= count:
        return np.arange(len(values))
    starts = np.linspace(0, len(values), count // 2, endpoint=False).astype(int)
    parts = np.split(values, starts[1:])
    extremes = [(start + part.argmin(), start + part.argmax()) for start, part in zip(starts, parts, strict=True)]
    return np.unique(np.concatenate([np.ravel(extremes), [0, len(values) - 1]]))
