"""In-betweens learned from a library of clips, on clips that it has not seen: errors beside those of the best scheme.

    python benchmarks/bench_library.py [--quick] [--markdown]

Reads the clips of ../shared/data/library. Errors are against the originals, with their translations: mean angles of
joints / mean distances of bone ends. They are divided by those of the best of slerp, squad, rotation-spline and
geodesic-spline in that cell (that of the least mean ratio over the clips), or by those of geodesic-spline; what is
printed is the mean over clips of that ratio, and in brackets the ratio of the means over clips. Known actions: walks,
runs and dashes of five styles, by a library of those of the other nine, and by libraries of 30 and of 10 of its clips,
of which five are drawn each. Unseen actions: whole actions left out in turn.
Lines that end in MISSED fail their bar, and then the exit code is 1. Times are of one core, the least of several.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from bench_geodesics import Line, one_core, print_table, seconds

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from geomstats_anim import Animation, MotionLibrary, interpolate, learn_library, uniform_keyframes  # noqa: E402
from geomstats_anim.criteria import rotation_errors  # noqa: E402
from geomstats_anim.interpolation.learned_scheme import Learned  # noqa: E402
from geomstats_anim.kinematics import place  # noqa: E402
from geomstats_anim.learning.library.storage import dump_library  # noqa: E402
from usd_tools.console.errors import Messages  # noqa: E402
from usd_tools.learning.files import collect_training_clips  # noqa: E402

DATA = ROOT.parent / "shared" / "data" / "library"
FREE = ("slerp", "squad", "rotation-spline", "geodesic-spline")
RATES = (0.3, 0.2, 0.1)
GAPS = (3, 4, 5, 6, 7, 8, 10, 20)
"""Those that these rates and the self-check at twice the gap need."""

DRAWS = 5
STYLES = ("angry", "childish", "giant", "musical", "old")
KNOWN = {"rotation": (0.90, 0.84, 0.83), "bone ends": (0.92, 0.80, 0.78)}
ACTIONS = {"walks": ("walk", "walk-left", "walk-right"), "runs and dashes": ("run", "dash"), "bow": ("bow",)}
ACTIONS["guide"] = ("guide",)

Clips = Mapping[str, Animation]


def read(folder: str) -> dict[str, Animation]:
    """Read the clips of one rig by their names."""
    clips, _ = collect_training_clips(sorted((DATA / folder).glob("*.usdc")), (), False, Messages(None))
    return {clip.file.removesuffix(".usdc"): clip.stretches[0] for clip in clips}


def errors(rebuilt: Animation, original: Animation) -> tuple[float, float]:
    """Return the mean angle and the mean distance of bone ends; translations are the original's."""
    ends = [place(original.skeleton, each.rotations, original.translations).ends for each in (rebuilt, original)]
    return float(rotation_errors(rebuilt, original).mean()), float(np.linalg.norm(ends[0] - ends[1], axis=-1).mean())


def keys_of(clip: Animation, rate: float) -> Animation:
    """Take uniform keys."""
    return clip.at_frames(uniform_keyframes(clip.n_frames, rate))


def free_errors(clips: Sequence[Animation], rate: float, schemes: Sequence[str] = FREE) -> np.ndarray:
    """Return the errors of schemes without training, shape=[schemes, clips, 2]."""
    return np.array(
        [[errors(interpolate(keys_of(clip, rate), clip.times, scheme), clip) for clip in clips] for scheme in schemes]
    )


def learned_errors(library: MotionLibrary, clips: Sequence[Animation], rate: float) -> np.ndarray:
    """Return the errors of a library, shape=[clips, 2]."""
    return np.array([errors(Learned(keys_of(clip, rate), None, library)(clip.times), clip) for clip in clips])


def best_free(free: np.ndarray) -> np.ndarray:
    """Return the errors of the scheme that is best over all clips, by angle and by bone ends, shape=[clips, 2]."""
    best = (free / free[-1]).mean(axis=1).argmin(axis=0)
    return np.stack([free[scheme, :, column] for column, scheme in enumerate(best)], axis=-1)


def ratios(found: np.ndarray, of: np.ndarray) -> tuple[np.ndarray, str]:
    """Return the mean over clips of the ratio of errors, and it in words, beside the ratio of means."""
    mean = (found / of).mean(axis=0)
    return mean, f"{pair(mean)} ({pair(found.mean(axis=0) / of.mean(axis=0))})"


def pair(ratio: np.ndarray) -> str:
    """Write ratios of rotation and bone ends."""
    return " / ".join(f"{value:.3f}" for value in ratio)


def known(clips: Clips, quick: bool) -> Iterator[Line]:
    """Score unseen styles of known actions, by libraries of all other clips, of thirty and of ten."""
    moving = {name: clip for name, clip in clips.items() if name.split("_")[0] not in ("bow", "guide")}
    held = [clip for name, clip in moving.items() if name.split("_")[1] in STYLES]
    held = held[::3] if quick else held
    rest = [clip for name, clip in moving.items() if name.split("_")[1] not in STYLES]
    start = time.process_time()
    library = learn_library(rest, gaps=GAPS)
    took, frames = (time.process_time() - start) / len(GAPS), sum(clip.n_frames for clip in rest)
    bests, whole = [], []
    for i, rate in enumerate(RATES):
        free = free_errors(held, rate)
        bests.append(best_free(free))
        found = learned_errors(library, held, rate)
        ratio, words = ratios(found, bests[-1])
        whole.append(1.0 - ratio)
        bars = [KNOWN[kind][i] for kind in KNOWN]
        met = bool((ratio <= bars).all())
        yield Line(f"known actions, rate {rate:g}, {len(rest)} clips", pair(np.array(bars)), words, met)
        yield Line("... worst clip, to geodesic-spline", "", pair((found / free[-1]).max(axis=0)))
    for n, share in ((30, 0.9), (10, 0.5)):
        kept = np.array([drawn_gain(rest, n, seed, held, bests) for seed in range(DRAWS)]) / np.mean(whole, axis=0)
        words = f"{pair(kept.mean(axis=0))} ({pair(kept.min(axis=0))} to {pair(kept.max(axis=0))})"
        met = bool((kept.mean(axis=0) >= share).all())
        yield Line(f"... share of the gain that {n} clips bring, of {DRAWS} draws", f"{share:g}", words, met)
    per_6000 = took * 6000 / frames
    yield Line(
        f"learning, processor seconds for each gap, {frames} frames", "2 for 6000", f"{took:.2f}", per_6000 <= 2.0
    )
    size = len(dump_library(library)) / len(GAPS) / 1e6
    yield Line("size for each gap", "1 MB", f"{size:.2f} MB", size <= 1.0)
    yield from speed(library, max(held, key=lambda clip: clip.n_frames))


def drawn_gain(
    clips: Sequence[Animation], n: int, seed: int, held: Sequence[Animation], bests: Sequence[np.ndarray]
) -> np.ndarray:
    """Return the mean gain of a library of n clips that are drawn, over rates, shape=[2]."""
    drawn = np.random.default_rng(seed).permutation(len(clips))[:n]
    library = learn_library([clips[i] for i in drawn], gaps=GAPS)
    found = [learned_errors(library, held, rate) for rate in RATES]
    return np.mean([1.0 - ratios(each, best)[0] for each, best in zip(found, bests, strict=True)], axis=0)


def speed(library: MotionLibrary, clip: Animation) -> Iterator[Line]:
    """Time the scheme with its self-check, beside the plain spline."""
    keys = keys_of(clip, 0.1)
    times = np.linspace(clip.times[0], clip.times[-1], 10 * clip.n_frames)
    with one_core():
        for words, at in (("30", clip.times), ("300", times)):
            took = [
                seconds(lambda library=each, at=at: Learned(keys, None, library)(at, order=0), 20, time.process_time)
                for each in (library, None)
            ]
            yield Line(
                f"a clip of {clip.n_frames} frames at {words} per second, self-check included, to the spline",
                "3",
                f"{took[0] / took[1]:.2f}",
                took[0] <= 3.0 * took[1],
            )
        curve = Learned(keys, None, library)
        rate = len(times) * clip.n_joints / seconds(lambda: curve(times, order=0), 20, time.process_time)
        yield Line("rotations per second", "1 000 000", f"{rate:,.0f}".replace(",", " "), rate >= 1e6)


def unseen(name: str, rest: Sequence[Animation], held: Sequence[Animation]) -> Iterator[Line]:
    """Score an action that the library does not know, beside geodesic-spline."""
    library = learn_library(rest, gaps=GAPS)
    for rate in RATES:
        plain = free_errors(held, rate, ("geodesic-spline",))[0]
        found = learned_errors(library, held, rate)
        yield against_spline(name, rate, found, plain)


def against_spline(name: str, rate: float, found: np.ndarray, plain: np.ndarray) -> Line:
    """Say whether an action that the library does not know is harmed."""
    (ratio, words), worst = ratios(found, plain), (found / plain).max(axis=0)
    met = bool((ratio <= 1.01).all() and (worst <= 1.06).all())
    return Line(f"unseen: {name}, rate {rate:g}; worst clip", "1.01; 1.06", f"{words}; {pair(worst)}", met)


def left_out(name: str, clips: Clips, rates: Sequence[float], quick: bool) -> Iterator[Line]:
    """Score every clip by a library of the others."""
    libraries = {
        held: learn_library([clip for other, clip in clips.items() if other != held], gaps=GAPS)
        for held in (list(clips)[::4] if quick else clips)
    }
    for rate in rates:
        free = free_errors([clips[held] for held in libraries], rate)
        found = np.array([learned_errors(library, [clips[held]], rate)[0] for held, library in libraries.items()])
        if name == "01":
            ratio, words = ratios(found, best_free(free))
            yield Line(f"{name}, leave one clip out, rate {rate:g}", "0.95", words, bool(ratio[0] <= 0.95))
        else:
            yield against_spline(name, rate, found, free[-1])


def measure(quick: bool) -> Iterator[Line]:
    """Measure everything."""
    bandai = read("bandai")
    yield from known(bandai, quick)
    for name, words in ACTIONS.items():
        rest = [clip for clip_name, clip in bandai.items() if clip_name.split("_")[0] not in words]
        held = [clip for clip_name, clip in bandai.items() if clip_name.split("_")[0] in words]
        yield from unseen(name, rest, held[::3] if quick else held)
    yield from left_out("02", read("02"), RATES, quick)
    yield from left_out("01", read("01"), (0.1,), quick)


if __name__ == "__main__":
    sys.exit(print_table(measure, __doc__, None))
