"""Bytes of packed animation beside those of ACL, errors, and speeds, each beside its bar.

    python benchmarks/bench_pack.py [--clips NAME ...] [--fine] [--long] [--markdown]

Clips are taken from ../shared/data. A line that ends in MISSED fails a bar, and then the exit code is 1. Bytes are
those of the stream and the 128 that usdc adds for the attribute that carries it. Nothing of ACL is run: its bytes are
constants.
ACL decodes single poses in place in nanoseconds; this unpacks a clip in milliseconds.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pxr import Usd

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
sys.path.insert(0, str(ROOT))

from geomstats_anim import Animation  # noqa: E402
from geomstats_anim.codec import pack, unpack  # noqa: E402
from geomstats_anim.markers import Markers, world_errors  # noqa: E402
from usd_tools.bvh.options import FromBvhOptions  # noqa: E402
from usd_tools.comparison.acl import acl_bytes  # noqa: E402
from usd_tools.from_bvh import from_bvh  # noqa: E402
from usd_tools.skel.clip import read_clip  # noqa: E402
from usd_tools.skel.find import find_animations  # noqa: E402
from usd_tools.skel.resampling import animation_of  # noqa: E402

CENTIMETRES = (0.1, 1.0, 3.0)
FINE = 0.01
ATTRIBUTE = 128
BVH_SCALE = 0.056444
"""Metres per unit of the BVH files of CMU."""

FILES = {
    "sitting": "clips/sitting.usda",
    "punching": "clips/punching.usda",
    "pitching": "clips/pitching.usda",
    "jumping": "clips/jumping.usda",
    "rolling": "clips/rolling.usda",
    "hik": "usd/mayausd_HIK_Export.usda",
    "12_01": "bvh/12_01_walk_pybvh.bvh",
    "124_01": "bvh/124_01.bvh",
}

MEAN_BARS, AIMS = (0.34, 0.22, 0.17), (0.28, 0.16, 0.12)
HIK_BARS, CLIP_BARS = (0.65, 0.58, 0.44), (0.44, 0.28, 0.22)
FAST_BAR, ENCODE_BAR, DECODE_BAR = 0.45, 4.0, 2e6

LONG_FRAMES, PARTS, SEGMENT = 20_000, (300, 600), 2.0
"""Frames of a long clip, of the parts of it that are packed with full effort, and seconds of its segments."""

LONG_BAR, MEMORY_BAR, GROWTH_BAR, SEGMENT_BAR = 600.0, 2.0, 2.2, 0.02
"""Seconds to pack it, GiB, time for twice the frames, seconds to unpack a segment."""


class Packed(NamedTuple):
    """One clip at one tolerance."""

    size: int
    ratio: float
    largest: float
    mean: float
    encode_seconds: float
    rotations_per_second: float


def read_clips(names: list[str]) -> dict[str, Animation]:
    """Read the clips, BVH through `from_bvh`."""
    clips = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            path = DATA / FILES[name]
            if path.suffix == ".bvh":
                usd = Path(folder) / f"{name}.usdc"
                from_bvh(path, usd, FromBvhOptions(scale=BVH_SCALE))
                path = usd
            found = [read_clip(source) for source in find_animations(Usd.Stage.Open(str(path)))]
            clips[name] = animation_of(next(clip for clip in found if clip.is_animated))
    return clips


def processor_seconds(run: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Return the least processor seconds of several runs, and the result."""
    best, result = np.inf, None
    for _ in range(repeats):
        start = time.process_time()
        result = run()
        best = min(best, time.process_time() - start)
    return best, result


def bytes_of_acl(animation: Animation, centimetres: float) -> int | None:
    """Return ACL's bytes; BVH files begin with a rest pose, which ACL was not given."""
    size = acl_bytes([animation], centimetres)
    return acl_bytes([animation.at_frames(slice(1, None))], centimetres) if size is None else size


def measure(animation: Animation, acl: int | None, centimetres: float, effort: str) -> Packed:
    """Pack a clip, unpack it, and compare."""
    seconds, stream = processor_seconds(lambda: pack(animation, 0.01 * centimetres, effort=effort), 1)
    decoding, decoded = processor_seconds(lambda: unpack(stream, animation.skeleton), 9)
    errors = world_errors(decoded, animation, Markers.of_shell(animation))
    ratio = np.nan if acl is None else (len(stream) + ATTRIBUTE) / acl
    rate = animation.n_frames * animation.n_joints / decoding
    return Packed(len(stream), ratio, errors.max() * 100.0, errors.mean() * 100.0, seconds, rate)


def main() -> int:
    """Print the table, then the bars."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clips", nargs="+", choices=FILES, default=list(FILES), help="only these")
    parser.add_argument("--fine", action="store_true", help=f"also at {FINE} cm")
    parser.add_argument("--long", action="store_true", help=f"also {LONG_FRAMES} frames of hik, in segments")
    parser.add_argument("--markdown", action="store_true", help="rows for docs/benchmarks.rst")
    options = parser.parse_args()
    clips = read_clips(options.clips)
    pack(next(iter(clips.values())), 0.1)  # compiles
    columns = (FINE, *CENTIMETRES) if options.fine else CENTIMETRES
    rows: dict[str, list[Packed]] = {}
    for name, animation in clips.items():
        rows[name] = [measure(animation, bytes_of_acl(animation, at), at, "full") for at in columns]
        print_row(name, animation, rows[name], columns, options.markdown)
    fast = {name: measure(animation, bytes_of_acl(animation, 1.0), 1.0, "fast") for name, animation in clips.items()}
    lines = bars(rows, fast, len(columns) - len(CENTIMETRES))
    if options.long:
        lines += long_bars(read_clips(["hik"])["hik"])
    for line in lines:
        print(f"{line.text}: {line.figure:.4g}, bar {line.bar:g}: {'ok' if line.met else 'MISSED'}")
    return 0 if all(line.met for line in lines) else 1


class Line(NamedTuple):
    """A figure beside its bar."""

    text: str
    figure: float
    bar: float
    met: bool

    @classmethod
    def at_most(cls, text: str, figure: float, bar: float) -> Line:
        """Return a line that is met by a small figure."""
        return cls(text, figure, bar, figure <= bar)


def long_bars(animation: Animation) -> list[Line]:
    """Return the bars of a long clip, there and back again; what takes minutes is measured on parts of it."""
    there_and_back = [*range(animation.n_frames), *range(animation.n_frames - 2, 0, -1)]
    frames = np.resize(there_and_back, LONG_FRAMES)
    times, rotations, translations = np.arange(LONG_FRAMES) / 30.0, animation.rotations, animation.translations
    whole = Animation(animation.skeleton, times, rotations[frames], translations[frames])
    parts = [whole.at_frames(slice(0, n)) for n in PARTS]
    short, double = (processor_seconds(lambda part=part: pack(part, 0.01, segment=SEGMENT), 1)[0] for part in parts)
    _, stream = processor_seconds(lambda: pack(whole, 0.01, segment=SEGMENT, effort="fast"), 1)
    gigabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    some = slice(LONG_FRAMES // 2, LONG_FRAMES // 2 + round(30.0 * SEGMENT))
    decoding, _ = processor_seconds(lambda: unpack(stream, whole.skeleton, some), 9)
    name = f"{LONG_FRAMES} x {whole.n_joints} in segments of {SEGMENT:g} s"
    return [
        Line.at_most(f"s to pack {name}, from {PARTS[1]}", double * LONG_FRAMES / PARTS[1], LONG_BAR),
        Line.at_most(f"time for {PARTS[1]} frames over that for {PARTS[0]}", double / short, GROWTH_BAR),
        Line.at_most(f"GiB to pack {name}", gigabytes, MEMORY_BAR),
        Line.at_most(f"s to unpack {SEGMENT:g} s of {name}", decoding, SEGMENT_BAR),
    ]


def print_row(name: str, animation: Animation, row: list[Packed], columns: tuple[float, ...], markdown: bool) -> None:
    """Print what was measured of one clip."""
    if markdown:
        cells = [f"{each.size}, {each.ratio:.3f}" for each in row]
        print(f"   {name}, {animation.n_frames} x {animation.n_joints} | " + " | ".join(cells), flush=True)
        return
    for centimetres, each in zip(columns, row, strict=True):
        print(
            f"{name:9s} {centimetres:5g} cm: {each.size:6d} bytes, {each.ratio:.3f} of ACL, "
            f"largest {each.largest:.4f} cm, mean {each.mean:.4f} cm, packed in {each.encode_seconds:.2f} s, "
            f"unpacked at {each.rotations_per_second / 1e6:.2f} million rotations per second",
            flush=True,
        )


def bars(rows: dict[str, list[Packed]], fast: dict[str, Packed], skipped: int) -> list[Line]:
    """Return every bar of the clips."""
    lines: list[Line] = []
    for i, centimetres in enumerate(CENTIMETRES):
        ratios = {name: row[skipped + i].ratio for name, row in rows.items()}
        if len(rows) == len(FILES):
            mean = float(np.mean(list(ratios.values())))
            lines.append(Line.at_most(f"mean ratio at {centimetres:g} cm (aim {AIMS[i]})", mean, MEAN_BARS[i]))
        for name, ratio in ratios.items():
            bar = HIK_BARS[i] if name == "hik" else CLIP_BARS[i]
            lines.append(Line.at_most(f"ratio of {name} at {centimetres:g} cm", ratio, bar))
    mean = float(np.mean([each.ratio for each in fast.values()]))
    lines.append(Line.at_most("mean ratio at 1 cm with effort fast", mean, FAST_BAR))
    if "pitching" in rows:
        seconds = rows["pitching"][skipped + 1].encode_seconds
        lines.append(Line.at_most("s to pack pitching at 1 cm", seconds, ENCODE_BAR))
        lines.append(Line.at_most("share of that with effort fast", fast["pitching"].encode_seconds / seconds, 0.1))
    for name, row in rows.items():
        rate = row[skipped + 1].rotations_per_second
        lines.append(Line(f"rotations per second of {name} at 1 cm", rate, DECODE_BAR, rate >= DECODE_BAR))
    return lines


if __name__ == "__main__":
    sys.exit(main())
