"""Accuracy and speed of the geodesics, each figure beside its bar.

    python benchmarks/bench_geodesics.py [--quick] [--markdown]

Lines that end in MISSED fail their bar, and then the exit code is 1. Times are of one core, warm, unless they say more.
More cores have to be faster than one in seconds on the wall: run it on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation, Slerp

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "geomstats_anim")]

import oracles  # noqa: E402
import samples  # noqa: E402

from geomstats_anim import LogStatus, PoseMetric, PoseSpace, SO3InvariantMetric, interpolate  # noqa: E402
from geomstats_anim import rotations as quat  # noqa: E402
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics  # noqa: E402
from geomstats_anim.geodesics.shortest import shortest_momenta  # noqa: E402

FIRST_CALL = """
import time
import numpy as np
from geomstats_anim import Animation, MetricParameters, Skeleton, interpolate
imported = time.perf_counter()
skeleton = Skeleton(["arm"], [-1], [[0, 0, 0]], [[0, 0, 0, 1]])
keys = Animation(skeleton, [0, 1], [[[0, 0, 0, 1]], [[0.36, 0.48, 0, 0.8]]], np.zeros((2, 1, 3)))
interpolate(keys, [0.5], metric=MetricParameters(2.0, 0.5))
print(time.perf_counter() - imported)
"""


@dataclass(frozen=True)
class Line:
    """A measured figure, its bar, and whether it is met (None: no bar)."""

    what: str
    bar: str
    figure: str
    met: bool | None = None

    @property
    def verdict(self) -> str:
        """Word for the last column."""
        return "" if self.met is None else "ok" if self.met else "MISSED"


@contextmanager
def one_core() -> Iterator[None]:
    """Keep the process, and the threads that it sizes by its affinity, on one core."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    all_cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(all_cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, all_cores)


def seconds(run: Callable[[], object], repeats: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the least time of a few calls: the one that others disturbed least."""
    times = []
    for _ in range(repeats):
        start = clock()
        run()
        times.append(clock() - start)
    return min(times)


def exp_accuracy(n: int) -> Iterator[Line]:
    """Angles up to 2 pi, condition 1 to 100, against Runge-Kutta and the closed form."""
    for condition in (1.0, 10.0, 100.0):
        rng = np.random.default_rng(1)
        inertia = samples.moments(rng, n, condition)
        momentum = inertia * samples.gaps(rng, n, 0.0, 360.0)
        ends = samples.flow(inertia, momentum)
        matrices = quat.to_matrix(ends)
        error = oracles.angle_between(matrices, oracles.momentum_form(inertia, momentum)[0]).max()
        what = f"exp, {n} of up to 360 deg, condition up to {condition:g}"
        yield Line(f"{what}: error against DOP853", "1e-10 rad", f"{error:.1e} rad", error < 1e-10)
        if condition > 1.0:
            some = range(min(n, 50))
            closed = [oracles.elliptic(inertia[i], momentum[i]) for i in some]
            error = oracles.angle_between(matrices[: len(some)], closed).max()
            yield Line(f"{what}: against elliptic functions", "1e-10 rad", f"{error:.1e} rad", error < 1e-10)
        body = quat.rotate(quat.conjugate(ends), momentum)
        drift = np.abs((body**2 / inertia).sum(-1) / (momentum**2 / inertia).sum(-1) - 1.0).max()
        yield Line(f"{what}: energy", "1e-10", f"{drift:.1e}", drift < 1e-10)
        skew = np.abs(matrices @ np.swapaxes(matrices, -1, -2) - np.eye(3)).max()
        yield Line(f"{what}: orthogonality", "1e-14", f"{skew:.1e}", skew < 1e-14)


def log_cells(n: int) -> Iterator[Line]:
    """Convergence and end points: left and right, full SPD."""
    for low, high, share in ((0, 45, 0.999), (45, 90, 0.999), (90, 170, 0.999), (170, 180, 0.99)):
        for condition in (10.0, 100.0):
            rng = np.random.default_rng(2)
            parameters = samples.parameters(rng, n, condition, full=True)
            initial = samples.quaternions(rng, 1, n)
            turn = quat.exp(samples.gaps(rng, n, low, high))
            end = quat.multiply(initial, turn)
            geodesics = PoseGeodesics.between(initial, end, parameters)
            found = geodesics.status == LogStatus.CONVERGED
            error = quat.distance(geodesics(np.zeros(1, dtype=int), np.ones(1)), end)[found].max()
            yield Line(
                f"log, {n} of {low} to {high} deg, condition up to {condition:g}: converged, worst end point",
                f"{share:.1%}, 1e-10 rad",
                f"{found.mean():.2%}, {error:.1e} rad",
                bool(found.mean() >= share and error < 1e-10),
            )


def shortest(n: int) -> Line:
    """Against the best of 32 random starts."""
    rng = np.random.default_rng(3)
    inertia, vector = samples.moments(rng, n, 25.0), samples.gaps(rng, n, 120.0, 179.0)
    found = shortest_momenta(inertia, vector)
    best = samples.best_of_random_starts(rng, inertia, vector, 32)
    longer = int((np.sqrt(found.energy) > (1.0 + 1e-6) * np.sqrt(best)).sum())
    bar = n // 1000
    return Line(
        f"longer than the best of 32 starts, {n} of 120 to 179 deg, condition up to 25",
        f"at most {bar}",
        str(longer),
        longer <= bar,
    )


def log_speed(n: int, repeats: int) -> Iterator[Line]:
    """Logarithms per second, through the same call that interpolation makes."""
    for low, high, condition, share, bar in (
        (0, 45, 10.0, 1.0, 100_000),
        (45, 90, 10.0, 0.5, 100_000),
        (120, 179, 25.0, 0.1, 4_000),
    ):
        rng = np.random.default_rng(4)
        count = int(share * n)
        parameters = samples.parameters(rng, 100, condition)
        initial = samples.quaternions(rng, count // 100, 100)
        turn = quat.exp(samples.gaps(rng, count // 100 * 100, low, high).reshape(-1, 100, 3))
        end = quat.multiply(initial, turn)

        def run(initial: np.ndarray = initial, end: np.ndarray = end, parameters: object = parameters) -> object:
            return PoseGeodesics.between(initial, end, parameters)

        run()
        n_logs, n_cores = initial.shape[0] * 100, len(os.sched_getaffinity(0))
        with one_core():
            one, alone = (n_logs / seconds(run, repeats, clock) for clock in (time.process_time, time.perf_counter))
        all_cores = n_logs / seconds(run, repeats)
        what = f"logs per second, {low} to {high} deg, condition up to {condition:g}"
        met = None if bar is None else one >= bar
        yield Line(f"{what}, one core", "" if bar is None else f"{bar:,}", f"{one:,.0f}", met)
        if n_cores > 1:
            yield Line(f"{what}, {n_cores} cores", f"one: {alone:,.0f}", f"{all_cores:,.0f}", all_cores > alone)


def playback_speed(repeats: int) -> Line:
    """Dense evaluation of 65 joints x 299 segments."""
    rng = np.random.default_rng(5)
    keys = samples.animation(rng, 300, 65, 20.0)
    geodesics = PoseGeodesics.between(keys.rotations[:-1], keys.rotations[1:], samples.parameters(rng, 65, 10.0))
    per_segment = 20
    index = np.repeat(np.arange(299), per_segment)
    parameter = np.tile(np.arange(per_segment) / per_segment, 299)
    with one_core():
        rate = len(index) * 65 / seconds(lambda: geodesics(index, parameter), repeats)
    return Line("rotations per second, dense playback, one core", "2,000,000", f"{rate:,.0f}", rate >= 2e6)


def against_stock(n_stock: int, repeats: int) -> Iterator[Line]:
    """Compare the public `metric.log` with that of stock Geomstats on the same pairs: one, a batch of 60, of 20 000."""
    from geomstats.geometry.invariant_metric import InvariantMetric
    from geomstats.geometry.special_orthogonal import SpecialOrthogonal

    rng = np.random.default_rng(6)
    ours, stock = SpecialOrthogonal(3, equip=False), SpecialOrthogonal(3, equip=False)
    for space, metric in ((ours, SO3InvariantMetric), (stock, InvariantMetric)):
        space.equip_with_metric(metric, metric_mat_at_identity=np.diag([1.0, 2.0, 0.5]), left=True)
    base_points = samples.quaternions(rng, 20_000)
    points = quat.to_matrix(quat.multiply(base_points, quat.exp(samples.gaps(rng, 20_000, 0.0, 45.0))))
    base_points = quat.to_matrix(base_points)

    def seconds_per_call(log: Callable[..., object], n: int, calls: int, repeats: int) -> float:
        pair = (points[0], base_points[0]) if n == 1 else (points[:n], base_points[:n])

        def run() -> None:
            for _ in range(calls):
                log(*pair)

        return seconds(run, repeats, time.process_time) / calls

    what = "metric.log, up to 45 deg, diag(1, 2, .5)"
    with one_core():
        for name, n in (("one pair", 1), ("a batch of 60", 60), ("a batch of 20 000", 20_000)):
            mine = seconds_per_call(ours.metric.log, n, 1000 // n + 1, repeats)
            some = min(n, n_stock)
            theirs = seconds_per_call(stock.metric.log, some, 1, 3 if n == 1 else 1) * n / some
            note = f", extrapolated from {some}" if some < n else ""
            bar, met = ("0.2 ms", mine < 0.2e-3) if n == 1 else ("", None)
            yield Line(f"{what}, {name}: processor time", bar, f"{mine * 1e3:.3g} ms", met)
            yield Line(f"{what}, {name}: stock Geomstats {theirs:.3g} s{note}", "", f"{theirs / mine:,.0f} times")


def one_pose(repeats: int) -> Iterator[Line]:
    """Call the public metric on one pose of 24 bones, array handling and all."""
    rng = np.random.default_rng(8)
    space = PoseSpace(24, equip=False)
    space.equip_with_metric(PoseMetric, parameters=samples.parameters(rng, 24, 4.0))
    base_point = space.random_point()
    tangent_vec = space.metric.from_coordinates(0.2 * rng.normal(size=space.dim), base_point)
    point = space.metric.exp(tangent_vec, base_point)
    calls: dict[str, Callable[[], object]] = {
        "log": lambda: space.metric.log(point, base_point),
        "exp": lambda: space.metric.exp(tangent_vec, base_point),
    }
    with one_core():
        for name, call in calls.items():
            mine = seconds(lambda call=call: [call() for _ in range(1000)], repeats, time.process_time) / 1000
            yield Line(f"metric.{name} of one pose of 24 bones", "0.2 ms", f"{mine * 1e3:.2g} ms", mine < 0.2e-3)


def upsampling(repeats: int) -> Iterator[Line]:
    """From keys to samples, against scipy's objects, one per joint, and the spline against the geodesics it bends."""
    rng = np.random.default_rng(7)
    keys, metric = samples.animation(rng, 300, 65, 20.0), samples.parameters(rng, 65, 10.0)
    share = np.arange(4) / 4.0
    times = (keys.times[:-1, None] + share * np.diff(keys.times)[:, None]).ravel()
    times = np.append(times, keys.times[-1])

    def scipy_slerp() -> np.ndarray:
        columns = [Slerp(keys.times, Rotation.from_quat(keys.rotations[:, b]))(times).as_quat() for b in range(65)]
        return np.stack(columns, axis=1)

    with one_core():
        theirs = seconds(scipy_slerp, repeats)
        mine, bent, plain, scipys = (
            seconds(lambda case=case: interpolate(keys, times, *case), repeats)
            for case in (
                ("geodesic", metric),
                ("geodesic-spline", metric),
                ("geodesic-spline",),
                ("rotation-spline",),
            )
        )
    what = "65 joints x 300 keys by 4"
    yield Line(f"{what}, against scipy's Slerp", f"{theirs * 1e3:.0f} ms", f"{mine * 1e3:.0f} ms", mine <= theirs)
    yield Line(f"{what}: geodesic-spline against geodesic", "2 times", f"{bent / mine:.2f} times", bent <= 2.0 * mine)
    yield Line(
        f"{what}: geodesic-spline with the identity against scipy's RotationSpline ({scipys * 1e3:.0f} ms)",
        "",
        f"{plain * 1e3:.0f} ms",
        None,
    )


def start_up() -> Iterator[Line]:
    """First interpolation in a process, beyond its imports: with nothing compiled yet, then cached."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder, "PYTHONPATH": path}
        command = [sys.executable, "-c", FIRST_CALL]
        runs = [subprocess.run(command, env=environment, capture_output=True, text=True, check=True) for _ in range(2)]
    first, second = (float(run.stdout) for run in runs)
    yield Line("first call in a fresh installation", "20 s", f"{first:.1f} s", first < 20.0)
    yield Line("second process, beyond its imports", "1 s", f"{second:.2f} s", second < 1.0)


def measure(quick: bool) -> Iterator[Line]:
    """Measure everything."""
    PoseGeodesics.between(*samples.quaternions(np.random.default_rng(0), 2, 2000, 1), samples.MetricParameters(2, 0.5))
    yield from exp_accuracy(60 if quick else 300)
    yield from log_cells(500 if quick else 5000)
    yield shortest(300 if quick else 2000)
    yield from log_speed(20_000 if quick else 100_000, 2 if quick else 3)
    yield playback_speed(3 if quick else 7)
    yield from against_stock(5 if quick else 60, 3)
    yield from one_pose(3)
    yield from upsampling(3 if quick else 7)
    yield from start_up()


def print_table(measure: Callable[[bool], Iterator[Line]], doc: str | None, argv: list[str] | None) -> int:
    """Measure, print the table, and return the exit code of a benchmark."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer problems; the figures scatter more")
    parser.add_argument("--markdown", action="store_true", help="print a Markdown table")
    arguments = parser.parse_args(argv)
    headings = ("what", "bar", "measured", "")
    lines = list(measure(arguments.quick))
    rows = [(line.what, line.bar, line.figure, line.verdict) for line in lines]
    if arguments.markdown:
        for row in (headings, ("---",) * 4, *rows):
            print("| " + " | ".join(row) + " |")
    else:
        table = Table(*headings)
        for row in rows:
            table.add_row(*row)
        Console(width=max(Console().width, 120)).print(table)
    return int(any(line.met is False for line in lines))


if __name__ == "__main__":
    sys.exit(print_table(measure, __doc__, None))
