"""Gradient search against the TPE searches, on real clips, and whether the bars of the project hold.

    python benchmarks/bench_tpe.py [--trials N | --full]

Clips are taken from ../shared/data/clips.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
CLIPS = ROOT.parent / "shared" / "data" / "clips"
RATES = (0.3, 0.1)
sys.path.insert(0, str(ROOT))

from geomstats_anim import Animation, uniform_keyframes  # noqa: E402
from geomstats_anim.learning.gradient import search_gradient  # noqa: E402
from geomstats_anim.learning.learnable import Found  # noqa: E402
from geomstats_anim.learning.objective import Objective  # noqa: E402
from geomstats_anim.learning.tune.ray_runtime import running  # noqa: E402
from geomstats_anim.learning.tune.settings import TuneSettings  # noqa: E402
from geomstats_anim.learning.tune.tpe import search_tpe, search_tpe_joint  # noqa: E402
from geomstats_anim.parameters import CurveParameters  # noqa: E402


def read(path: Path) -> Animation:
    """Read the first animation of a file."""
    from usd_tools.files.stages import open_stage
    from usd_tools.skel.clip import read_clip
    from usd_tools.skel.find import find_animations
    from usd_tools.skel.resampling import animation_of

    stage = open_stage(path)
    return animation_of(read_clip(find_animations(stage)[0]))


class Timed:
    """A search with a stopwatch: its end, and when it first was as good as some value."""

    def __init__(self, search: Callable[..., Found]) -> None:
        self._start = time.perf_counter()
        self._history: list[tuple[float, float]] = []
        self.found = search(progress=self._follow)
        self.seconds = time.perf_counter() - self._start

    def _follow(self, evaluations: int, value: float) -> None:
        self._history.append((time.perf_counter() - self._start, value))

    def seconds_to(self, value: float) -> float:
        """Seconds until the best was at most a value; all of them if that was only so in the end."""
        return next((seconds for seconds, best in self._history if best <= value), self.seconds)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=200, help="of tpe-joint (default: 200)")
    parser.add_argument("--full", action="store_true", help="1000 trials, as in the bars")
    parser.add_argument("--clips", nargs="*", default=["*"], help="names of clips (default: all)")
    arguments = parser.parse_args()
    trials = 1000 if arguments.full else arguments.trials
    paths = sorted(path for name in arguments.clips for path in CLIPS.glob(f"{name}.usda"))
    if not paths:
        print(f"Nothing to measure: there are no clips in {CLIPS}.")
        return 0
    columns = ["clip", "rate", "slerp", "gradient", "s", "tpe-joint", "s", "tpe", "s", "times faster", "bars"]
    table = Table(*columns, title=f"Q_hyb, diagonal, sides by joint; tpe-joint with {trials} trials")
    console = Console(width=None if sys.stdout.isatty() else 120)
    all_hold = True
    start = time.perf_counter()
    with running(cpus=1):
        console.print(f"Start of Ray: {time.perf_counter() - start:.1f} s, not in the table.")
        for path in paths:
            animation = read(path)
            joints = animation.n_joints
            for rate in RATES:
                objective = Objective(animation, uniform_keyframes(animation.n_frames, rate))
                slerp = objective.value(CurveParameters.plain("geodesic", joints))
                objective.value_and_gradient(CurveParameters.plain("geodesic", joints))  # loads the kernels
                settings = TuneSettings(trials=trials, window=0, cpus=1)

                def gradient(objective=objective, joints=joints, **given) -> Found:  # type: ignore[no-untyped-def]
                    return search_gradient(objective, joints, **given)

                def tpe_joint(objective=objective, joints=joints, settings=settings, **given) -> Found:  # type: ignore[no-untyped-def]
                    return search_tpe_joint(objective, joints, settings=settings, **given)

                def tpe(objective=objective, joints=joints, **given) -> Found:  # type: ignore[no-untyped-def]
                    return search_tpe(objective, joints, **given)

                by_gradient, by_tpe_joint, by_tpe = Timed(gradient), Timed(tpe_joint), Timed(tpe)
                faster = by_tpe_joint.seconds / by_gradient.seconds_to(by_tpe_joint.found.value)
                best = by_gradient.found.value
                bars = {
                    "no higher than tpe-joint": best <= by_tpe_joint.found.value,
                    "100 times faster": faster >= 100.0 or not arguments.full,
                    "tpe within 2 %": by_tpe.found.value <= 1.02 * best,
                    "tpe-joint 200 trials in 3 min": by_tpe_joint.seconds * 200.0 / trials < 180.0,
                }
                missed = [bar for bar, holds in bars.items() if not holds]
                all_hold &= not missed
                cells = [f"{path.stem}", f"{rate}", f"{slerp:.5f}"]
                for timed in (by_gradient, by_tpe_joint, by_tpe):
                    cells += [f"{timed.found.value:.5f}", f"{timed.seconds:.2f}"]
                table.add_row(*cells, f"{faster:.0f}", "missed: " + ", ".join(missed) if missed else "hold")
    console.print(table)
    console.print("All bars hold." if all_hold else "Some bars are missed.")
    return 0 if all_hold else 1


if __name__ == "__main__":
    sys.exit(main())
