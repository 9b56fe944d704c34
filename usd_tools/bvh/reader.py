"""From a BVH file to rotations and translations: what the channels of each joint come to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from geomstats_anim.animation import default_bone_ends
from geomstats_anim.rotations import IDENTITY, make_continuous
from usd_tools.bvh.text import BvhText, read_text
from usd_tools.files.atomic import temporary_folder
from usd_tools.files.paths import check_input
from usd_tools.skel.frame_rates import frame_rate

if TYPE_CHECKING:
    from pybvh.bvhnode import BvhNode


@dataclass(frozen=True, eq=False)
class Bvh:
    """A skeleton and its motion, lengths in the file's own unit.

    Parameters
    ----------
    names : tuple of str, shape=[B]
        As in the file: they may repeat, and hold any character.
    parents : array-like of int, shape=[B]
        Index of each joint's parent, -1 for the root, which comes first.
    offsets : array-like, shape=[B, 3]
        Of each joint from its parent, at rest.
    bone_ends : array-like, shape=[B, 3]
        End of each joint's bone in its own frame: the mean of its children, of its end sites for a leaf.
    rotations : array-like, shape=[F, B, 4]
        Relative to the parent, unit quaternions (x, y, z, w), sign-continuous along time.
    translations : array-like, shape=[F, B, 3]
        Relative to the parent. Position channels take the place of the offset, as they do in Blender.
    rate : float
        Frames a second.
    """

    names: tuple[str, ...]
    parents: np.ndarray
    offsets: np.ndarray
    bone_ends: np.ndarray
    rotations: np.ndarray
    translations: np.ndarray
    rate: float


def read_bvh(path: Path) -> Bvh:
    """Read a BVH file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    bvh : Bvh

    Raises
    ------
    ToolError
        If there is no such file, or it is broken; then the sentence has the number of the line.
    """
    check_input(path, "a BVH file")
    text = read_text(path)
    parents, offsets, bone_ends = _skeleton(_nodes(text))
    return Bvh(
        tuple(text.names),
        parents,
        offsets,
        bone_ends,
        _rotations(text),
        _translations(text, offsets),
        frame_rate(text.frame_time),
    )


def _nodes(text: BvhText) -> list[BvhNode]:
    """Have pybvh read the tree: joints and end sites, parents first."""
    import pybvh  # imports matplotlib, which --help need not wait for

    frame = " ".join(["0"] * (3 + 3 * len(text.names)))
    with temporary_folder() as folder:
        file = folder / "plain.bvh"
        file.write_text("\n".join([*text.plain, "MOTION", "Frames: 1", "Frame Time: 1", frame]), encoding="utf-8")
        return pybvh.read_bvh_file(file, world_up="+y").nodes


def _skeleton(nodes: Sequence[BvhNode]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parents, offsets and bone ends."""
    joints = [node for node in nodes if not node.is_end_site()]
    place = {id(node): i for i, node in enumerate(joints)}
    parents = np.array([-1 if node.parent is None else place[id(node.parent)] for node in joints], dtype=np.intp)
    offsets = np.array([node.offset for node in joints])
    ends: dict[int, list[np.ndarray]] = {}
    for node in nodes:
        if node.is_end_site():
            ends.setdefault(place[id(node.parent)], []).append(node.offset)
    bone_ends = default_bone_ends(parents, offsets)
    for joint in set(ends) - set(parents.tolist()):
        bone_ends[joint] = np.mean(ends[joint], axis=0)
    return parents, offsets, bone_ends


def _columns(text: BvhText, kind: str) -> list[tuple[str, list[int]]]:
    """Axes and columns of each joint's channels of one kind, in the order of the file."""
    first, columns = 0, []
    for channels in text.channels:
        own = [k for k, channel in enumerate(channels) if channel.endswith(kind)]
        columns.append(("".join(channels[k][0] for k in own), [first + k for k in own]))
        first += len(channels)
    return columns


def _rotations(text: BvhText) -> np.ndarray:
    n_frames, n_joints = len(text.table), len(text.names)
    rotations = np.tile(IDENTITY, (n_frames, n_joints, 1))
    columns = _columns(text, "rotation")
    for order in {axes for axes, _ in columns if axes}:
        joints = [joint for joint, (axes, _) in enumerate(columns) if axes == order]
        angles = text.table[:, [columns[joint][1] for joint in joints]].reshape(-1, len(order))
        # Capital letters are intrinsic: the first channel turns the axes of those that follow.
        turned = Rotation.from_euler(order, angles, degrees=True).as_quat(canonical=True)
        rotations[:, joints] = turned.reshape(n_frames, len(joints), 4)
    return make_continuous(rotations)


def _translations(text: BvhText, offsets: np.ndarray) -> np.ndarray:
    translations = np.tile(offsets, (len(text.table), 1, 1))
    for joint, (axes, columns) in enumerate(_columns(text, "position")):
        translations[:, joint, ["XYZ".index(axis) for axis in axes]] = text.table[:, columns]
    return translations
