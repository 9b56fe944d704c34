"""Times of the Blender extension, in a Blender without a window: install size, first result, re-evaluation.

    .venv-blender/bin/python benchmarks/bench_blender.py PYTHON [--markdown]

PYTHON is one that has geomstats-anim, whose kernels are compiled already. The armature has 24 bones that turn in 142
frames, of which every 10th is a key, and a hip that moves. A line that ends in MISSED fails its bar, and then the exit
code is 1. The first result is seconds on the clock, from a process that does not run to keys in the action; others are
processor time of Blender and of the process together, the least of several.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BONES, FRAMES, EVERY = 24, 142, 10
TICKS = os.sysconf("SC_CLK_TCK")


def prepare(python: str, folder: Path) -> int:
    """Build and install the extension, and return the bytes that it has on the disk."""
    os.environ["BLENDER_USER_RESOURCES"] = str(folder / "user")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    archive = folder / "extension.zip"
    subprocess.run([sys.executable, ROOT / "integrations" / "blender" / "build.py", "-o", archive], check=True)
    sys.path.insert(0, str(ROOT / "tests" / "blender"))
    from extension import install

    install(str(archive), python)
    return sum(path.stat().st_size for path in (folder / "user" / "extensions").rglob("*.py"))


def make_armature():
    """Make a chain of limbs with keys."""
    import bpy
    from mathutils import Euler

    data = bpy.data.armatures.new("Rig")
    armature = bpy.data.objects.new("Rig", data)
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for b in range(BONES):
        bone = data.edit_bones.new(f"bone{b}")
        bone.head, bone.tail = (0.0, 0.0, 0.1 * b), (0.0, 0.0, 0.1 * (b + 1))
        if b:
            bone.parent = data.edit_bones[b - 1]
    bpy.ops.object.mode_set(mode="POSE")
    rng = random.Random(0)
    for frame in [*range(1, FRAMES, EVERY), FRAMES]:
        for b, bone in enumerate(armature.pose.bones):
            bone.rotation_quaternion = Euler([rng.uniform(-1.0, 1.0) for _ in range(3)]).to_quaternion()
            bone.keyframe_insert("rotation_quaternion", frame=frame)
            if not b:
                bone.location = [rng.uniform(-0.2, 0.2) for _ in range(3)]
                bone.keyframe_insert("location", frame=frame)
            bone["geodesic_alpha"], bone["geodesic_beta"] = 2.5, 0.4
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, FRAMES
    return armature


def processor(pid: int) -> float:
    """Return the processor time of this process and of another, seconds."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return time.process_time() + (int(fields[11]) + int(fields[12])) / TICKS


def measure(armature) -> dict[str, tuple[float, float]]:
    """Return seconds and bars, by what was done."""
    import bpy
    from extension import part

    fill, service = part("fill"), part("service")
    firsts = []
    for _ in range(3):
        service.close()
        start = time.perf_counter()
        assert bpy.ops.geodesic.in_betweens() == {"FINISHED"}
        firsts.append(time.perf_counter() - start)
    pid, rounds, again = service._running.process.pid, 20, []
    for _ in range(5):
        start = processor(pid)
        for turn in range(rounds):
            armature.pose.bones[turn]["geodesic_alpha"] += 0.1
            fill.fill(armature)
        again.append((processor(pid) - start) / rounds)
    return {"first result, the process starts": (min(firsts), 3.0), "filled again": (min(again), 0.1)}


def main() -> int:
    """Print the table, and return 1 if a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("python", help="Python that has geomstats-anim")
    parser.add_argument("--markdown", action="store_true", help="print rows of a table")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        size = prepare(args.python, Path(folder))
        rows = measure(make_armature())
    line = "| {} | {} | {} |" if args.markdown else "{:40} {:>10} {:>10}"
    print(line.format(f"{BONES} bones, {FRAMES} frames", "measured", "bar"))
    print(line.format("installed, without geomstats-anim", f"{size / 1000:.0f} kB", ""))
    for name, (seconds, bar) in rows.items():
        missed = "  MISSED" if seconds > bar or math.isnan(seconds) else ""
        print(line.format(name, f"{seconds:.3f} s", f"{bar:g} s") + missed)
    return int(any(seconds > bar for seconds, bar in rows.values()))


if __name__ == "__main__":
    sys.exit(main())
