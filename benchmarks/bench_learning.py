"""Measure the gradient search on the real clips: gain, speed, and distance to the optimum, each beside its bar.

    python benchmarks/bench_learning.py [--quick]

Clips are taken from ../shared/data/clips. A cell that ends in MISSED fails a bar, and then the exit code is 1. Times
are warm.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import minimize

ROOT = Path(__file__).resolve().parents[1]
CLIPS = ROOT.parent / "shared" / "data" / "clips"
RATES = (0.3, 0.1)
KINDS = ("hyb", "rot")
sys.path.insert(0, str(ROOT))

from geomstats_anim import (  # noqa: E402
    Animation,
    MetricParameters,
    Skeleton,
    interpolate,
    learn_metric,
    uniform_keyframes,
)
from geomstats_anim import rotations as quat  # noqa: E402
from geomstats_anim.learning.descent import BOUND  # noqa: E402
from geomstats_anim.learning.gradient import search_gradient  # noqa: E402
from geomstats_anim.learning.learnable import Found  # noqa: E402
from geomstats_anim.learning.objective import Objective  # noqa: E402
from geomstats_anim.parameters import CurveParameters  # noqa: E402

OPTIMUM_BAR = 1.005
SECONDS_BAR = 2.0
MILLISECONDS_BAR = 10.0
CORPUS_CLIPS, CORPUS_FRAMES, CORPUS_BAR = 20, 300, 60.0


def read(path: Path) -> Animation:
    """Read the first animation of a file."""
    from usd_tools.files.stages import open_stage
    from usd_tools.skel.clip import read_clip
    from usd_tools.skel.find import find_animations
    from usd_tools.skel.resampling import animation_of

    stage = open_stage(path)
    return animation_of(read_clip(find_animations(stage)[0]))


def seconds(run: Callable[[], object], repeats: int) -> float:
    """Least time of a few calls: the one that others disturbed least."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def optimum_of_rotation(animation: Animation, keys: np.ndarray) -> float:
    """Least Q_rot of a diagonal metric with a side a joint: a grid of 9 x 9 and Nelder-Mead, joint by joint."""
    n_joints = animation.n_joints
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-BOUND, BOUND, 9)]), axis=-1).reshape(-1, 2)
    whole = Objective(animation, keys, "rot")
    best = whole.rotation_errors_by_joint(CurveParameters.plain("geodesic", n_joints))
    for side in ("left", "right"):
        errors = np.array(
            [
                whole.rotation_errors_by_joint(
                    CurveParameters.geodesic(MetricParameters(*np.exp(np.tile(point[:, None], n_joints)), None, side))
                )
                for point in grid
            ]
        )
        for joint in range(n_joints):
            alone = Objective(only_joint(animation, joint), keys, "rot")

            def value(point: np.ndarray, alone: Objective = alone, side: str = side) -> float:
                return alone.value(CurveParameters.geodesic(MetricParameters(*np.exp(point), None, side)))

            result = minimize(
                value,
                grid[errors[:, joint].argmin()],
                method="Nelder-Mead",
                bounds=[(-BOUND, BOUND)] * 2,
                options={"xatol": 1e-3, "fatol": 1e-4 * max(best[joint], 1e-9)},
            )
            best[joint] = min(best[joint], result.fun)
    return float(best.sum())


def only_joint(animation: Animation, joint: int) -> Animation:
    """Keep one joint of an animation, with nothing above it."""
    skeleton = Skeleton(["joint"], [-1], np.zeros((1, 3)), [quat.IDENTITY])
    still = np.zeros((animation.n_frames, 1, 3))
    return replace(
        animation, skeleton=skeleton, rotations=animation.rotations[:, [joint]], translations=still, scales=None
    )


class Line(NamedTuple):
    """A measured figure, its bar, and whether it is met (None: no bar)."""

    what: str
    bar: str
    figure: str
    met: bool | None = None

    @property
    def verdict(self) -> str:
        """Word for the last column."""
        return "" if self.met is None else "ok" if self.met else "MISSED"


class Cell(NamedTuple):
    """A clip at a rate, in one kind of quality."""

    name: str
    rate: float
    kind: str
    slerp: float
    diagonal: Found
    spd: Found
    seconds: tuple[float, float]
    optimum: float | None

    @property
    def lines(self) -> list[Line]:
        """The bars that hold for it."""
        where = f"{self.name} {self.rate:g} {self.kind}"
        spd = self.spd.value / self.diagonal.value if self.diagonal.value else 1.0
        lines = [Line(f"{where}: spd against diagonal", "at most 1", f"{spd:.5f}", spd <= 1.0)]
        lines.append(Line(f"{where}: slerp", "no better", f"{self.slerp:.5g}", self.diagonal.value <= self.slerp))
        if self.optimum is not None:
            ratio = self.diagonal.value / self.optimum
            what = f"{where}: diagonal against grid and Nelder-Mead, joint by joint"
            lines.append(Line(what, f"{OPTIMUM_BAR:g}", f"{ratio:.5f}", ratio <= OPTIMUM_BAR))
        if (self.name, self.rate, self.kind) == ("pitching", 0.3, "hyb"):
            figure = self.seconds[0]
            lines.append(Line(f"{where}: diagonal", f"{SECONDS_BAR:g} s", f"{figure:.2f} s", figure < SECONDS_BAR))
        return lines

    @property
    def row(self) -> list[str]:
        """Row of the table."""
        figures = [f"{self.slerp:.5g}"]
        for found, taken in zip((self.diagonal, self.spd), self.seconds, strict=True):
            figures += [f"{found.value:.5g}", f"{found.value / self.slerp:.4f}", f"{taken:.2f}"]
        optimum = "" if self.optimum is None else f"{self.diagonal.value / self.optimum:.4f}"
        verdict = "ok" if all(line.met for line in self.lines) else "MISSED"
        return [self.name, f"{self.rate:g}", self.kind, *figures, optimum, verdict]


def measure(name: str, animation: Animation, rate: float, kind: str, with_optimum: bool) -> Cell:
    """Learn one cell."""
    keys = uniform_keyframes(animation.n_frames, rate)
    objective = Objective(animation, keys, kind)
    slerp = objective.value(CurveParameters.plain("geodesic", animation.n_joints))
    found, taken = [], []
    for family in ("diagonal", "spd"):
        start = time.perf_counter()
        found.append(search_gradient(objective, animation.n_joints, family))
        taken.append(time.perf_counter() - start)
    optimum = optimum_of_rotation(animation, keys) if with_optimum and kind == "rot" else None
    return Cell(name, rate, kind, slerp, *found, (taken[0], taken[1]), optimum)


def value_speed(animation: Animation, repeats: int) -> list[Line]:
    """One evaluation, at a metric that is not the identity."""
    objective = Objective(animation, uniform_keyframes(animation.n_frames, 0.3))
    n = animation.n_joints
    metric = MetricParameters(np.full(n, 2.0), np.full(n, 0.7), None, tuple(("left", "right") * n)[:n])
    curve = CurveParameters.geodesic(metric)
    lines = []
    runs = (("value", objective.value, True), ("value and gradient", objective.value_and_gradient, False))
    for what, run, has_bar in runs:
        taken = 1e3 * seconds(lambda run=run: run(curve), repeats)
        what = f"{what}, {n} joints x {animation.n_frames} frames"
        bar, met = (f"{MILLISECONDS_BAR:g} ms", taken < MILLISECONDS_BAR) if has_bar else ("", None)
        lines.append(Line(what, bar, f"{taken:.1f} ms", met))
    return lines


def corpus_speed(animation: Animation) -> Line:
    """One metric from many clips of one rig: a real clip from ever later starts, at a rate that fills the frames."""
    first, last = animation.times[[0, -1]]
    starts = np.linspace(first, 0.5 * (first + last), CORPUS_CLIPS)
    clips = [interpolate(animation, np.linspace(start, last, CORPUS_FRAMES), "slerp") for start in starts]
    keys = [uniform_keyframes(clip.n_frames, 0.1) for clip in clips]
    taken = seconds(lambda: learn_metric(clips, keys, scheme="geodesic"), 1)
    what = f"corpus of {CORPUS_CLIPS} clips x {CORPUS_FRAMES} frames x {animation.n_joints} joints"
    return Line(what, f"{CORPUS_BAR:g} s", f"{taken:.1f} s", taken < CORPUS_BAR)


def main(argv: list[str] | None = None) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="only pitching and sitting, and the optimum of sitting")
    arguments = parser.parse_args(argv)
    names = ("pitching", "sitting") if arguments.quick else ("jumping", "pitching", "punching", "rolling", "sitting")
    paths = [path for name in names if (path := CLIPS / f"{name}.usda").is_file()]
    if not paths:
        print(f"Nothing to measure: there are no clips in {CLIPS}.")
        return 0
    console = Console(width=max(Console().width, 120))
    clips = {path.stem: read(path) for path in paths}
    warm_up = next(iter(clips.values())).at_frames(slice(0, 20))
    search_gradient(Objective(warm_up, uniform_keyframes(20, 0.3)), warm_up.n_joints, "spd")

    lines = value_speed(clips["pitching"], 10) if "pitching" in clips else []
    if "pitching" in clips and not arguments.quick:
        lines.append(corpus_speed(clips["pitching"]))
    columns = ["clip", "rate", "Q", "slerp", "diagonal", "/ slerp", "s", "spd", "/ slerp", "s", "/ optimum", ""]
    table = Table(*columns, title="Gradient search, sides by joint")
    for name, animation in clips.items():
        for rate in RATES:
            for kind in KINDS:
                cell = measure(name, animation, rate, kind, not arguments.quick or name == "sitting")
                table.add_row(*cell.row)
                lines += cell.lines
                if console.is_terminal:
                    print(".", end="", file=sys.stderr, flush=True)
    console.print(table)
    bars = Table("what", "bar", "measured", "")
    for line in lines:
        bars.add_row(line.what, line.bar, line.figure, line.verdict)
    console.print(bars)
    return int(any(line.met is False for line in lines))


if __name__ == "__main__":
    sys.exit(main())
