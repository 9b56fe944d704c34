"""Errors between the samples of packed motion, of the curves that lead through them and of the wavelets themselves.

    python benchmarks/bench_between_samples.py

Motion capture at 120 frames per second is packed at every fourth frame, and compared at the others. The wavelets are
continued by their own synthesis: samples are the scaling coefficients of finer ones whose wavelets are all zero. Clips
are taken from ../shared/data.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pxr import Usd

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data" / "bvh"
sys.path.insert(0, str(ROOT))

from geomstats_anim import Animation, interpolate  # noqa: E402
from geomstats_anim.codec import pack, unpack  # noqa: E402
from geomstats_anim.codec.chart import references, to_rotations, to_vectors  # noqa: E402
from geomstats_anim.codec.wavelets import Wavelets  # noqa: E402
from geomstats_anim.markers import Markers, world_errors  # noqa: E402
from geomstats_anim.rotations import Array  # noqa: E402
from usd_tools.from_bvh import FromBvhOptions, from_bvh  # noqa: E402
from usd_tools.skel.clip import read_clip  # noqa: E402
from usd_tools.skel.find import find_animations  # noqa: E402
from usd_tools.skel.resampling import animation_of  # noqa: E402

CLIPS = ("12_01_walk_pybvh", "124_01", "90_02", "131_03_bvh11")
BVH_SCALE = 0.056444
EVERY = 4
CENTIMETRES = (0.1, 1.0)
SCHEMES = ("slerp", "geodesic-spline")


def read_clips() -> Iterator[tuple[str, Animation]]:
    """Read the clips without their first frame, which is no motion, as many frames as packed ones can be between."""
    with tempfile.TemporaryDirectory() as folder:
        for name in CLIPS:
            path = Path(folder) / f"{name}.usdc"
            from_bvh(DATA / f"{name}.bvh", path, FromBvhOptions(scale=BVH_SCALE, skip_first=True))
            clip = animation_of(read_clip(find_animations(Usd.Stage.Open(str(path)))[0]))
            yield name, clip.at_frames(slice(0, (clip.n_frames - 1) // EVERY * EVERY + 1))


def finer(samples: Array) -> Array:
    """Continue samples, shape=[K, C], to EVERY times as many by the synthesis of the wavelets."""
    n_frames = EVERY * (len(samples) - 1) + 1
    coefficients = np.zeros((n_frames, samples.shape[1] + 1))
    coefficients[: len(samples), :-1], coefficients[: len(samples), -1] = samples, 1.0
    wavelets = Wavelets(n_frames)
    wavelets.sizes = wavelets.sizes[: int(np.log2(EVERY)) + 1]
    found = wavelets.synthesise(coefficients)
    return found[:, :-1] / found[:, -1:]


def by_wavelets(packed: Animation, times: Array) -> Animation:
    """Evaluate packed motion between its samples by the wavelets."""
    skeleton, n_joints = packed.skeleton, packed.n_joints
    rest = references(skeleton.rest_rotations, np.zeros(n_joints, dtype=np.intp))
    vectors = finer(to_vectors(rest, packed.rotations).reshape(packed.n_frames, -1)).reshape(len(times), -1, 3)
    moved = finer(packed.translations.reshape(packed.n_frames, -1)).reshape(len(times), -1, 3)
    return Animation(skeleton, times, to_rotations(rest, vectors), moved)


def main() -> None:
    """Print a row per clip and tolerance: mean and largest error between samples, in centimetres."""
    for name, clip in read_clips():
        between = np.arange(clip.n_frames) % EVERY != 0
        keys, markers = clip.at_frames(slice(None, None, EVERY)), Markers.of_shell(clip)
        for centimetres in CENTIMETRES:
            packed = unpack(pack(keys, 0.01 * centimetres, effort="fast"), keys.skeleton)
            curves = {scheme: interpolate(packed, clip.times, scheme) for scheme in SCHEMES}
            curves["wavelets"] = by_wavelets(packed, clip.times)
            cells = []
            for word, curve in curves.items():
                errors = 100.0 * world_errors(curve, clip, markers)[between]
                cells.append(f"{word} {errors.mean():.3f} mean, {errors.max():.2f} largest")
            print(f"{name}, within {centimetres:g} cm: {'; '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
