"""Exit codes of commands, and a sentence at most."""

import os
import signal
import subprocess
import sys

import pytest
from rigs import make_rig, random_rotations

from usd_tools.console.errors import Messages, ToolError, run

SLOW = """
import signal, sys
import usd_tools.upsampling.interpolation as work
from usd_tools.upsample import main

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started us with Ctrl+C ignored

def resample(*arguments):
    import time
    print("ready", flush=True)
    time.sleep(60)

work.resample = resample
sys.exit(main(sys.argv[1:]))
"""


def test_an_interrupt_ends_with_130_and_leaves_nothing(tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, "in.usda", "-o", "out.usda", "--factor", "2"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out) == (130, "")
    assert err == "error: interrupted; unfinished output was discarded.\n"
    assert [path.name for path in tmp_path.iterdir()] == ["in.usda"]


@pytest.mark.parametrize(
    ("error", "code", "sentence"),
    [
        (ToolError("in\x1b[2J.usda is broken; repair it."), 1, "error: in\\x1b[2J.usda is broken; repair it.\n"),
        (FileNotFoundError(2, "No such file", "a\nb"), 1, "error: a\\nb: No such file\n"),
        (KeyboardInterrupt(), 130, "error: interrupted; unfinished output was discarded.\n"),
    ],
)
def test_errors_end_with_one_sentence(capsys, error, code, sentence):
    def command():
        raise error

    assert run(command) == code
    assert capsys.readouterr().err == sentence


def test_warnings_are_heard_once():
    heard = []
    messages = Messages(heard.append)
    for sentence in ("a.", "b.", "a."):
        messages.warn(sentence)
    assert heard == messages.warnings == ["a.", "b."]
