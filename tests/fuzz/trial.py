"""One broken file and one command: what must be true of it, whatever is in the file."""

from __future__ import annotations

import importlib
import os
import re
import shutil
import sys
import tempfile
import traceback
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random

from pxr import Usd

from geomstats_anim.learning.tune.journal import Journal
from tests.fuzz.mutations import broken, renamed
from tests.fuzz.seeds import SPACE, seeds
from usd_tools.console.errors import ToolError
from usd_tools.console.errors import run as run_command

KINDS = (*(".usda",) * 6, *(".usdc",) * 4, *(".bvh",) * 4, *(".usdz",) * 3, ".json", ".txt", ".jsonl")
TEXTS = (".usda", ".bvh", ".json", ".txt", ".jsonl")
_UPSAMPLE = (
    ("--factor", "3", "-o", "out.usda"),
    ("--factor", "2", "--alpha", "4", "--beta", ".5", "-o", "out.usdc"),
    ("--fps", "60", "--retime", "-o", "out.usda", "--flatten"),
    ("--times", "0.5,1.25", "--scheme", "squad", "-o", "out.usda"),
    ("--factor", "2", "--scheme", "geodesic", "--joint", "*arm*:alpha=3", "-o", "out.usdz"),
)
_DOWNSAMPLE = (("--rate", ".5", "-o", "out.usda"), ("--tolerance", "1", "-o", "out.usdc"))
VERBS = {
    verb: importlib.import_module(f"usd_tools.{verb}")
    for verb in ("inspect", "upsample", "learn", "downsample", "compare", "from_bvh", "repair")
}
COMMANDS = {
    "inspect": ((), ("--json",)),
    "upsample": _UPSAMPLE,
    "learn": (("--rate", ".4", "-o", "out.usda"),),
    "downsample": _DOWNSAMPLE,
    "repair": (("-o", "out.usda"), ("-o", "out.usdc", "--max-gap", "3"), ("-o", "out.usdz", "--smooth", "3")),
    "compare": (("--rates", ".5", "--schemes", "slerp", "geodesic-spline", "-o", "out"),),
}
SHARES = {"inspect": 4, "upsample": 12, "learn": 2, "downsample": 6, "repair": 4, "compare": 1}
FROM_BVH = (("-o", "out.usda"), ("-o", "out.usdc", "--skip-first"), ("-o", "out.usdz", "--fps", "30", "--up", "Z"))
PACKAGES = (
    ("--factor", "2", "-o", "out.usdz"),
    ("--factor", "2", "-o", "out.usdz", "--max-unpacked", ".000004"),
    ("--factor", "2", "-o", "out.usda"),
)
COMPANION = "good.usda"
"""A good file, for commands whose other file is broken; FILE stands for that one."""

BESIDE = {
    ".json": ("upsample", (COMPANION, "--factor", "2", "--metric", "FILE", "-o", "out.usda")),
    ".txt": ("upsample", (COMPANION, "--times", "FILE", "-o", "out.usda")),
    ".jsonl": ("journal", ("FILE",)),
}
_VERBS = [verb for verb in COMMANDS for _ in range(SHARES[verb])]


@dataclass(frozen=True)
class Trial:
    """A number's file and command."""

    number: int
    suffix: str
    data: bytes
    verb: str
    options: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the file."""
        return f"in{self.number}{self.suffix}"

    @property
    def arguments(self) -> list[str]:
        """Arguments of the command."""
        if self.suffix in BESIDE:
            return [self.name if word == "FILE" else word for word in self.options]
        return [self.name, *self.options]

    @property
    def command(self) -> str:
        """Command line."""
        return " ".join(["python -m", f"usd_tools.{self.verb}", *self.arguments])


class Trials:
    """The trial of every number."""

    def __init__(self, seed: int) -> None:
        self._seed, self._files = seed, seeds()

    def __getitem__(self, number: int) -> Trial:
        """Make one."""
        random = Random(f"{self._seed} {number}")
        suffix = random.choice(KINDS)
        files = self._files[suffix]
        data = broken(random.choice(files), files, suffix in TEXTS, random)
        if suffix in BESIDE:
            return Trial(number, suffix, data, *BESIDE[suffix])
        if suffix == ".usdz" and random.random() < 0.7:
            return Trial(number, suffix, renamed(random.choice(files), random), "upsample", random.choice(PACKAGES))
        verb = "from_bvh" if suffix == ".bvh" else random.choice(_VERBS)
        return Trial(number, suffix, data, verb, random.choice(FROM_BVH if suffix == ".bvh" else COMMANDS[verb]))


def warm_up(folder: Path) -> None:
    """Run every command on good files, for what is compiled or loaded at first must not be taken for a hang."""
    good = seeds()
    for verb, several in {**COMMANDS, "from_bvh": FROM_BVH}.items():
        suffix = ".bvh" if verb == "from_bvh" else ".usda"
        for number, data in enumerate(good[suffix]):
            for options in several:
                perform(Trial(number, suffix, data, verb, options), folder)
    for suffix, (verb, options) in BESIDE.items():
        perform(Trial(0, suffix, good[suffix][0], verb, options), folder)


@dataclass(frozen=True)
class Outcome:
    """Result of a trial: "accepted", "refused" with a sentence, or "failed" with what is wrong."""

    result: str
    words: str = ""


def perform(trial: Trial, folder: Path) -> Outcome:
    """Run a trial in this process; the working folder and the streams are changed and put back."""
    here, streams = os.getcwd(), [os.dup(1), os.dup(2)]
    work, scratch, told = folder / "work", folder / "scratch", folder / "told"
    for each in (work, scratch, told):
        each.mkdir(exist_ok=True)
    tempfile.tempdir = str(scratch)
    try:
        os.chdir(work)
        Path(trial.name).write_bytes(trial.data)
        if COMPANION in trial.options:
            Path(COMPANION).write_bytes(_good())
        for stream, name in ((1, "out"), (2, "err")):
            file = os.open(told / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(file, stream)
            os.close(file)
        code = _call(trial)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for stream, saved in enumerate(streams, 1):
            os.dup2(saved, stream)
            os.close(saved)
        tempfile.tempdir = None
    outcome = _judge(trial, code, (told / "err").read_text(encoding="utf-8", errors="replace"), scratch)
    os.chdir(here)
    shutil.rmtree(work)
    return outcome


def _call(trial: Trial) -> int | str:
    try:
        if trial.verb == "journal":
            return run_command(lambda: _resume(Path(trial.name)))
        return VERBS[trial.verb].main(trial.arguments)
    except SystemExit as stop:  # of a usage error: --times names a file
        return stop.code if trial.suffix == ".txt" and isinstance(stop.code, int) else traceback.format_exc()
    except BaseException:
        return traceback.format_exc()


def _resume(path: Path) -> int:
    """Read a journal as a resumed search does, without Ray."""
    try:
        Journal(path).begin(SPACE, 3, resume=True)
    except ValueError as error:
        raise ToolError(str(error)) from error
    return 0


@cache
def _good() -> bytes:
    return seeds()[".usda"][0]


def _judge(trial: Trial, code: int | str, err: str, scratch: Path) -> Outcome:
    lines = err.splitlines()
    if isinstance(code, str) or "Traceback" in err:
        return Outcome("failed", f"traceback: {code}{err}")
    out = Path(trial.options[trial.options.index("-o") + 1]) if "-o" in trial.options else None
    allowed = {trial.name, *({COMPANION} & set(trial.options))} | ({str(out)} if out and code == 0 else set())
    if {path.name for path in Path().iterdir()} != allowed or list(scratch.iterdir()):
        left = [str(path) for path in (*Path().iterdir(), *scratch.iterdir())]
        return Outcome("failed", f"exit code {code}, but these files are there: {left}")
    if Path(trial.name).read_bytes() != trial.data:
        return Outcome("failed", "the input has changed")
    if code == 0:
        for path in _written(out) if out else ():
            if path.suffix.startswith(".usd") and not Usd.Stage.Open(str(path)):
                return Outcome("failed", f"{path} cannot be opened")
            if path.suffix != ".usdz" and (word := re.search(rb"geomstats_anim-\w+", path.read_bytes())):
                return Outcome("failed", f"{path} names a temporary folder: {word.group()!r}")
        return Outcome("accepted")
    if code == 2:
        lines = lines[:1] if "".join(lines[1:]).startswith("usage: ") else lines
    errors = [line for line in lines if line.startswith("error: ")]
    if code not in (1, 2) or len(errors) != 1 or lines[-1] != errors[0] or len(errors[0]) > 1000:
        return Outcome("failed", f"exit code {code} and not one sentence: {err[-1500:]}")
    return Outcome("refused", errors[0].removeprefix("error: "))


def _written(out: Path) -> list[Path]:
    """List the files of an output, which may be a folder."""
    return [path for path in out.rglob("*") if path.is_file()] if out.is_dir() else [out]
