"""Latency of edits: processor time from a changed value to dense rotations, poses in the world and errors.

    python benchmarks/bench_live.py [--quick] [--markdown]

The clip has 70 joints and 300 frames, of which every 10th is a key, and is made here: five limbs whose joints turn
about any axes from key to key. alpha is dragged from 2.5 to 3, and beta from .4 to .33. Lines that end in MISSED fail
their bar, and then the exit code is 1. Times are of one core, warm, the least of several.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from bench_geodesics import Line, one_core, print_table, seconds
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from geomstats_anim import rotations as quat  # noqa: E402
from usd_tools.editing import EditSession  # noqa: E402
from usd_tools.editing.edits import Edit, EveryNth, exactly  # noqa: E402
from usd_tools.upsampling.joint_styles import Style  # noqa: E402

N_JOINTS, N_FRAMES, SPACING = 70, 300, 10


def make_clip(path: Path, n_frames: int, n_joints: int, step: float) -> None:
    """Write a clip whose joints turn by about some degrees from key to key."""
    rng = np.random.default_rng(0)
    names = ["hips"]
    for joint in range(1, n_joints):
        names.append(f"{names[0 if joint % 14 == 1 else joint - 1]}/j{joint}")
    knots = np.deg2rad(step) * rng.uniform(0.3, 1.0, (n_frames // SPACING + 2, n_joints, 1))
    axes = rng.normal(size=(n_frames // SPACING + 2, n_joints, 3))
    turns = quat.exp(knots * axes / np.linalg.norm(axes, axis=-1, keepdims=True))
    keys = [turns[0]]
    for turn in turns[1:]:
        keys.append(quat.multiply(keys[-1], turn))
    frame = np.arange(n_frames) / SPACING
    knot = frame.astype(int)
    dense = quat.slerp(np.array(keys)[knot], np.array(keys)[knot + 1], (frame - knot)[:, None]).astype(np.float32)
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    root = UsdSkel.Root.Define(stage, "/Rig")
    skeleton = UsdSkel.Skeleton.Define(stage, "/Rig/Skel")
    rest = Vt.Matrix4dArray([Gf.Matrix4d().SetTranslate((0, 8, 0))] * n_joints)
    skeleton.CreateJointsAttr(names)
    skeleton.CreateRestTransformsAttr(rest)
    skeleton.CreateBindTransformsAttr(rest)
    animation = UsdSkel.Animation.Define(stage, "/Rig/Anim")
    animation.CreateJointsAttr(names)
    animation.CreateTranslationsAttr(Vt.Vec3fArray([Gf.Vec3f(0, 8, 0)] * n_joints))
    animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * n_joints))
    for code, rotations in enumerate(dense):
        animation.CreateRotationsAttr().Set(Vt.QuatfArray.FromNumpy(rotations), code)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/Rig/Anim"])
    stage.SetDefaultPrim(root.GetPrim())
    stage.Save()


def latency(session: EditSession, edit: Callable[[float], Edit], is_dragged: bool, repeats: int) -> float:
    """Return the processor time of an edit until all that is seen of it is there."""
    values = iter(np.linspace(2.5, 3.0, repeats))

    def run() -> None:
        (session.drag if is_dragged else session.apply)(edit(float(next(values))))
        session.poses()
        session.errors()

    return seconds(run, repeats, time.process_time)


def edits(folder: Path, step: float, repeats: int) -> Iterator[Line]:
    """Edit one joint and all joints, while dragged and on release."""
    path = folder / f"steps_of_{step:g}.usdc"
    make_clip(path, N_FRAMES, N_JOINTS, step)
    session = EditSession.open(path)
    session.apply(EveryNth(SPACING))
    session.poses()
    joint = exactly(session.skeleton.joints[20])
    what = f"{N_JOINTS} joints x {N_FRAMES} frames, steps up to {step:g} degrees"
    cases: tuple[tuple[str, str, bool, float | None], ...] = (
        ("alpha and beta of one joint, dragged", joint, True, 5.0),
        ("alpha and beta of one joint, released", joint, False, 5.0),
        ("alpha and beta of all joints, dragged", "*", True, 40.0),
        ("alpha and beta of all joints, released", "*", False, None),
    )
    for name, pattern, is_dragged, bar in cases:
        took = 1e3 * latency(
            session, lambda value, pattern=pattern: Style(pattern, alpha=value, beta=1.0 / value), is_dragged, repeats
        )  # type: ignore[misc]
        session.release()
        met = None if bar is None else took <= bar
        yield Line(f"{what}: {name}", "" if bar is None else f"{bar:g} ms", f"{took:.1f} ms", met)
    took = 1e3 * latency(session, lambda value: Style(joint, tension=0.4 * value), True, repeats)
    session.cancel()
    yield Line(f"{what}: tension of one joint, dragged", "5 ms", f"{took:.1f} ms", took <= 5.0)


def opening(folder: Path, n_frames: int) -> Iterator[Line]:
    """Open a long clip, up to the first pose of an edit, and edit it."""
    path = folder / "long.usdc"
    make_clip(path, n_frames, 24, 30.0)

    def run() -> EditSession:
        session = EditSession.open(path)
        session.apply(EveryNth(SPACING))
        session.poses()
        return session

    what = f"24 joints x {n_frames} frames"
    took = seconds(run, 1, time.process_time)
    yield Line(f"{what}: opened, every 10th a key", "10 s", f"{took:.1f} s", took <= 10.0)
    session = run()
    joint = exactly(session.skeleton.joints[20])
    took = 1e3 * latency(session, lambda value: Style(joint, alpha=value), True, 3)
    yield Line(f"{what}: alpha of one joint, dragged", "", f"{took:.0f} ms")


def measure(quick: bool) -> Iterator[Line]:
    """Measure everything."""
    with tempfile.TemporaryDirectory() as folder, one_core():
        for step in (30.0, 80.0, 150.0):
            yield from edits(Path(folder), step, 5 if quick else 15)
        yield from opening(Path(folder), 2000 if quick else 20_000)


if __name__ == "__main__":
    sys.exit(print_table(measure, __doc__, None))
