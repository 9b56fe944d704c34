"""The tutorial prints what is printed; docs/make_tutorial.py writes the new output where a change is meant."""

import runpy

import pytest
from commands import ROOT

TUTORIAL = runpy.run_path(str(ROOT / "docs" / "make_tutorial.py"))
SESSIONS = TUTORIAL["sessions"](TUTORIAL["TUTORIAL"].read_text("utf-8"))


def test_commands_and_outputs_are_told_apart():
    page = ".. code-block:: console\n\n   $ one \\\n       --more\n   out\n\n   $ two\n   a\n     b\n\nText.\n"
    assert TUTORIAL["sessions"](page) == [("one \\\n    --more", "out"), ("two", "a\n  b")]


def test_every_command_of_the_tutorial_has_an_output():
    assert len(SESSIONS) >= 8
    for command, output in SESSIONS:
        assert command.startswith("geomstats-anim ") and output, command


@pytest.mark.slow
def test_the_tutorial_prints_what_is_printed(tmp_path):
    TUTORIAL["make_clips"](tmp_path)
    for command, expected in SESSIONS:
        assert TUTORIAL["printed"](command, tmp_path) == expected, command
