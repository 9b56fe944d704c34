"""The process that computes: started once, asked over a pipe, ended with Blender."""

import atexit
import os
import queue
import subprocess
import tempfile
import threading

import numpy as np

from . import messages, preferences

PATIENCE = 300.0
"""Seconds without a word after which the process is given up; its first start compiles for about a minute."""


class ServiceError(Exception):
    """Error that one sentence says."""


class _Process:
    """A running process."""

    def __init__(self, python):
        self.python = python
        self.errors = tempfile.TemporaryFile()
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}
        # -P: nothing is imported from the folder that Blender happens to be in
        command = [python, "-P", "-m", "usd_tools.serving"]
        hidden = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": self.errors}
        try:
            self.process = subprocess.Popen(command, env=environment, **pipes, **hidden)
        except OSError as error:
            raise ServiceError(f"{python} cannot be started: {error.strerror}; see the preferences.") from error
        self.answers = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            while (message := messages.read_message(self.process.stdout)) is not None:
                self.answers.put(message)
        except (ValueError, OSError):
            pass
        self.answers.put(None)

    def ask(self, header, arrays, progress):
        try:
            messages.write_message(self.process.stdin, header, arrays)
        except OSError as error:
            raise ServiceError(self._reason()) from error
        while True:
            try:
                message = self.answers.get(timeout=PATIENCE)
            except queue.Empty:
                raise ServiceError(f"geomstats-anim has not answered for {PATIENCE:g} seconds.") from None
            if message is None:
                raise ServiceError(self._reason())
            if "progress" not in message[0]:
                return message
            progress(message[0]["progress"])

    def _reason(self):
        """Say why the process has ended."""
        self.process.wait(5.0)
        self.errors.seek(0)
        lines = self.errors.read().decode(errors="replace").strip().splitlines()
        if lines and "No module named" in lines[-1]:
            return (
                f"{self.python} has no geomstats-anim; install it there, or choose another Python in the preferences."
            )
        return f"geomstats-anim has ended: {lines[-1] if lines else 'it left no message'}"

    def close(self):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.errors):
            try:
                pipe.close()
            except OSError:
                pass


_running = None
_lock = threading.Lock()


def ask(header, arrays, progress=lambda text: None):
    """Ask the process, which is started if it does not run.

    Parameters
    ----------
    header : dict
    arrays : dict of str to array-like
    progress : callable
        Told what is being done.

    Returns
    -------
    header : dict
    arrays : dict of str to array-like

    Raises
    ------
    ServiceError
        If there is no such process, or it refuses.
    """
    global _running
    python = preferences.python()
    if python is None:
        raise ServiceError(
            "geomstats-anim is not found: pip install it for a Python, and choose that Python in the preferences of "
            "this extension."
        )
    with _lock:
        if _running is not None and (_running.python != python or _running.process.poll() is not None):
            close()
        if _running is None:
            _running = _Process(python)
        try:
            answer, numbers = _running.ask(header, arrays, progress)
        except ServiceError:
            close()
            raise
    if "error" in answer:
        raise ServiceError(answer["error"])
    return answer, numbers


def warm_up():
    """Have it compile what in-betweens need, by one bone that turns."""
    metric = {"format": "geodesicMetric", "version": 1, "joints": ["bone"], "alpha": [2.0], "beta": [1.0], "axes": None}
    metric |= {"invariance": ["left"], "tension": [1.0], "scheme": "geodesic-spline", "quality": "", "provenance": {}}
    turns = np.array([[1.0, 0.0, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0], [0.8, 0.0, 0.6, 0.0]])
    arrays = {"rest": np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]), "0/times": np.arange(3.0), "0/0": turns}
    header = {"request": "in-betweens", "joints": ["bone"], "parents": [-1], "metric": metric, "metres": 1.0}
    ask({**header, "groups": [[[0, "QUATERNION"]]]}, {**arrays, "0/wanted": np.array([0.5])})


def is_busy():
    """Return whether it is working for somebody else."""
    return _lock.locked()


def close():
    """End the process."""
    global _running
    if _running is not None:
        _running.close()
        _running = None


atexit.register(close)
