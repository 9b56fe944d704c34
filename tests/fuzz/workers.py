"""Trials in forked processes, so that one that crashes or hangs takes nothing along."""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.fuzz.trial import Outcome, Trial, Trials, perform

PATIENCE = 10.0
"""Seconds of the processor before a command hangs."""

MEMORY = 8 << 30
"""Bytes of address space: more is a failure, and must not be the machine's."""

RECYCLED = 1000
"""Trials before a worker is replaced."""

PLAIN = """
import sys
from pxr import Usd
stage = Usd.Stage.Open(sys.argv[1])
for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
    for attribute in prim.GetAttributes():
        [attribute.Get(code) for code in attribute.GetTimeSamples()], attribute.Get()
stage.Flatten().Export(sys.argv[2])
"""
"""OpenUSD alone: open a file, read everything, and write it."""

TRACED = """
import mmap, sys
from tests.fuzz.trial import VERBS
with open(sys.argv[1], "wb+") as file:
    file.write(bytes(512))
    file.flush()
    last = mmap.mmap(file.fileno(), 512)
def trace(frame, event, argument):
    name = frame.f_code.co_filename
    if "/usd_tools/" in name or "/geomstats_anim/" in name:
        last[:] = f"{name}:{frame.f_lineno}".encode()[:512].ljust(512)
        return trace
sys.settrace(trace)
VERBS[sys.argv[2]].main(sys.argv[3:])
"""
"""A command that leaves behind which line of ours is the last. What is compiled of ours is in geomstats_anim."""


class _Worker:
    def __init__(self, trials: Trials, numbers: list[int]) -> None:
        self.numbers = numbers
        self.folder = tempfile.TemporaryDirectory()
        self.pipe, theirs = os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self.pipe)
            _serve(trials, numbers, Path(self.folder.name), theirs)
            os._exit(0)
        os.close(theirs)
        self.buffer = b""
        self.start_clock()

    def start_clock(self) -> None:
        """Begin with another trial."""
        self._since, self._used = time.monotonic(), self._processor_seconds()

    def hangs(self) -> bool:
        """Whether a trial takes too long: of the processor's time, for others may keep it busy; or just sleeps."""
        waited = time.monotonic() - self._since
        return waited > PATIENCE and (waited > 6.0 * PATIENCE or self._processor_seconds() - self._used > PATIENCE)

    def _processor_seconds(self) -> float:
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self) -> int:
        """Wait for it and give its signal."""
        _, status = os.waitpid(self.pid, 0)
        os.close(self.pipe)
        self.folder.cleanup()
        return os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0


def _serve(trials: Trials, numbers: list[int], folder: Path, pipe: int) -> None:
    try:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for number in numbers:
            outcome = perform(trials[number], folder)
            os.write(pipe, json.dumps([number, outcome.result, outcome.words[:4000]]).encode() + b"\n")
    except BaseException as error:
        os.write(pipe, json.dumps([numbers[0], "failed", f"the fuzzer itself: {error!r}"]).encode() + b"\n")


def run(trials: Trials, numbers: list[int], n_workers: int, told: Callable[[Trial, Outcome], None]) -> None:
    """Perform trials.

    Parameters
    ----------
    trials : Trials
    numbers : list of int
    n_workers : int
    told : callable
        Told of each outcome.
    """
    assert len(os.listdir("/proc/self/task")) == 1, "a process with threads must not fork"
    waiting = [numbers[k : k + RECYCLED] for k in range(0, len(numbers), RECYCLED)][::-1]
    workers: dict[int, _Worker] = {}
    while waiting or workers:
        while waiting and len(workers) < n_workers:
            worker = _Worker(trials, waiting.pop())
            workers[worker.pipe] = worker
        ready, _, _ = select.select(list(workers), [], [], 0.5)
        for pipe in ready:
            worker = workers[pipe]
            data = os.read(pipe, 1 << 20)
            worker.start_clock()
            worker.buffer += data
            *lines, worker.buffer = worker.buffer.split(b"\n")
            for line in lines:
                number, result, words = json.loads(line)
                told(trials[number], Outcome(result, words))
                worker.numbers.remove(number)
            if not data:
                _bury(trials, workers.pop(pipe), waiting, told)
        for pipe, worker in list(workers.items()):
            if worker.hangs():
                os.kill(worker.pid, signal.SIGKILL)
                _bury(trials, workers.pop(pipe), waiting, told, hung=True)


def _bury(
    trials: Trials,
    worker: _Worker,
    waiting: list[list[int]],
    told: Callable[[Trial, Outcome], None],
    hung: bool = False,
) -> None:
    """Take the dead worker's trial for the cause, and let others do the rest."""
    ended_by = worker.end()
    if not worker.numbers:
        return
    number, *rest = worker.numbers
    trial = trials[number]
    where = _slow_alone(trial) if hung else _last_line(trial)
    how = f"hangs for {PATIENCE:g} s" if hung else f"dies of signal {ended_by}"
    told(trial, Outcome("USD" if where else "failed", f"{how}; in OpenUSD: {where or 'not for sure'}"))
    if rest:
        waiting.append(rest)


def _slow_alone(trial: Trial) -> str:
    """Tell whether OpenUSD alone takes long with the file too."""
    done = _again(trial, PATIENCE / 2.0, lambda path, out: ["-c", PLAIN, path, out]) if trial.suffix != ".bvh" else None
    return f"alone it takes more than {PATIENCE / 2.0:g} s too" if done == "" else ""


def _last_line(trial: Trial) -> str:
    """Line of ours that a crash happened in, unless it may be in what we compile ourselves."""
    command = ["-c", TRACED]
    last = _again(trial, 10.0 * PATIENCE, lambda path, out: [*command, out, trial.verb, path, *trial.options]) or ""
    return "" if "/geomstats_anim/" in last else last.rpartition("/")[2].strip()


def _again(trial: Trial, seconds: float, arguments: Callable[[str, str], list[str]]) -> str | None:
    """Run Python on a trial's file; what it wrote to its second file, "" if it takes too long, None if nothing."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder) / trial.name, Path(folder) / "told.usda"
        path.write_bytes(trial.data)
        command = [sys.executable, *arguments(str(path), str(out))]
        here = {**os.environ, "PYTHONPATH": os.getcwd()}
        try:
            subprocess.run(command, capture_output=True, cwd=folder, env=here, timeout=seconds)
        except subprocess.TimeoutExpired:
            return ""
        return out.read_text(errors="replace") if out.exists() else None
