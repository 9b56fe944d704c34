"""Time and memory of whole `usd_tools` commands, each in a process of its own.

    python benchmarks/bench_usd.py

Real clips are taken from ../shared/data where it is there; the long clip is made here.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
IMPORTS = ["-c", "import geomstats_anim; from pxr import Usd, UsdGeom, UsdSkel, UsdUtils"]


class Used(NamedTuple):
    """Cost of a run: seconds on the clock, seconds of all processors, and MiB at most."""

    seconds: float
    processor_seconds: float
    mib: float


def run_python(arguments: list[str]) -> Used:
    """Run Python in a process of its own."""
    start = time.perf_counter()
    process = subprocess.Popen([sys.executable, *arguments], cwd=ROOT, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(arguments)} ended with exit code {process.returncode}.")
    return Used(time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0)


def measure(arguments: list[str], runs: int = 5) -> tuple[float, float]:
    """Processor seconds of the fastest of some runs of Python, and the largest memory of any, in MiB."""
    used = [run_python(arguments) for _ in range(runs)]
    return min(each.processor_seconds for each in used), max(each.mib for each in used)


def make_clip(path: Path, n_frames: int, n_joints: int, seed: int = 0) -> None:
    """Write a clip in which every joint swings smoothly about a changing axis, 30 samples a second."""
    import numpy as np
    from pxr import Sdf, Usd, UsdSkel, Vt
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    phase, speed = rng.uniform(0.0, 2.0 * np.pi, (2, 1, n_joints, 3))
    seconds = np.arange(n_frames)[:, None, None] / 30.0
    turns = Rotation.from_rotvec(0.8 * np.sin(speed * seconds + phase).reshape(-1, 3))
    rotations = turns.as_quat().reshape(n_frames, n_joints, 4).astype(np.float32)
    translations = np.tile(np.float32([0.0, 0.1, 0.0]), (n_frames, n_joints, 1))
    translations[:, 0, 0] = np.linspace(0.0, 10.0, n_frames)

    stage = Usd.Stage.CreateNew(str(path))
    stage.SetTimeCodesPerSecond(30.0)
    root = UsdSkel.Root.Define(stage, "/Rig")
    stage.SetDefaultPrim(root.GetPrim())
    skeleton = UsdSkel.Skeleton.Define(stage, "/Rig/Skeleton")
    animation = UsdSkel.Animation.Define(stage, "/Rig/Animation")
    joints = ["j0"]
    for joint in range(1, n_joints):
        joints.append(f"{joints[max(0, joint - 1 - joint % 4)]}/j{joint}")
    rest = Vt.Matrix4dArray.FromNumpy(np.tile(np.eye(4), (n_joints, 1, 1)))
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateRestTransformsAttr(rest)
    skeleton.CreateBindTransformsAttr(rest)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    animation.CreateJointsAttr(joints)
    animation.CreateScalesAttr(Vt.Vec3hArray.FromNumpy(np.ones((n_joints, 3), dtype=np.float16)))
    layer, paths = stage.GetRootLayer(), (animation.CreateRotationsAttr(), animation.CreateTranslationsAttr())
    with Sdf.ChangeBlock():
        for frame in range(n_frames):
            layer.SetTimeSample(paths[0].GetPath(), float(frame), Vt.QuatfArray.FromNumpy(rotations[frame]))
            layer.SetTimeSample(paths[1].GetPath(), float(frame), Vt.Vec3fArray.FromNumpy(translations[frame]))
    layer.Save()


def make_elsewhere(path: Path, n_frames: int, n_joints: int) -> None:
    """Call `make_clip` in another process: Linux counts the memory of a process at the birth of its children too."""
    process = multiprocessing.get_context("spawn").Process(target=make_clip, args=(path, n_frames, n_joints))
    process.start()
    process.join()


def main() -> None:
    """Print the table."""
    from rich.console import Console
    from rich.table import Table

    table = Table("command", "joints", "samples", "processor seconds", "beyond imports", "peak MiB", title="usd_tools")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        long_clip, wide_clip = folder / "long.usdc", folder / "wide.usdc"
        make_elsewhere(long_clip, 20_000, 70)
        make_elsewhere(wide_clip, 300, 2_000)
        fight = DATA / "usd" / "mayausd_HIK_Export.usda"
        if not fight.exists():
            fight = folder / "fight.usda"
            make_elsewhere(fight, 101, 70)
        style = ["--alpha", "4", "--beta", ".5"]
        cases = [
            ("upsample --factor 4", fight, 70, "101 -> 401", ["--factor", "4"]),
            ("upsample --factor 4 --alpha 4 --beta .5", fight, 70, "101 -> 401", ["--factor", "4", *style]),
            ("upsample --factor 4 --scheme slerp", fight, 70, "101 -> 401", ["--factor", "4", "--scheme", "slerp"]),
            ("upsample --factor 2 --alpha 4 --beta .5", long_clip, 70, "20000 -> 39999", ["--factor", "2", *style]),
            ("upsample --factor 2 --alpha 4 --beta .5", wide_clip, 2000, "300 -> 599", ["--factor", "2", *style]),
        ]
        base_seconds, base_memory = measure(IMPORTS)
        table.add_row("imports alone", "", "", f"{base_seconds:.2f}", "", f"{base_memory:.0f}")
        measure(["-m", "usd_tools.upsample", str(fight), "--dry-run", *cases[1][-1]], runs=1)  # compiles, if need be
        for command, clip, n_joints, samples, options in cases:
            out = folder / f"out{clip.suffix}"
            arguments = ["-m", "usd_tools.upsample", str(clip), "-o", str(out), *options]
            seconds, memory = measure(arguments, runs=5 if clip is fight else 1)
            table.add_row(
                f"{command} {clip.name}",
                str(n_joints),
                samples,
                f"{seconds:.2f}",
                f"{seconds - base_seconds:.2f}",
                f"{memory:.0f}",
            )
        for clip, n_joints, samples in ((fight, 70, "101"), (long_clip, 70, "20000")):
            seconds, memory = measure(["-m", "usd_tools.inspect", str(clip)])
            table.add_row(
                f"inspect {clip.name}",
                str(n_joints),
                samples,
                f"{seconds:.2f}",
                f"{seconds - base_seconds:.2f}",
                f"{memory:.0f}",
            )
    Console(width=None if sys.stdout.isatty() else 120).print(table)


if __name__ == "__main__":
    main()
