"""Measure how exact the verbs of a pipeline are: rates, filters, cycles, and BVH there and back.

    python benchmarks/bench_pipeline.py

Clips are made here; BVH files are taken from ../shared/data where it is there.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from bench_usd import DATA, make_clip
from pxr import Sdf, Usd

from geomstats_anim import interpolate
from geomstats_anim import rotations as quat
from usd_tools.bvh.reader import read_bvh
from usd_tools.from_bvh import from_bvh
from usd_tools.resample import ResampleOptions, resample
from usd_tools.skel.channels import Channel, write_samples
from usd_tools.skel.clip import SkelClip, read_clip
from usd_tools.skel.find import find_animations
from usd_tools.to_bvh import to_bvh
from usd_tools.upsample import UpsampleOptions, upsample

RATES = ((120, 30), (30, 24), (37.5, 60), (30000 / 1001, 30))
SHAKES = (15.0, 17.0, 29.0, 43.0, 58.0)
SHIFT = 11
"""Samples by which a cycle is begun later."""


def fresh(folder: Path) -> Path:
    """Make a new folder, for OpenUSD keeps files that are open."""
    return Path(tempfile.mkdtemp(dir=folder))


def clip_of(path: Path) -> tuple[Usd.Stage, SkelClip]:
    """Read the animation of a file, with the stage that keeps it alive."""
    stage = Usd.Stage.Open(str(path))
    return stage, read_clip(find_animations(stage)[0])


def turns_of(path: Path) -> np.ndarray:
    """Return the rotations of a file, unit, shape=[F, B, 4]."""
    return quat.normalize(clip_of(path)[1].channels["rotations"].values.astype(np.float64))


def write_turns(path: Path, turns: np.ndarray, rate: float) -> None:
    """Put other rotations into a clip of `make_clip`, translations at rest, at a rate."""
    make_clip(path, len(turns), turns.shape[1])
    layer = Sdf.Layer.FindOrOpen(str(path))
    values = turns.astype(np.float32)
    codes, free = np.arange(len(turns), dtype=float), np.zeros(len(turns), dtype=bool)
    spec = layer.GetAttributeAtPath(Sdf.Path("/Rig/Animation.rotations"))
    write_samples(spec, Channel("rotations", codes, values, free, values[0], ""))
    layer.timeCodesPerSecond = layer.framesPerSecond = rate
    layer.Save()


def swinging(seconds: np.ndarray, hertz: float) -> np.ndarray:
    """Return the turns of five joints that swing with a rate and its double, shape=[F, 5, 4]."""
    angle = 2.0 * np.pi * hertz * seconds[:, None]
    waves = [0.8 * np.sin(angle + k) + 0.3 * np.cos(2.0 * angle - k) for k in range(15)]
    return quat.exp(np.stack(waves, axis=-1).reshape(len(seconds), 5, 3))


def rates(folder: Path) -> Iterator[tuple[str, str]]:
    """Compare resampled files with the curve through the source."""
    for own, fps in RATES:
        folder = fresh(folder)
        write_turns(folder / "in.usdc", swinging(np.arange(400) / own, 1.0), own)
        resample(folder / "in.usdc", folder / "out.usdc", ResampleOptions(fps=fps, retime=True))
        _, clip = clip_of(folder / "in.usdc")
        keys = clip.keys(("rotations",), slice(None))
        found = turns_of(folder / "out.usdc")
        expected = interpolate(keys, np.minimum(np.arange(len(found)) / fps, keys.times[-1])).rotations
        error = quat.distance(found, expected[:, clip.columns]).max()
        yield f"resample {own:.4g} to {fps:g}: off the curve through the source", f"{error:.1e} rad"


def filters(folder: Path) -> Iterator[tuple[str, str]]:
    """Shake a slow motion, and measure what is left of that at 30 samples per second."""
    seconds = np.arange(1201) / 120
    slow = swinging(seconds, 0.4)
    for hertz in SHAKES:
        shake = quat.exp(0.05 * np.sin(2.0 * np.pi * hertz * seconds + 0.7)[:, None, None] * [[0.6, 0.0, 0.8]])
        left = []
        folder = fresh(folder)
        write_turns(folder / "in.usdc", quat.multiply(slow, shake), 120)
        for antialias in (False, True):
            resample(folder / "in.usdc", folder / "out.usdc", ResampleOptions(fps=30, antialias=antialias))
            error = quat.distance(turns_of(folder / "out.usdc"), slow[::4])[10:-10]
            left.append(20.0 * np.log10(np.sqrt((error**2).mean()) / (0.05 / np.sqrt(2.0))))
        yield f"120 to 30, shaken at {hertz:g} Hz: left of it; with --antialias", f"{left[0]:.0f}; {left[1]:.0f} dB"


def cycles(folder: Path) -> Iterator[tuple[str, str]]:
    """Upsample a cycle from two phases on, with and without --loop."""
    for loop in (False, True):
        dense = []
        for shift in (0, SHIFT):
            folder = fresh(folder)
            write_turns(folder / "in.usdc", swinging((np.arange(31) + shift) / 30.0, 1.0), 30)
            upsample(folder / "in.usdc", folder / "out.usdc", UpsampleOptions(factor=4, loop=loop))
            dense.append(turns_of(folder / "out.usdc")[:-1])
        error = quat.distance(np.roll(dense[0], -4 * SHIFT, axis=0), dense[1]).max()
        yield f"upsample{' --loop' * loop}: a cycle from another phase on differs by", f"{error:.1e} rad"


def there_and_back(folder: Path) -> Iterator[tuple[str, str]]:
    """Convert BVH files to USD and back."""
    for source in sorted((DATA / "bvh").glob("*.bvh")):
        folder = fresh(folder)
        from_bvh(source, folder / "there.usdc")
        to_bvh(folder / "there.usdc", folder / "back.bvh")
        first, second = read_bvh(source), read_bvh(folder / "back.bvh")
        error = quat.distance(first.rotations, second.rotations).max()
        same = "the same channels" if first.channels == second.channels else "OTHER CHANNELS"
        yield f"from_bvh and to_bvh {source.name}", f"{error:.1e} rad, {same}"


def main() -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    table = Table("what", "measured", title="verbs of a pipeline")
    with tempfile.TemporaryDirectory() as name:
        for part in (rates, filters, cycles, there_and_back):
            for row in part(Path(name)):
                table.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 120).print(table)


if __name__ == "__main__":
    main()
