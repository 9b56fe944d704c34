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
"""Seconds before a command hangs."""

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
        self.since, self.buffer = time.monotonic(), b""

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
            worker.since, worker.buffer = time.monotonic(), worker.buffer + data
            *lines, worker.buffer = worker.buffer.split(b"\n")
            for line in lines:
                number, result, words = json.loads(line)
                told(trials[number], Outcome(result, words))
                worker.numbers.remove(number)
            if not data:
                _bury(trials, workers.pop(pipe), waiting, told)
        for pipe, worker in list(workers.items()):
            if time.monotonic() - worker.since > PATIENCE:
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
    trial, *rest = worker.numbers
    how = f"hangs for {PATIENCE:g} s" if hung else f"dies of signal {ended_by}"
    alone = _plain_usd(trials[trial])
    told(trials[trial], Outcome("USD" if alone else "failed", f"{how}; OpenUSD alone: {alone or 'does not'}"))
    if rest:
        waiting.append(rest)


def _plain_usd(trial: Trial) -> str:
    """How OpenUSD alone ends with the file, if it is by a crash or a hang."""
    if trial.suffix == ".bvh":
        return ""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / trial.name
        path.write_bytes(trial.data)
        command = [sys.executable, "-c", PLAIN, str(path), f"{folder}/out.usda"]
        try:
            code = subprocess.run(command, capture_output=True, timeout=PATIENCE / 2.0).returncode
        except subprocess.TimeoutExpired:
            return f"takes more than {PATIENCE / 2.0:g} s too"
        return f"dies of signal {-code}" if code < 0 else ""
