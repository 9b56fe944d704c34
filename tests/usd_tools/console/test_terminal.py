"""Every verb prints to a real terminal of 80 columns: nothing wider, and no word lost or broken."""

import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import sys
import termios

import pytest
from real_files import real_file
from rich.cells import cell_len

pytestmark = pytest.mark.slow

N_COLUMNS = 80

CALLS = {
    "learn": ["learn", "{clip}", "-o", "learned.usda", "--family", "spd"],
    "learn -v": ["learn", "{clip}", "-o", "learned.usda", "--scheme", "geodesic-spline", "-v"],
    "inspect": ["inspect", "{clip}"],
    "inspect learned": ["inspect", "learned.usda"],
    "downsample": ["downsample", "{clip}", "-o", "sparse.usdc", "--tolerance", "3"],
    "downsample -v": ["downsample", "{clip}", "-o", "sparse.usdc", "--rate", ".2", "-v"],
    "upsample": ["upsample", "sparse.usdc", "-o", "back.usda", "--times", "source"],
    "upsample -v": ["upsample", "learned.usda", "-o", "more.usda", "--fps", "50", "-v"],
    "compare": ["compare", "{clip}", "-o", "comparison", "--rates", ".3", "--schemes", "slerp", "geodesic-spline"],
}

RUNNER = """
import contextlib, importlib, json, sys

import usd_tools.console.progress

usd_tools.console.progress.PATIENCE = 1e9  # a bar is drawn over and over

with open("warm", "w") as warm, contextlib.redirect_stdout(warm), contextlib.redirect_stderr(warm):
    for verb in ("learn", "downsample"):  # compiling is told once per process
        calls = [words for words in json.loads(sys.argv[1]).values() if words[0] == verb]
        importlib.import_module(f"usd_tools.{verb}").main(calls[0][1:])
for name, (verb, *arguments) in json.loads(sys.argv[1]).items():
    main = importlib.import_module(f"usd_tools.{verb}").main
    print(f"@@ {name}", flush=True)
    assert main(arguments) == 0
    with open(f"{name}.plain", "w") as plain, contextlib.redirect_stdout(plain), contextlib.redirect_stderr(plain):
        assert main(arguments) == 0
"""


def in_a_terminal(command, folder):
    """Run a command in a terminal of 80 columns; give what it shows."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, N_COLUMNS, 0, 0))
    variables = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES", "NO_COLOR")}
    paths = {"PYTHONPATH": os.pathsep.join(sys.path), "TERM": "xterm-256color"}
    with subprocess.Popen(
        command, cwd=folder, env=variables | paths, stdin=theirs, stdout=theirs, stderr=theirs, close_fds=True
    ) as process:
        os.close(theirs)
        shown = b""
        while True:
            try:
                more = os.read(ours, 1 << 16)
            except OSError:  # the other end is closed
                break
            if not more:
                break
            shown += more
    os.close(ours)
    text = shown.decode()
    assert process.returncode == 0, text
    return text


@pytest.fixture(scope="module", params=["clips/punching.usda", "clips/sitting.usda"])
def shown(request, tmp_path_factory):
    """Return the output of every verb, once in a terminal and once in a file."""
    folder = tmp_path_factory.mktemp("terminal")
    calls = {name: [word.format(clip=real_file(request.param)) for word in words] for name, words in CALLS.items()}
    text = in_a_terminal([sys.executable, "-c", RUNNER, json.dumps(calls)], folder)
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.replace("\r\n", "\n"))
    parts = dict(part.split("\n", 1) for part in text.split("@@ ")[1:])
    return {name: (part, (folder / f"{name}.plain").read_text()) for name, part in parts.items()}


def words(text):
    return set(re.sub(r"[│┃┏┳┓┡╇┩├┼┤└┴┘┌┬┐━─]", " ", text).split())


@pytest.mark.parametrize("name", CALLS)
def test_terminal_of_80_columns(shown, name):
    terminal, plain = shown[name]
    commands = [line for line in terminal.splitlines() if line.startswith("  python -m ")]
    lines = [line for line in terminal.splitlines() if line not in commands]
    assert max(map(cell_len, lines)) <= N_COLUMNS
    assert words(terminal) == words(plain)


@pytest.mark.parametrize("name", ["learn", "learn -v", "inspect learned"])
def test_every_verdict_is_there(shown, name):
    assert re.search(r"\b(beats|ties with|loses to)\b", " ".join(shown[name][0].split()))


def test_the_columns_of_compare(shown):
    header = next(line for line in shown["compare"][0].splitlines() if "┃" in line)
    assert [name.strip() for name in header.split("┃")[1:-1]] == [
        "rate",
        "scheme",
        "mean cm",
        "max cm",
        "Q_hyb",
        "unseen Q",
        "skate",
    ]
