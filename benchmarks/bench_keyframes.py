"""Keys that are chosen against equally spaced ones, on the real clips, each claim beside its bar.

    python benchmarks/bench_keyframes.py [--quick] [--markdown]

Clips are taken from ../shared/data. A line that ends in MISSED fails a bar, and then the exit code is 1. --quick leaves
out the clip of 3000 frames.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
sys.path.insert(0, str(ROOT))

from geomstats_anim import (  # noqa: E402
    Animation,
    Skeleton,
    compress,
    interpolate,
    optimal_keyframes,
    quality,
    uniform_keyframes,
)
from geomstats_anim.keyframes import coarse_to_fine  # noqa: E402
from geomstats_anim.markers import Markers, world_errors  # noqa: E402
from usd_tools.files.stages import open_stage  # noqa: E402
from usd_tools.skel.clip import read_clip  # noqa: E402
from usd_tools.skel.find import find_animations  # noqa: E402
from usd_tools.skel.resampling import animation_of  # noqa: E402

FILES = (*(f"clips/{name}.usda" for name in ("jumping", "pitching", "punching", "rolling", "sitting")),
         "usd/mayausd_HIK_Export.usda")  # fmt: skip
RATES = (0.3, 0.1, 0.05)
TOLERANCES = (0.01, 0.03)
SLERP_BARS, LEARNED_BARS, TOLERANCE_BAR = (0.85, 0.75), (0.70, 0.55), 0.6
"""Shares of uniform slerp: in every cell, and on average."""

LONG = {300: (10.0, None), 3000: (120.0, 1024.0)}
"""Frames of 70 joints: seconds and MiB that they may take."""

FEW_KEYS, FEW_SECONDS, NEAR_OPTIMUM = (20_000, 10), 120.0, 1.02
"""Frames of 70 joints and keys to choose for slerp; seconds; and the share of the exact optimum, where it is known."""

_CHILD = "--long"


class Cell(NamedTuple):
    """A clip at a rate, or at a tolerance."""

    clip: str
    at: float
    keys: str
    slerp: float
    learned: float


def load(name: str) -> Animation:
    """Read the moving animation of a file."""
    stage = open_stage(DATA / name)
    clips = (read_clip(source) for source in find_animations(stage))
    return animation_of(next(clip for clip in clips if clip.is_animated))


def at_rate(name: str, animation: Animation, rate: float) -> Cell:
    """Q_hyb of as many keys, chosen, as a share of that of equally spaced ones and slerp."""
    uniform = uniform_keyframes(animation.n_frames, rate)

    def error(keys: np.ndarray, scheme: str, metric: object = None) -> float:
        rebuilt = interpolate(animation.at_frames(keys), animation.times, scheme, metric)  # type: ignore[arg-type]
        return quality(rebuilt, animation)

    base = error(uniform, "slerp")
    chosen = error(optimal_keyframes(animation, len(uniform)), "slerp")
    found = compress([animation], [len(uniform)])
    learned = error(found.keyframes[0], found.metric.scheme, found.metric)
    return Cell(name, rate, str(len(uniform)), chosen / base, learned / base)


def at_tolerance(name: str, animation: Animation, tolerance: float, measure: str) -> Cell:
    """Fewest keys, as a share of the equally spaced ones that slerp needs; every number of those is tried."""
    markers = Markers.of_bones(animation.skeleton) if measure == "ends" else Markers.of_shell(animation)

    def largest(keys: np.ndarray) -> float:
        rebuilt = interpolate(animation.at_frames(keys), animation.times, "slerp")
        return float(world_errors(rebuilt, animation, markers).max())

    n_frames = animation.n_frames
    counts = (uniform_keyframes(n_frames, count / n_frames) for count in range(2, n_frames + 1))
    needed = len(next(keys for keys in counts if largest(keys) <= tolerance))
    slerp = len(optimal_keyframes(animation, tolerance=tolerance, markers=markers))
    ours = len(compress([animation], tolerance=tolerance, markers=markers).keyframes[0])
    return Cell(name, tolerance, f"{ours} / {slerp} / {needed} of {n_frames}", slerp / needed, ours / needed)


def make_long(n_frames: int, n_joints: int = 70) -> Animation:
    """Play a clip forwards and backwards on several copies of its skeleton, each with a delay of its own."""
    clip = load("clips/pitching.usda")
    period = 2 * clip.n_frames - 2
    frames = np.abs((np.arange(n_frames) + clip.n_frames - 1) % period - (clip.n_frames - 1))
    copies = -(-n_joints // clip.n_joints)
    old = clip.skeleton
    parents = [parent + copy * old.n_joints if parent >= 0 else -1 for copy in range(copies) for parent in old.parents]
    skeleton = Skeleton(
        tuple(f"{copy}/{joint}" for copy in range(copies) for joint in old.joints)[:n_joints],
        np.array(parents[:n_joints]),
        *(
            np.tile(array, (copies, 1))[:n_joints]
            for array in (old.rest_translations, old.rest_rotations, old.bone_ends)
        ),
    )
    turns = [clip.rotations[np.roll(frames, 17 * copy)] for copy in range(copies)]
    moves = [clip.translations[np.roll(frames, 17 * copy)] for copy in range(copies)]
    both = (np.concatenate(arrays, axis=1)[:, :n_joints] for arrays in (turns, moves))
    return Animation(skeleton, np.arange(n_frames) / 30.0, *both)


def long_run(n_frames: int) -> None:
    """Compress a long clip, in a process of its own, and print seconds and MiB."""
    animation = make_long(n_frames)
    compress([animation.at_frames(slice(0, 40))], [8])  # compiles
    for words in ({"counts": [round(0.1 * n_frames)]}, {"counts": [round(0.3 * n_frames)]}, {"tolerance": 0.03}):
        start = time.perf_counter()
        kept = compress([animation], **words)  # type: ignore[arg-type]
        seconds = time.perf_counter() - start
        mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{words}|{len(kept.keyframes[0])}|{seconds:.1f}|{mib:.0f}", flush=True)


def few_keys() -> bool:
    """Choose few keys of a long clip, and of one that is short enough for an exact choice; print both."""
    n_frames, count = FEW_KEYS
    animation = make_long(n_frames)
    optimal_keyframes(make_long(40), 5)  # compiles
    met = True
    for what, choose in (
        ("for slerp", lambda: optimal_keyframes(animation, count)),
        ("and their metric", lambda: compress([animation], [count])),
    ):
        start = time.perf_counter()
        choose()
        seconds = time.perf_counter() - start
        is_met = seconds <= FEW_SECONDS
        met &= is_met
        print(
            f"{count} of {n_frames} x 70 {what}: {seconds:.1f} s (bar {FEW_SECONDS:g} s): {verdict(is_met)}", flush=True
        )
    short, usual = make_long(300, 20), (coarse_to_fine._AFFORDABLE, coarse_to_fine._COARSE)
    coarse_to_fine._COARSE = 1.5e6  # as coarse, for its length, as a clip that takes too long
    for few in (3, 5, 10, 20):
        errors = []
        for affordable in (np.inf, 0.0):
            coarse_to_fine._AFFORDABLE = affordable
            kept = optimal_keyframes(short, few)
            errors.append(quality(interpolate(short.at_frames(kept), short.times, "slerp"), short))
        ratio = errors[1] / errors[0]
        met &= ratio <= NEAR_OPTIMUM
        print(f"{few} of 300 x 20, coarse to fine: {ratio:.4f} of the optimum: {verdict(ratio <= NEAR_OPTIMUM)}")
    coarse_to_fine._AFFORDABLE, coarse_to_fine._COARSE = usual
    return met


def verdict(met: bool) -> str:
    """Word for the last column."""
    return "ok" if met else "MISSED"


def show(title: str, cells: list[Cell], bars: tuple[tuple[float, float], ...], markdown: bool) -> bool:
    """Print cells and their averages; tell whether all bars are met."""
    header = ("clip", "at", "keys", "chosen, slerp", "chosen, learned spline", "verdict")
    rows = []
    for cell in cells:
        met = [value <= bar for value, (bar, _) in zip((cell.slerp, cell.learned), bars, strict=True)]
        rows.append(
            (cell.clip, f"{cell.at:g}", cell.keys, f"{cell.slerp:.3f}", f"{cell.learned:.3f}", verdict(all(met)))
        )
    means = [float(np.mean([getattr(cell, name) for cell in cells])) for name in ("slerp", "learned")]
    met = [mean <= bar for mean, (_, bar) in zip(means, bars, strict=True)]
    rows.append(("mean", "", "", *(f"{mean:.3f}" for mean in means), verdict(all(met))))
    if markdown:
        print(f"{title}\n\n| " + " | ".join(header) + " |\n|" + "---|" * len(header))
        print("\n".join("| " + " | ".join(row) + " |" for row in rows), flush=True)
    else:
        table = Table(*header, title=title)
        for row in rows:
            table.add_row(*row)
        Console(width=120).print(table)
    return all(row[-1] == "ok" for row in rows)


def main() -> int:
    """Measure, print, and return 1 if a bar is missed."""
    parse = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parse.add_argument("--quick", action="store_true", help="without the clip of 3000 frames")
    parse.add_argument("--markdown", action="store_true", help="print tables for the README")
    parse.add_argument(_CHILD, type=int, help=argparse.SUPPRESS)
    args = parse.parse_args()
    if args.long is not None:
        long_run(args.long)
        return 0
    clips = {Path(name).stem: load(name) for name in FILES}
    rates = [at_rate(name, clip, rate) for name, clip in clips.items() for rate in RATES]
    met = [
        show("Q_hyb of as many keys, as a share of uniform slerp's", rates, (SLERP_BARS, LEARNED_BARS), args.markdown)
    ]
    bar = (TOLERANCE_BAR, TOLERANCE_BAR)
    loose = (np.inf, np.inf)  # slerp's keys are shown for comparison
    for measure in ("ends", "shell"):
        within = [at_tolerance(name, clip, cm, measure) for name, clip in clips.items() for cm in TOLERANCES]
        title = (
            f"Keys within a tolerance in metres ({measure}), as a share of uniform slerp's: ours / slerp's / uniform"
        )
        met.append(show(title, within, (loose, bar), args.markdown))
    for n_frames, (seconds_bar, mib_bar) in LONG.items():
        if args.quick and n_frames > 300:
            continue
        out = subprocess.run(
            [sys.executable, __file__, _CHILD, str(n_frames)], capture_output=True, text=True, check=True
        ).stdout
        for line in out.splitlines():
            words, keys, seconds, mib = line.split("|")
            ok = float(seconds) <= seconds_bar and (mib_bar is None or float(mib) <= mib_bar)
            limit = f"{seconds_bar:g} s" + (f", {mib_bar:g} MiB" if mib_bar else "")
            print(
                f"{n_frames} x 70, {words}: {keys} keys, {seconds} s, {mib} MiB (bar {limit}): {verdict(ok)}",
                flush=True,
            )
            met.append(ok)
    if not args.quick:
        met.append(few_keys())
    return 0 if all(met) else 1


if __name__ == "__main__":
    sys.exit(main())
