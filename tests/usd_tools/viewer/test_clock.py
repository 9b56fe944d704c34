"""The clock: plays at its speed, loops or ends, and never jumps when something else changes."""

import pytest

from usd_tools.viewer.clock import Clock


def test_plays_and_pauses():
    clock = Clock(2.0, 6.0)
    assert clock.at(10.0) == 2.0
    clock.play(10.0)
    assert clock.at(11.5) == 3.5
    clock.pause(12.0)
    assert clock.at(99.0) == 4.0 and not clock.is_playing
    clock.play(100.0)
    assert clock.at(101.0) == 5.0


def test_loops_to_its_start():
    clock = Clock(2.0, 6.0)
    clock.play(0.0)
    assert clock.at(5.0) == pytest.approx(3.0) and clock.is_playing


def test_ends_where_it_does_not_loop_and_begins_anew():
    clock = Clock(2.0, 6.0, loops=False)
    clock.play(0.0)
    assert clock.at(5.0) == 6.0 and not clock.is_playing
    clock.play(20.0)
    assert clock.at(20.0) == 2.0


def test_speed_changes_without_a_jump():
    clock = Clock(0.0, 10.0)
    clock.play(0.0)
    clock.set_speed(0.5, 4.0)
    assert clock.at(4.0) == 4.0 and clock.at(6.0) == 5.0


def test_seeks_within_the_clip():
    clock = Clock(0.0, 10.0)
    clock.seek(99.0, 0.0)
    assert clock.at(0.0) == 10.0
    clock.play(0.0)
    clock.seek(-1.0, 3.0)
    assert clock.at(4.0) == 1.0


def test_a_single_frame_stands():
    clock = Clock(1.0, 1.0)
    clock.play(0.0)
    assert clock.at(5.0) == 1.0
