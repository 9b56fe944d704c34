"""Trials in forked processes, so that one that crashes or hangs takes nothing along."""

from __future__ import annotations

import json
import mmap
import os
import resource
import select
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import FrameType

from pxr import Usd

from tests.fuzz.trial import Outcome, Trial, Trials, perform

PATIENCE = 10.0
"""Seconds of the processor before a command hangs."""

MEMORY = 8 << 30
"""Bytes of address space: more is a failure, and must not be the machine's."""

RECYCLED = 1000
"""Trials before a worker is replaced."""


class _Worker:
    def __init__(self, trials: Trials, numbers: list[int]) -> None:
        self.numbers = numbers
        self.folder = tempfile.TemporaryDirectory()
        self.pipe, theirs = os.pipe()
        self._line = mmap.mmap(-1, 512)
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self.pipe)
            sys.settrace(partial(_trace, self._line))
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

    def last_line(self) -> str:
        """Line of ours that it was last in, unless that may be in what we compile ourselves, in geomstats_anim."""
        line = self._line[:].decode(errors="replace").strip("\0 ")
        return "" if "/geomstats_anim/" in line else line.rpartition("/")[2]

    def end(self) -> int:
        """Wait for it and give its signal."""
        _, status = os.waitpid(self.pid, 0)
        os.close(self.pipe)
        self.folder.cleanup()
        return os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0


def _trace(line: mmap.mmap, frame: FrameType, event: str, argument: object) -> Callable[..., object] | None:
    name = frame.f_code.co_filename
    if "/usd_tools/" not in name and "/geomstats_anim/" not in name:
        return None
    line[:] = f"{name}:{frame.f_lineno}".encode()[:512].ljust(512)
    return partial(_trace, line)


def _serve(trials: Trials, numbers: list[int], folder: Path, pipe: int) -> None:
    try:
        _limit()
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
    where = _slow_alone(trial) if hung else worker.last_line()
    how = f"hangs for {PATIENCE:g} s" if hung else f"dies of signal {ended_by}"
    told(trial, Outcome("USD" if where else "failed", f"{how}; in OpenUSD: {where or 'not for sure'}"))
    if rest:
        waiting.append(rest)


def _slow_alone(trial: Trial) -> str:
    """Tell whether most of a command's time is OpenUSD's: both run again, the better of two times."""
    if trial.suffix == ".bvh":
        return ""
    whole, alone = (min(_seconds(partial(job, trial)) for _ in range(2)) for job in (perform, _read))
    return f"alone it takes {alone:.1f} of {whole:.1f} s" if alone > 0.5 * whole else ""


def _read(trial: Trial, folder: Path) -> None:
    """Let OpenUSD open a file, read everything, and write it."""
    path = folder / trial.name
    path.write_bytes(trial.data)
    stage = Usd.Stage.Open(str(path))
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        for attribute in prim.GetAttributes():
            [attribute.Get(code) for code in (*attribute.GetTimeSamples(), Usd.TimeCode.Default())]
    stage.Flatten().Export(str(folder / "plain.usda"))


def _seconds(job: Callable[[Path], object]) -> float:
    """Do something in a process and a folder of its own; seconds of the processor until it ends or is stopped."""
    with tempfile.TemporaryDirectory() as folder:
        pid = os.fork()
        if pid == 0:
            try:
                signal.alarm(int(6.0 * PATIENCE))
                _limit()
                job(Path(folder))
            finally:
                os._exit(0)
        _, _, usage = os.wait4(pid, 0)
    return usage.ru_utime + usage.ru_stime


def _limit() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
