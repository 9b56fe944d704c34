"""Measure how planted points skate in clips rebuilt from a tenth of their samples, and what it costs to keep them.

    python benchmarks/bench_contacts.py

Planted is what `find_contacts` finds in the original motion, for all schemes alike. Clips are those of ../shared/data,
without which there is only our own jump.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from bench_usd import DATA
from pxr import Usd

from geomstats_anim import SCHEMES, Animation, MetricParameters, quality, uniform_keyframes
from geomstats_anim.contacts import Plants, find_contacts, plant, skating
from geomstats_anim.interpolation.curves import Curve
from geomstats_anim.markers import joint_matrices
from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.motions.jumping import jumping
from usd_tools.example_clips.stage import make_stage
from usd_tools.from_bvh import FromBvhOptions, from_bvh
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.vertical import up_in_world
from usd_tools.upsampling.contacts import REACH

RATE = 0.1
TIMES = 25
"""Times that each computation is done; the shortest counts."""


class Result(NamedTuple):
    """Results of one clip: skates in centimetres per second, shares of a quality and of a time."""

    original: float
    slerp: float
    spline: float
    samples: float
    stored: float
    quality_samples: float
    quality_stored: float
    cost_samples: float
    cost_stored: float
    furthest_lift: float


def clip_of(path: Path) -> tuple[Animation, np.ndarray]:
    """Read the motion of a file, in the world, and which way is up there."""
    stage = Usd.Stage.Open(str(path))
    clip = read_clip(find_animations(stage)[0])
    motion = animation_of(clip)
    return replace(motion, world=clip.placements(motion.times * clip.codes_per_second)), up_in_world(clip)


def best(*works: Callable[[], object]) -> list[float]:
    """Return the least processor time of some runs of each, in turn, after one that compiles."""
    spent: list[list[float]] = [[] for _ in works]
    for _ in range(1 + TIMES):
        for work, seconds in zip(works, spent, strict=True):
            start = time.process_time()
            work()
            seconds.append(time.process_time() - start)
    return [min(seconds[1:]) for seconds in spent]


def kept(original: Animation, curve: Curve, plants: Plants, reach: float) -> tuple[Animation, Plants]:
    """Rebuild a clip by a curve through keys, and keep points planted."""
    times = np.union1d(original.times, plants.probes())
    dense = replace(curve(times), world=worlds(original, times))
    metric = MetricParameters.identity(dense.n_joints)
    planted = plant(dense, curve.animation, plants, metric, reach, wanted=np.isin(times, original.times))
    return planted.animation, planted.plants


def worlds(original: Animation, times: np.ndarray) -> np.ndarray | None:
    """Return where a character that stands still is, at other times."""
    return None if original.world is None else np.broadcast_to(original.world[:1], (len(times), 3, 4))


def lift(original: Animation, plants: Plants, up: np.ndarray) -> float:
    """Return how far a point rose, at most, while samples alone said that it was planted; centimetres."""
    heights, rises = joint_matrices(original)[..., 3] @ up, [0.0]
    for joint, start, end in zip(plants.joints, plants.starts, plants.ends, strict=True):
        inside = heights[(original.times >= start - 1e-6) & (original.times <= end + 1e-6), joint]
        rises.append(inside.max() - inside[[0, -1]].max())
    return 100.0 * float(max(rises))


def measured(original: Animation, up: np.ndarray) -> Result | None:
    """Rebuild a clip in all ways."""
    contacts = find_contacts(original, up)
    keys = original.at_frames(uniform_keyframes(original.n_frames, RATE))
    if not len(contacts.joints):
        return None

    def skate(motion: Animation) -> float:
        found = skating([motion], [original], [contacts])
        return float("nan") if found is None else found.skate

    def spline() -> Animation:
        return SCHEMES["geodesic-spline"](keys)(original.times)

    def by_samples() -> tuple[Animation, Plants]:
        plants = Plants.of(find_contacts(keys, up), keys).through_keys(keys)
        return kept(original, SCHEMES["geodesic-spline"](keys), plants, 0.01 * REACH)

    stored = Plants.of(contacts, original)

    def by_stored() -> tuple[Animation, Plants]:
        return kept(original, SCHEMES["geodesic-spline"](keys), stored.through_keys(keys), np.inf)

    plain, (few, plants), (all_, _) = spline(), by_samples(), by_stored()
    usual, (seconds, *costs) = quality(plain, original), best(spline, by_samples, by_stored)
    return Result(
        skate(original),
        skate(SCHEMES["slerp"](keys)(original.times)),
        skate(plain),
        skate(few),
        skate(all_),
        quality(few, original) / usual - 1.0,
        quality(all_, original) / usual - 1.0,
        costs[0] / seconds,
        costs[1] / seconds,
        lift(original, plants, up),
    )


def files(folder: Path) -> Iterator[tuple[str, list[Path]]]:
    """Name groups of clips."""
    bvh = DATA / "bvh" / "12_01_walk_pybvh.bvh"
    if bvh.exists():
        from_bvh(bvh, folder / "12_01.usdc", FromBvhOptions(scale=0.056444, skip_first=True))
        yield "12_01 walk, 120 per second", [folder / "12_01.usdc"]
    library = DATA / "library"
    for name, pattern in (
        ("02_01 walk", "02/02_01.usdc"),
        ("02_02 walk", "02/02_02.usdc"),
        ("02_03 run", "02/02_03.usdc"),
        ("02_04 jump, balance", "02/02_04.usdc"),
        ("01_01 forward jumps", "01/01_01.usdc"),
        ("walks in 14 styles", "bandai/walk_*.usdc"),
        ("runs in 14 styles", "bandai/run_*.usdc"),
    ):
        found = sorted(library.glob(pattern))
        if found:
            yield name, found
    if (DATA / "clips").is_dir():
        yield "pitching", [DATA / "clips" / "pitching.usda"]
    make_stage(jumping(), build_skin()).Export(str(folder / "jumping.usda"))
    yield "our own jump", [folder / "jumping.usda"]


def main() -> int:
    """Print a table of means."""
    print("clips | original | slerp | spline | samples | stored | of slerp | Q | Q stored | cost | cost stored | lift")
    with tempfile.TemporaryDirectory() as folder:
        for name, paths in files(Path(folder)):
            results = [each for each in (measured(*clip_of(path)) for path in paths) if each is not None]
            mean = Result(*np.mean(results, axis=0))
            print(
                f"{name} | {mean.original:.1f} | {mean.slerp:.1f} | {mean.spline:.1f} | {mean.samples:.1f} | "
                f"{mean.stored:.1f} | {mean.stored / mean.slerp:.2f} | {100 * mean.quality_samples:+.1f} % | "
                f"{100 * mean.quality_stored:+.1f} % | {mean.cost_samples:.1f} | {mean.cost_stored:.1f} | "
                f"{max(each.furthest_lift for each in results):.1f} cm",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
