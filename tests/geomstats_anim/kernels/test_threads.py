"""The compile notice, the start of a second process, and the threads."""

import os
import subprocess
import sys

import numpy as np
import pytest

from geomstats_anim.kernels import threads as compilation

FIRST_CALL = """
import time
import numpy as np
from geomstats_anim import Animation, MetricParameters, Skeleton, interpolate
start = time.perf_counter()
skeleton = Skeleton(["arm"], [-1], [[0, 0, 0]], [[0, 0, 0, 1]])
keys = Animation(skeleton, [0, 1], [[[0, 0, 0, 1]], [[0.36, 0.48, 0, 0.8]]], np.zeros((2, 1, 3)))
metric = MetricParameters(2.0, 0.5)
pose = interpolate(keys, [0.5], metric=metric).rotations[0, 0]
# more keys, a velocity instead of an end, and other arrays must not compile anything again
first = time.perf_counter() - start
more = Animation(skeleton, [0, 1, 2], [[[0, 0, 0, 1]], [[0.36, 0.48, 0, 0.8]], [[1, 0, 0, 0]]], np.zeros((3, 1, 3)))
interpolate(more, np.linspace(0, 2, 7, dtype=np.float32), metric=metric)
print(pose.tolist(), first, time.perf_counter() - start - first)
"""


@pytest.mark.slow
def test_the_notice_is_given_once_and_the_second_process_starts_at_once(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    runs = [
        subprocess.run([sys.executable, "-c", FIRST_CALL], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert runs[0].stderr.count("Compiling the geodesic kernels") == 1
    assert runs[1].stderr == ""
    poses = [run.stdout.partition("]")[0] for run in runs]
    assert poses[0] == poses[1]
    # what is compiled is compiled in the first call
    first, rest = (float(number) for number in runs[0].stdout.split("] ")[1].split())
    assert rest < 0.2 * first


@pytest.mark.parametrize("n_processors", [1, 2, 5])
@pytest.mark.parametrize("n_problems", [0, 1, 511, 1024, 5000])
def test_threads_share_out_every_problem_once(monkeypatch, n_processors, n_problems):
    monkeypatch.setattr(compilation.os, "sched_getaffinity", lambda _: set(range(n_processors)), raising=False)
    seen = np.zeros(n_problems, dtype=int)

    def run(part):
        seen[part] += 1

    compilation.in_threads(run, n_problems)
    assert (seen == 1).all()


def test_an_error_in_a_thread_is_raised(monkeypatch):
    monkeypatch.setattr(compilation.os, "sched_getaffinity", lambda _: {0, 1}, raising=False)

    def run(part):
        raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        compilation.in_threads(run, 5000)
