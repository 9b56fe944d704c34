"""A slider over powers of two, with a box that shows and takes the value itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

DOUBLINGS = 5.0
"""Sliders go from 2^-5 to 2^5; the box takes any value from `SMALLEST` on."""

SMALLEST = 1e-4


class LogSlider:
    """Slider and box of one positive number.

    Parameters
    ----------
    gui : viser.GuiApi
    label, hint : str
    """

    def __init__(self, gui: Any, label: str, hint: str) -> None:
        marks = (-DOUBLINGS, f"1/{2**DOUBLINGS:g}"), (0.0, "1"), (DOUBLINGS, f"{2**DOUBLINGS:g}")
        self.slider = gui.add_slider(label, -DOUBLINGS, DOUBLINGS, 0.05, 0.0, marks=marks, hint=hint)
        # viser shows and takes the position on a slider, which is the logarithm: there is no public way to hide that
        own = f'[id="{self.slider._impl.uuid}"]'
        hidden = f"{own} .mantine-Slider-label, {own} + .mantine-NumberInput-root {{ display: none }}"
        gui.add_html(f"<style>{hidden}</style>")
        self.box = gui.add_number(f"{label} =", 1.0, min=SMALLEST, step=0.1, hint=hint)

    def show(self, value: float) -> None:
        """Show a value in both."""
        self.slider.value = float(np.clip(np.log2(value), -DOUBLINGS, DOUBLINGS))
        self.box.value = _shown(value)

    def on_change(self, changed: Callable[[float], None]) -> None:
        """Call with the value when a browser changes either; the other follows."""

        def slid(event: Any) -> None:
            if event.client_id is not None:
                value = float(2.0**event.target.value)
                self.box.value = _shown(value)
                changed(value)

        def typed(event: Any) -> None:
            value = float(event.target.value)
            if event.client_id is not None and value > 0.0:  # who types 0.5 types 0 first
                self.slider.value = float(np.clip(np.log2(value), -DOUBLINGS, DOUBLINGS))
                changed(value)

        self.slider.on_update(slid)
        self.box.on_update(typed)


def _shown(value: float) -> float:
    """Round to the digits of the box, so that a browser has nothing to correct."""
    return max(SMALLEST, round(value, 4))
