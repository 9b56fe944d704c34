"""Damage recordings, and measure what `repair` finds, what it takes for a fault, and how well it rebuilds.

    python benchmarks/bench_repair.py

The clips are those of ../shared/data/library, else the example clips. Faults that the recordings have themselves are
left out of the count.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd

from geomstats_anim import Animation, Skeleton, interpolate
from geomstats_anim import rotations as quat
from usd_tools.repair import RepairOptions, RepairResult, repair
from usd_tools.skel.channels import Channel, write_samples
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations

LIBRARY = Path(__file__).resolve().parents[2] / "shared" / "data" / "library"
KINDS = ("spike", "gap", "drop-out of a joint", "drop-out of a limb", "drop-out of all")
SPIKES = (45.0, 180.0)
"""Degrees."""
LONGEST = {"spike": 3, "gap": 12}
"""Samples; of drop-outs half a second."""
LEAST_WRONG = 3.0
"""Degrees that a joint turns while it is held, at least: a drop-out of a joint that rests is none."""


@dataclass(frozen=True)
class Damage:
    """A fault that was made: its kind, joint, first sample and the first after it."""

    kind: str
    joint: int
    start: int
    stop: int


def rotations_of(path: Path) -> tuple[Channel, float, bool]:
    """Return the rotations of a file, its time codes per second, and whether it has cuts."""
    stage = Usd.Stage.Open(str(path))
    clip = read_clip(find_animations(stage)[0], fills_gaps=True)
    return clip.channels["rotations"], clip.codes_per_second, len(clip.cuts) > 0


def damaged(values: np.ndarray, rate: float, taken: np.ndarray, seed: int) -> tuple[np.ndarray, list[Damage]]:
    """Make faults in rotations, shape=[F, N, 4], about one in a thousand samples, away from what is taken."""
    rng, values, taken = np.random.default_rng(seed), values.copy(), taken.copy()
    unit = quat.normalize(values.astype(np.float64))
    moving = np.flatnonzero((quat.distance(unit[1:], unit[:-1]) > 1e-4).mean(axis=0) > 0.5)
    n_frames, made = len(values), []
    for kind in rng.choice(KINDS, max(6, n_frames * len(moving) // 1000)).tolist():
        length = int(rng.integers(1 if kind in LONGEST else 3, LONGEST.get(kind, max(4, int(rate / 2))) + 1))
        if n_frames < length + 12:
            continue
        start = int(rng.integers(4, n_frames - length - 5))
        count = {"drop-out of a limb": min(4, len(moving)), "drop-out of all": len(moving)}.get(kind, 1)
        joints = rng.choice(moving, count, replace=False)
        if kind.startswith("drop-out"):
            off = quat.distance(unit[start : start + length, joints], unit[start - 1 : start, joints]).max(axis=0)
            joints = joints[np.degrees(off) > LEAST_WRONG]
        if not len(joints) or taken[start - 5 : start + length + 5, joints].any():
            continue
        span = slice(start, start + length)
        if kind == "spike":
            axis = rng.normal(size=3)
            turn = quat.exp(np.radians(rng.uniform(*SPIKES)) * axis[None] / np.linalg.norm(axis))
            values[span, joints[0]] = quat.multiply(unit[span, joints[0]], np.repeat(turn, length, axis=0))
        else:
            values[span, joints] = rng.choice([np.nan, 0.0]) if kind == "gap" else values[start - 1, joints]
        taken[span, joints] = True
        made += [Damage(kind, int(joint), start, start + length) for joint in joints]
    return values, made


def mask_of(result: RepairResult, channel: Channel, joints: list[str]) -> list[tuple[int, int, int]]:
    """Return the joint, first sample and first after it of each fault that was found."""
    found = []
    for fault in result.faults:
        if fault["channel"] == "rotations" and fault["kind"] != "sign flip":
            start, end = np.searchsorted(channel.codes, [fault["start"], fault["end"]])
            found.append((joints.index(fault["joint"]), int(start), int(end) + 1))
    return found


@dataclass
class Score:
    """Results of one clip: made and found faults by kind, wrong ones, and errors in radians."""

    made: dict[str, int]
    found: dict[str, int]
    reported: int
    wrong: int
    off_spline: float
    errors: np.ndarray
    slerped: np.ndarray


def score(source: Path, folder: Path, seed: int) -> Score | None:
    """Damage a clip, repair it, and compare."""
    channel, rate, _ = rotations_of(source)
    stage = Usd.Stage.Open(str(source))
    animation = find_animations(stage)[0]
    joints = list(read_clip(animation).joints)
    own = np.zeros(channel.values.shape[:2], dtype=bool)
    for joint, start, stop in mask_of(repair(source, None, RepairOptions(dry_run=True)), channel, joints):
        own[start:stop, joint] = True
    values, made = damaged(channel.values, rate, own, seed)
    if not made:
        return None
    layer = Sdf.Layer.OpenAsAnonymous(str(source))
    write_samples(layer.GetAttributeAtPath(f"{animation.path}.rotations"), replace(channel, values=values))
    layer.Export(str(folder / "in.usdc"))
    result = repair(folder / "in.usdc", folder / "out.usdc", RepairOptions())
    bad = np.zeros_like(own)
    for each in made:
        bad[each.start : each.stop, each.joint] = True
    reported = mask_of(result, channel, joints)
    covered = np.zeros_like(own)
    for joint, start, stop in reported:
        covered[start:stop, joint] = True
    hits = [covered[each.start : each.stop, each.joint].all() for each in made]
    wrong = sum(not (bad | own)[start:stop, joint].all() for joint, start, stop in reported)
    written, _, has_cuts = rotations_of(folder / "out.usdc")
    after = quat.normalize(written.values.astype(np.float64))
    clean = quat.normalize(channel.values.astype(np.float64))
    off, errors, slerped = 0.0, [], []
    for joint in np.flatnonzero((bad & covered).any(axis=0)):
        good, wanted = ~covered[:, joint], (bad & covered)[:, joint]
        keys = quat.normalize(values[good, joint].astype(np.float64))
        curves = [through(keys, channel.codes[good], channel.codes, name) for name in (None, "slerp")]
        if not has_cuts:  # across which no spline leads
            off = max(off, quat.distance(after[wanted, joint], curves[0][wanted]).max())
        errors.append(quat.distance(after[wanted, joint], clean[wanted, joint]))
        slerped.append(quat.distance(curves[1][wanted], clean[wanted, joint]))
    return Score(
        {kind: sum(each.kind == kind for each in made) for kind in KINDS},
        {kind: sum(hit for hit, each in zip(hits, made, strict=True) if each.kind == kind) for kind in KINDS},
        len(reported),
        wrong,
        off,
        np.concatenate([[], *errors]),
        np.concatenate([[], *slerped]),
    )


def through(keys: np.ndarray, codes: np.ndarray, at: np.ndarray, scheme: str | None) -> np.ndarray:
    """Interpolate the rotations of one joint, shape=[K, 4]."""
    one = Skeleton(["joint"], [-1], np.zeros((1, 3)), [[0.0, 0.0, 0.0, 1.0]])
    animation = Animation(one, codes, keys[:, None], np.zeros((len(codes), 1, 3)))
    return interpolate(animation, at, scheme).rotations[:, 0]


def clips(folder: Path) -> Iterator[Path]:
    """Yield recordings, else the example clips."""
    if LIBRARY.is_dir():
        yield from sorted(LIBRARY.glob("*/*.usdc"))
        return
    from usd_tools.example_clips.body import build_skin
    from usd_tools.example_clips.motions import MOTIONS
    from usd_tools.example_clips.stage import make_stage

    for name, motion in MOTIONS.items():
        path = folder / f"{name}.usda"
        stage = make_stage(motion(), build_skin())
        stage.GetRootLayer().Export(str(path))
        yield path


def total(scores: list[Score]) -> list[tuple[str, str]]:
    """Return the rows of the table."""
    made = {kind: sum(each.made[kind] for each in scores) for kind in KINDS}
    found = {kind: sum(each.found[kind] for each in scores) for kind in KINDS}
    reported, wrong = sum(each.reported for each in scores), sum(each.wrong for each in scores)
    errors, slerped = np.degrees(np.concatenate([(each.errors, each.slerped) for each in scores], axis=1))
    whole = sum(found.values()) / sum(made.values())
    rows = [(f"found of {made[kind]}: {kind}", f"{found[kind] / max(1, made[kind]):.3f}") for kind in KINDS]
    return [
        *rows,
        (f"recall over {sum(made.values())} faults in {len(scores)} clips", f"{whole:.3f}"),
        ("precision", f"{1.0 - wrong / max(1, reported):.3f}"),
        ("rebuilt: farthest off the spline through all others", f"{max(each.off_spline for each in scores):.1e} rad"),
        ("rebuilt: mean error, and that of slerp", f"{errors.mean():.2f}, {slerped.mean():.2f} degrees"),
    ]


def main() -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    table = Table("what", "measured", title="repair of damaged recordings")
    with tempfile.TemporaryDirectory() as name:
        scores = []
        for seed, source in enumerate(clips(Path(name))):
            folder = Path(tempfile.mkdtemp(dir=name))  # OpenUSD keeps files that are open
            scores.append(score(source, folder, seed))
        for row in total([each for each in scores if each is not None]):
            table.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 120).print(table)


if __name__ == "__main__":
    main()
