"""Write a BVH file: joints nested in one another, and a row of channels per frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.euler import from_euler, to_euler
from usd_tools.bvh.hierarchy import CHANNELS

ROTATIONS = ("Zrotation", "Yrotation", "Xrotation")
"""Channels of a joint that nothing else is asked for: the order of most files."""

_POSITIONS = CHANNELS[:3]

NO_TURN = 1e-6
"""Radians by which the channels that a joint had may miss its rotations."""

SAME_PLACE = 1e-6
"""Share of the largest offset by which a joint may be away from its own, and need no position channels."""


@dataclass(frozen=True, eq=False)
class BvhMotion:
    """Contents of a BVH file.

    Parameters
    ----------
    names : sequence of str, shape=[B]
    parents : array-like of int, shape=[B]
        -1 for a root. Parents come before children.
    offsets : array-like, shape=[B, 3]
        From the parent at rest, where nothing is turned.
    bone_ends : array-like, shape=[B, 3]
        End of each joint's bone at rest, which is written for leaves.
    rotations : array-like, shape=[F, B, 4]
        Relative to the parent, unit quaternions.
    translations : array-like, shape=[F, B, 3]
        Relative to the parent.
    rate : float
        Frames per second.
    """

    names: Sequence[str]
    parents: np.ndarray
    offsets: np.ndarray
    bone_ends: np.ndarray
    rotations: np.ndarray
    translations: np.ndarray
    rate: float


def write_bvh(path: Path, motion: BvhMotion, wanted: Sequence[Sequence[str]] | None = None) -> None:
    """Write a BVH file.

    Parameters
    ----------
    path : Path
    motion : BvhMotion
    wanted : sequence of sequences of str, shape=[B]
        Channels of each joint, such as those of a file that it was read from. Those that cannot hold its motion are
        completed.
        Optional, default: positions where a joint moves, and rotations about Z, Y and X.
    """
    channels, columns = [], []
    for joint, parent in enumerate(motion.parents):
        own = () if wanted is None else tuple(wanted[joint])
        names, values = _columns(motion, joint, own, must_move=parent < 0 and wanted is None)
        channels.append(names)
        columns.append(values)
    order = _depth_first(motion.parents)
    table = np.concatenate([columns[joint] for joint in order], axis=1)
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        file.writelines(f"{line}\n" for line in ("HIERARCHY", *_hierarchy(motion, channels), "MOTION"))
        file.write(f"Frames: {len(table)}\nFrame Time: {1.0 / motion.rate:.12g}\n")
        np.savetxt(file, table + 0.0, fmt="%.7g" if _is_small(table) else "%.6f")


def _is_small(table: np.ndarray) -> bool:
    """Return whether decimals would hold fewer digits than single precision."""
    return bool(np.abs(table).max(initial=0.0) < 1.0)


def _columns(
    motion: BvhMotion, joint: int, wanted: tuple[str, ...], must_move: bool
) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the channels of a joint, and their values, shape=[F, C]."""
    away = np.abs(motion.translations[:, joint] - motion.offsets[joint]).max(axis=0)
    needed = away > SAME_PLACE * max(np.abs(motion.offsets).max(), np.finfo(np.float64).tiny)
    places = {name: motion.translations[:, joint, "XYZ".index(name[0])] for name in _POSITIONS}
    names = wanted
    if must_move or not all(name in names for name, is_needed in zip(_POSITIONS, needed, strict=True) if is_needed):
        names = (*_POSITIONS, *(name for name in names if name not in _POSITIONS))
    axes = "".join(name[0] for name in wanted if name.endswith("rotation"))
    order = axes + "".join(name[0] for name in ROTATIONS if name[0] not in axes)
    angles = to_euler(motion.rotations[:, joint], order, len(axes))
    angles[:, len(axes) :] = 0.0
    if quat.distance(from_euler(angles, order), motion.rotations[:, joint]).max() > NO_TURN:
        names = (*(name for name in names if not name.endswith("rotation")), *ROTATIONS)
        order, angles = "ZYX", to_euler(motion.rotations[:, joint], "ZYX")
    turns = {f"{axis}rotation": np.degrees(angles[:, n]) for n, axis in enumerate(order)}
    values = [(places | turns)[name] for name in names]
    return names, np.stack(values, axis=1) if values else np.zeros((len(angles), 0))


def _depth_first(parents: np.ndarray) -> list[int]:
    """Return the joints in the order in which their blocks are written."""
    children: dict[int, list[int]] = {}
    for joint, parent in enumerate(parents.tolist()):
        children.setdefault(parent, []).append(joint)
    order, waiting = [], children.get(-1, [])[::-1]
    while waiting:
        joint = waiting.pop()
        order.append(joint)
        waiting += children.get(joint, [])[::-1]
    return order


def _hierarchy(motion: BvhMotion, channels: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines between HIERARCHY and MOTION."""
    has_children = np.isin(np.arange(len(motion.parents)), motion.parents)
    depth: dict[int, int] = {-1: -1}
    last = -1
    for joint in _depth_first(motion.parents):
        parent = int(motion.parents[joint])
        depth[joint] = depth[parent] + 1
        yield from _closing(depth.get(last, -1), depth[joint])
        indent = "\t" * depth[joint]
        yield f"{indent}{'ROOT' if parent < 0 else 'JOINT'} {motion.names[joint]}"
        yield f"{indent}{{"
        yield f"{indent}\tOFFSET {_numbers(motion.offsets[joint])}"
        if channels[joint]:
            yield f"{indent}\tCHANNELS {len(channels[joint])} {' '.join(channels[joint])}"
        if not has_children[joint]:
            yield from (f"{indent}\tEnd Site", f"{indent}\t{{")
            yield from (f"{indent}\t\tOFFSET {_numbers(motion.bone_ends[joint])}", f"{indent}\t}}")
        last = joint
    yield from _closing(depth[last], 0)


def _closing(deepest: int, depth: int) -> Iterator[str]:
    """Yield the brackets that end the blocks from one depth up to another."""
    return ("\t" * level + "}" for level in range(deepest, depth - 1, -1))


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{value + 0.0:.9g}" for value in values)
