"""Run the commands of tutorial.rst and write what they print below them: python docs/make_tutorial.py.

A command is a line of a console block that begins with "$ "; the lines up to the next one are its output in a terminal
of 80 columns. Windows has no such terminals.
"""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
import tempfile
import termios
from collections.abc import Iterator
from pathlib import Path

_HERE = Path(__file__).resolve().parent
TUTORIAL = _HERE / "tutorial.rst"
_BLOCK = re.compile(r"^\.\. code-block:: console\n\n((?: {3}.*\n|\n(?= {3}))+)", re.MULTILINE)
_WIDTH = 80
_FIRST_USE = "Compiling the geodesic kernels"


def sessions(text: str) -> list[tuple[str, str]]:
    """Return the commands of a page, as they are typed, and the output below each, without indentation."""
    return [session for block in _BLOCK.finditer(text) for session in _of_block(block[1])]


def _of_block(block: str) -> Iterator[tuple[str, str]]:
    plain = re.sub(r"^ {3}", "", block, flags=re.MULTILINE)
    for part in re.split(r"^\$ ", plain, flags=re.MULTILINE)[1:]:
        command, _, output = re.sub(r"\\\n", "\0", part).partition("\n")
        yield command.replace("\0", "\\\n"), output.rstrip("\n")


def make_clips(folder: Path) -> None:
    """Write the example clips where the commands look for them."""
    out = folder / "examples" / "clips"
    subprocess.run([sys.executable, _HERE.parent / "examples" / "make_clips.py", "-o", out], check=True, stdout=-1)


def printed(command: str, folder: Path) -> str:
    """Run a command in a folder; return what a terminal shows, warnings last, or raise a CalledProcessError."""
    environment = os.environ | {"TERM": "dumb", "NO_COLOR": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, (str(_HERE.parent), environment.get("PYTHONPATH"))))
    words = re.sub(r"^geomstats-anim ", f"'{sys.executable}' -m usd_tools ", command)
    terminal, its_end = pty.openpty()
    termios.tcsetwinsize(terminal, (50, _WIDTH))
    with subprocess.Popen(  # errors are kept off the terminal, for there is a progress bar among them
        words, shell=True, cwd=folder, env=environment, stdout=its_end, stderr=subprocess.PIPE, text=True
    ) as running:
        os.close(its_end)
        shown = b"".join(_read(terminal)).decode().replace("\r\n", "\n") + (
            running.stderr.read() if running.stderr else ""
        )
    if running.returncode:
        raise subprocess.CalledProcessError(running.returncode, command, shown)
    lines = (line.rstrip() for line in shown.splitlines() if not line.startswith(_FIRST_USE))
    return "\n".join(lines).rstrip("\n")


def _read(terminal: int) -> Iterator[bytes]:
    """Yield what a terminal gets until the other end is closed, which Linux reports as an error."""
    while True:
        try:
            part = os.read(terminal, 4096)
        except OSError:
            part = b""
        if not part:
            return os.close(terminal)
        yield part


def main() -> int:
    """Write the outputs into the tutorial."""
    text = TUTORIAL.read_text("utf-8")
    with tempfile.TemporaryDirectory() as folder:
        make_clips(Path(folder))

        def rewritten(block: re.Match[str]) -> str:
            lines = []
            for command, _ in _of_block(block[1]):
                print(f"$ {command}", flush=True)
                lines += [f"$ {command}", printed(command, Path(folder))]
            plain = "\n".join(line for line in lines if line)
            return ".. code-block:: console\n\n" + re.sub(r"^(?=.)", "   ", plain, flags=re.MULTILINE) + "\n"

        TUTORIAL.write_text(_BLOCK.sub(rewritten, text), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
