"""The command `live`: it says where the page is, ends on an interrupt, and refuses before anything opens."""

import os
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from rigs import make_rig, random_rotations

from usd_tools import live
from usd_tools.console.errors import UsageError

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def rig(tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(12), rotations=random_rotations(12, 3))
    return tmp_path / "in.usda"


@pytest.mark.parametrize("word", ["-1", "65536", "eighty", "1.5"])
def test_ports_are_checked(run, rig, word):
    code, _, err = run("live", rig, f"--port={word}")
    assert code == 2 and "--port" in err
    with pytest.raises(UsageError, match="--port"):
        live.LiveOptions(port=word)


def test_refuses_before_anything_opens(run, rig, tmp_path, monkeypatch):
    monkeypatch.setattr("usd_tools.viewer.run.serving", lambda *_: pytest.fail("something was opened"))
    make_rig(tmp_path / "still.usda", codes=[0])
    (tmp_path / "broken.usda").write_text("#usda 1.0\n(")
    for words in (
        [tmp_path / "nothing.usda"],
        [tmp_path / "broken.usda"],
        [tmp_path / "still.usda"],
        [rig, "-o", rig],
        [rig, "-o", tmp_path / "no folder" / "out.usda"],
        [rig, "--prim", "/Nothing"],
        [rig, "--library", tmp_path / "nothing.inbetween"],
        [rig, "--library", tmp_path / "broken.usda"],
    ):
        code, out, err = run("live", *words, "--no-browser")
        assert code == 1 and out == "" and err.startswith("error: ") and err.count("\n") == 1, words
    assert not list(tmp_path.glob("*edits*"))


def test_a_missing_extra_is_named(run, rig, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    code, _, err = run("live", rig, "-o", tmp_path / "out.usda", "--no-browser")
    assert code == 1 and "pip install 'geomstats-anim[live]'" in err


@pytest.mark.slow
def test_serves_until_an_interrupt(rig, tmp_path):
    pytest.importorskip("viser")
    words = [sys.executable, "-m", "usd_tools.live", rig, "-o", tmp_path / "out.usda", "--port", "0", "--no-browser"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    # a shell has jobs in the background ignore interrupts, and programs inherit that
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    server = subprocess.Popen(words, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=-1, text=True)
    signal.signal(signal.SIGINT, handler)
    address = server.stdout.readline().split()[1]
    assert address.startswith("http://localhost:")
    assert b"<html" in urllib.request.urlopen(address).read().lower()
    server.send_signal(signal.SIGINT)
    out, err = server.communicate(timeout=60)
    assert server.returncode == 0 and "Ended" in out and "Traceback" not in err
    assert {path.name for path in tmp_path.iterdir()} == {"in.usda"}
