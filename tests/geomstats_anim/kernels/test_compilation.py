"""The notice while kernels compile, the start of a second process, and the cache between them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import geomstats_anim

FIRST_CALL = """
import time
import numpy as np
from geomstats_anim import Animation, MetricParameters, Skeleton, interpolate
start = time.perf_counter()
skeleton = Skeleton(["arm"], [-1], [[0, 0, 0]], [[0, 0, 0, 1]])
keys = Animation(skeleton, [0, 1], [[[0, 0, 0, 1]], [[0.36, 0.48, 0, 0.8]]], np.zeros((2, 1, 3)))
metric = MetricParameters(2.0, 0.5)
pose = interpolate(keys, [0.5], "geodesic", metric).rotations[0, 0]
# more keys, a velocity instead of an end, and other arrays must not compile anything again
first = time.perf_counter() - start
more = Animation(skeleton, [0, 1, 2], [[[0, 0, 0, 1]], [[0.36, 0.48, 0, 0.8]], [[1, 0, 0, 0]]], np.zeros((3, 1, 3)))
interpolate(more, np.linspace(0, 2, 7, dtype=np.float32), "geodesic", metric)
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


CROSS = """
import numpy as np
from geomstats_anim import rotations
from geomstats_anim.kernels import quaternions
print(rotations.cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])))
print(sum(quaternions.cross.stats.cache_hits.values()))
"""


class Copy:
    """A copy of the package, with kernels to edit, and a home folder to keep compiled ones in."""

    def __init__(self, folder: Path) -> None:
        source = Path(geomstats_anim.__file__).parent
        self.site, self.home = folder / "site", folder / "home"
        self.kernels = self.site / source.name / "kernels"
        shutil.copytree(source, self.kernels.parent, ignore=shutil.ignore_patterns("__pycache__"))
        self.home.mkdir()

    def start(self) -> subprocess.Popen:
        """Start a process that prints e_x x e_y, and how often the kernel came from the cache."""
        environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
        environment |= {"PYTHONPATH": str(self.site), "HOME": str(self.home), "XDG_CACHE_HOME": str(self.home)}
        run = [sys.executable, "-P", "-c", CROSS]
        return subprocess.Popen(run, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def cross(self) -> tuple[str, int]:
        """Return what such a process has printed."""
        return finish(self.start())


def finish(process: subprocess.Popen) -> tuple[str, int]:
    printed, errors = process.communicate()
    assert process.returncode == 0, errors
    vector, hits = printed.splitlines()
    assert ("Compiling the geodesic kernels" in errors) == (hits == "0")
    return vector, int(hits)


@pytest.fixture
def copy(tmp_path):
    return Copy(tmp_path)


def test_an_edited_kernel_never_runs_stale(copy):
    assert copy.cross() == ("[0. 0. 1.]", 0)
    assert copy.cross() == ("[0. 0. 1.]", 1)
    # the kernel that runs is in another file, and neither size nor time of this one tell that it changed
    vectors = copy.kernels / "vectors.py"
    source, status = vectors.read_text(), vectors.stat()
    edited = source.replace("a[0] * b[1] - a[1] * b[0])", "a[1] * b[0] - a[0] * b[1])", 1)
    assert edited != source
    for python_cache in (copy.kernels / "__pycache__").glob("vectors.*.pyc"):
        python_cache.unlink()
    vectors.write_text(edited)
    os.utime(vectors, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert copy.cross() == ("[ 0.  0. -1.]", 0)
    vectors.write_text(source)
    assert copy.cross() == ("[0. 0. 1.]", 1)


def make_read_only(copy):
    (copy.kernels / "__pycache__").write_text("a file, so that no folder can be made here")


def zip_up(copy):
    archive = shutil.make_archive(str(copy.home / "site"), "zip", copy.site)
    copy.site = Path(archive)
    shutil.rmtree(copy.kernels)


@pytest.mark.slow
@pytest.mark.parametrize("install", [make_read_only, zip_up])
def test_kernels_are_kept_for_the_user_where_the_installation_cannot_be_written_to(copy, install):
    install(copy)
    assert copy.cross() == ("[0. 0. 1.]", 0)
    assert copy.cross() == ("[0. 0. 1.]", 1)
    assert list(copy.home.glob("numba/*/quaternions.cross-*.nbc"))


@pytest.mark.slow
def test_kernels_run_where_nothing_can_be_written(copy):
    make_read_only(copy)
    copy.home.rmdir()
    copy.home.write_text("a file too")
    process = copy.start()
    printed, errors = process.communicate()
    assert printed.splitlines() == ["[0. 0. 1.]", "0"]
    assert "set NUMBA_CACHE_DIR" in errors


@pytest.mark.slow
def test_processes_may_compile_at_once(copy):
    processes = [copy.start() for _ in range(3)]
    assert {finish(process)[0] for process in processes} == {"[0. 0. 1.]"}
    assert copy.cross() == ("[0. 0. 1.]", 1)
