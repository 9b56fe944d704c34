"""Trials in forked processes, so that one that crashes or hangs takes nothing along."""

from __future__ import annotations

import faulthandler
import json
import os
import re
import resource
import select
import signal
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from pxr import Tf, Usd

from tests.fuzz.trial import Outcome, Trial, Trials, perform

PATIENCE = 10.0
"""Seconds of the processor before a command hangs."""

MEMORY = 8 << 30
"""Bytes of address space: more is a failure, and must not be the machine's."""

FAULT = "fault"
"""File with the lines of Python that a crash happened in."""

RECYCLED = 1000
"""Trials before a worker is replaced."""


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
        """Return whether a trial takes too long, in processor time, since others may keep it busy, or asleep."""
        waited = time.monotonic() - self._since
        return waited > PATIENCE and (waited > 6.0 * PATIENCE or self._processor_seconds() - self._used > PATIENCE)

    def _processor_seconds(self) -> float:
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self) -> tuple[int, str]:
        """Wait for it; give its signal and the innermost line of Python then, if it is one that calls OpenUSD."""
        _, status = os.waitpid(self.pid, 0)
        os.close(self.pipe)
        fault = (Path(self.folder.name) / FAULT).read_text(errors="replace")
        self.folder.cleanup()
        line = re.search(r'File "(.*?)", line (\d+)', fault)
        # pxr has little Python of its own, and usd_tools nothing that is compiled
        ours = line and re.search("/(usd_tools|pxr)/", line[1])
        return os.WTERMSIG(status), f"{Path(line[1]).name}:{line[2]}" if line and ours else ""


def _serve(trials: Trials, numbers: list[int], folder: Path, pipe: int) -> None:
    try:
        _limit()
        faulthandler.enable((folder / FAULT).open("w"))
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
    hung: list[int] = []

    def bury(worker: _Worker, stopped: bool) -> None:
        """Take the dead worker's trial for the cause, and let others do the rest."""
        ended_by, line = worker.end()
        if not worker.numbers:
            return
        number, *rest = worker.numbers
        waiting.extend([rest] if rest else [])
        if stopped and hung.count(number) < 2:
            hung.append(number)
            waiting.append([number])  # others may keep the machine busy
            return
        where = _slow_alone(trials[number]) if stopped else line or _dies_alone(trials[number])
        how = f"hangs for {PATIENCE:g} s" if stopped else f"dies of signal {ended_by}"
        told(trials[number], Outcome("USD" if where else "failed", f"{how}; in OpenUSD: {where or 'not for sure'}"))

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
                bury(workers.pop(pipe), stopped=False)
        for pipe, worker in list(workers.items()):
            if worker.hangs():
                os.kill(worker.pid, signal.SIGKILL)
                bury(workers.pop(pipe), stopped=True)


def _slow_alone(trial: Trial) -> str:
    """Tell whether most of a command's time is OpenUSD's: both run again, the better of two times."""
    if not trial.suffix.startswith(".usd"):
        return ""
    alone, whole = (min(_alone(partial(job, trial))[1] for _ in range(2)) for job in (_read, perform))
    return f"alone it takes {alone:.1f} of {whole:.1f} s" if alone > 0.5 * whole else ""


def _dies_alone(trial: Trial) -> str:
    """Tell whether OpenUSD dies of a file by itself: of an error that it calls fatal it leaves no line of Python."""
    ended_by = _alone(partial(_read, trial))[0] if trial.suffix.startswith(".usd") else 0
    return f"alone it dies of signal {ended_by}" if ended_by else ""


def _read(trial: Trial, folder: Path) -> None:
    """Let OpenUSD open a file, read everything, and write it."""
    path = folder / trial.name
    path.write_bytes(trial.data)
    stage = Usd.Stage.Open(str(path))
    with suppress(Tf.ErrorException):
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
            for attribute in prim.GetAttributes():
                [attribute.Get(code) for code in (*attribute.GetTimeSamples(), Usd.TimeCode.Default())]
    with suppress(Tf.ErrorException):
        stage.GetRootLayer().Export(str(folder / "layer.usda"))
    stage.Flatten().Export(str(folder / "plain.usda"))


def _alone(job: Callable[[Path], object]) -> tuple[int, float]:
    """Do something in a process and a folder of its own; its signal, and seconds of the processor until it ended."""
    with tempfile.TemporaryDirectory() as folder:
        pid = os.fork()
        if pid == 0:
            try:
                signal.alarm(int(6.0 * PATIENCE))
                _limit()
                job(Path(folder))
            finally:
                os._exit(0)
        _, status, usage = os.wait4(pid, 0)
    return os.WTERMSIG(status), usage.ru_utime + usage.ru_stime


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
