"""From a BVH file to rotations and translations: what the channels of each joint come to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import default_bone_ends
from usd_tools.bvh.hierarchy import Hierarchy, read_hierarchy
from usd_tools.bvh.lines import LineError, read_lines
from usd_tools.bvh.motion import read_motion
from usd_tools.console.errors import ToolError
from usd_tools.files.paths import check_input

_CHUNK = 1 << 14
"""Rotations that are computed at once: about what a processor's cache holds."""


@dataclass(frozen=True, eq=False)
class Bvh:
    """Skeletons and their motion, lengths in the file's own unit.

    Parameters
    ----------
    names : tuple of str, shape=[B]
        As in the file: they may repeat, and hold any character.
    parents : array-like of int, shape=[B]
        Index of each joint's parent, -1 for a root. Parents come before children.
    offsets : array-like, shape=[B, 3]
        Of each joint from its parent, at rest.
    bone_ends : array-like, shape=[B, 3]
        End of each joint's bone in its own frame: the mean of its children, of its end sites for a leaf.
    rotations : array-like, shape=[F, B, 4]
        Relative to the parent, unit quaternions (x, y, z, w), sign-continuous along time.
    translations : array-like, shape=[F, B, 3]
        Relative to the parent. Position channels take the place of the offset, as they do in Blender.
    rate : float
        Frames per second.
    channels : tuple of tuple of str, shape=[B]
        Names of the channels of each joint, in the order of the file.
    """

    names: tuple[str, ...]
    parents: np.ndarray
    offsets: np.ndarray
    bone_ends: np.ndarray
    rotations: np.ndarray
    translations: np.ndarray
    rate: float
    channels: tuple[tuple[str, ...], ...]


def read_bvh(path: Path, rate: float | None = None, warn: Callable[[str], None] = lambda sentence: None) -> Bvh:
    """Read a BVH file.

    Parameters
    ----------
    path : Path
    rate : float
        Frames per second.
        Optional, default: as the file says.
    warn : callable
        Told, in a sentence, what is wrong with the file but does no harm.
        Optional, default: nobody is told.

    Returns
    -------
    bvh : Bvh

    Raises
    ------
    ToolError
        If there is no such file, or it is broken; then the sentence has the number of the line.
    """
    check_input(path, "a BVH file")
    try:
        lines = read_lines(path)
        tree, n_lines = read_hierarchy(lines)
        rate, table = read_motion(lines, n_lines, tree.n_channels, rate, lambda sentence: warn(f"{path}, {sentence}"))
    except LineError as error:
        raise ToolError(f"{path}, {error}") from None
    offsets = np.array(tree.offsets)
    return Bvh(
        tuple(tree.names),
        np.array(tree.parents, dtype=np.intp),
        offsets,
        _bone_ends(tree),
        _rotations(tree, table),
        _translations(tree, table),
        rate,
        tuple(tree.channels),
    )


def _bone_ends(tree: Hierarchy) -> np.ndarray:
    bone_ends = default_bone_ends(tree.parents, tree.offsets)
    leaves = set(range(len(tree.names))) - set(tree.parents)
    for joint in leaves:
        if tree.end_sites[joint]:
            bone_ends[joint] = np.mean(tree.end_sites[joint], axis=0)
    return bone_ends


def _columns(tree: Hierarchy, kind: str) -> list[tuple[str, list[int]]]:
    """Return the axes and the columns of each joint's channels of one kind, in the order of the file."""
    first, columns = 0, []
    for channels in tree.channels:
        own = [k for k, channel in enumerate(channels) if channel.endswith(kind)]
        columns.append(("".join(channels[k][0] for k in own), [first + k for k in own]))
        first += len(channels)
    return columns


def _rotations(tree: Hierarchy, table: np.ndarray) -> np.ndarray:
    """Turn the rotation channels into unit quaternions, shape=[F, B, 4], sign-continuous along time."""
    columns = _columns(tree, "rotation")
    orders = {order: [joint for joint, (axes, _) in enumerate(columns) if axes == order] for order, _ in columns}
    rotations = np.empty((len(table), len(columns), 4))
    last = np.tile(quat.IDENTITY, (1, len(columns), 1))  # so the first frame's scalar parts are not negative
    step = max(1, _CHUNK // len(columns))
    for start in range(0, len(table), step):
        chunk = rotations[start : start + step]
        for order, joints in orders.items():
            angles = table[start : start + step, [columns[joint][1] for joint in joints]]
            chunk[:, joints] = _from_euler(order, np.radians(angles))
        chunk[:] = quat.make_continuous(np.concatenate([last, chunk]))[1:]
        last = chunk[-1:]
    return rotations


def _from_euler(axes: str, angles: np.ndarray) -> np.ndarray:
    """Compose turns about axes, each about an axis that those before it have turned.

    Parameters
    ----------
    axes : str, length K
        Of X, Y and Z.
    angles : array-like, shape=[..., K]
        Radians.

    Returns
    -------
    quaternions : array-like, shape=[..., 4]
    """
    sines, cosines = np.sin(angles / 2.0), np.cos(angles / 2.0)
    turned = np.zeros((*angles.shape[:-1], 4))
    turned[..., 3] = 1.0
    for k, axis in enumerate(axes):
        # The quaternion product with (sine e_axis, cosine); Numba's takes longer to import than most files to read.
        i = "XYZ".index(axis)
        order = [i, (i + 1) % 3, (i + 2) % 3, 3]
        x, y, z, w = np.moveaxis(turned[..., order], -1, 0)
        sine, cosine = sines[..., k], cosines[..., k]
        turned[..., order] = np.stack(
            [cosine * x + sine * w, cosine * y + sine * z, cosine * z - sine * y, cosine * w - sine * x], axis=-1
        )
    return turned


def _translations(tree: Hierarchy, table: np.ndarray) -> np.ndarray:
    translations = np.empty((len(table), len(tree.names), 3))
    translations[:] = tree.offsets
    for joint, (axes, columns) in enumerate(_columns(tree, "position")):
        translations[:, joint, ["XYZ".index(axis) for axis in axes]] = table[:, columns]
    return translations
