"""A slider over powers of two: slider and box show the same value, and each follows the other."""

from types import SimpleNamespace

import pytest

from usd_tools.viewer.log_slider import DOUBLINGS, SMALLEST, LogSlider


class Control:
    """Control of viser: a value, and whom changes are told."""

    def __init__(self, value):
        self.value, self._impl, self.changed = value, SimpleNamespace(uuid="ab-1"), None

    def on_update(self, changed):
        self.changed = changed

    def set(self, value, client=1):
        """Do what a browser does; the program itself is client None."""
        self.value = value
        self.changed(SimpleNamespace(client_id=client, target=self))


@pytest.fixture
def made():
    html = []
    gui = SimpleNamespace(
        add_slider=lambda label, low, high, step, value, **rest: Control(value),
        add_number=lambda label, value, **rest: Control(value),
        add_html=html.append,
    )
    slider, told = LogSlider(gui, "alpha", "cost"), []
    slider.on_change(told.append)
    assert "ab-1" in html[0]
    return slider, told


def test_a_moved_slider_gives_the_value(made):
    slider, told = made
    slider.slider.set(1.5)
    assert told == [2.0**1.5] and slider.box.value == pytest.approx(2.8284, abs=1e-9)


def test_a_typed_value_is_taken_as_it_is(made):
    slider, told = made
    slider.box.set(0.125)
    assert told == [0.125] and slider.slider.value == -3.0
    slider.box.set(1000.0)
    assert told[-1] == 1000.0 and slider.slider.value == DOUBLINGS


def test_what_is_typed_on_the_way_is_no_value(made):
    slider, told = made
    slider.box.set(0.0)
    assert told == []


def test_the_program_is_not_told_what_it_does(made):
    slider, told = made
    slider.show(8.0)
    assert (slider.slider.value, slider.box.value) == (3.0, 8.0)
    slider.slider.set(2.0, client=None)
    slider.box.set(2.0, client=None)
    assert told == []
    slider.show(1e-9)
    assert slider.box.value == SMALLEST and slider.slider.value == -DOUBLINGS
