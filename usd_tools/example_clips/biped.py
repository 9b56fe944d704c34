"""The rig: 24 joints of a 1.75 m biped in a T-pose, y up, facing +z, its left towards +x.

At rest every joint's frame is aligned with the world, so a rotation about x bends, about y twists and about z leans.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

_TRUNK = (
    ("Hips", None, (0.0, 0.96, 0.0)),
    ("Spine", "Hips", (0.0, 0.09, -0.01)),
    ("Chest", "Spine", (0.0, 0.13, -0.01)),
    ("UpperChest", "Chest", (0.0, 0.13, 0.0)),
    ("Neck", "UpperChest", (0.0, 0.17, 0.0)),
    ("Head", "Neck", (0.0, 0.08, 0.015)),
)
_LIMB = (
    ("Shoulder", "UpperChest", (0.03, 0.115, 0.01)),
    ("UpperArm", "Shoulder", (0.145, 0.01, -0.01)),
    ("ForeArm", "UpperArm", (0.275, 0.0, 0.0)),
    ("Hand", "ForeArm", (0.25, 0.0, 0.0)),
    ("Fingers", "Hand", (0.09, 0.0, 0.0)),
    ("Thigh", "Hips", (0.09, -0.055, 0.0)),
    ("Shin", "Thigh", (0.0, -0.42, 0.0)),
    ("Foot", "Shin", (0.0, -0.40, 0.0)),
    ("Toes", "Foot", (0.0, -0.055, 0.125)),
)


def _build() -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    rows = list(_TRUNK)
    for side, mirror in (("Left", 1.0), ("Right", -1.0)):
        own = {name for name, _, _ in _LIMB}
        for name, parent, (x, y, z) in _LIMB:
            rows.append((side + name, side + parent if parent in own else parent, (mirror * x, y, z)))
    names = tuple(name for name, _, _ in rows)
    parents = np.array([-1 if parent is None else names.index(parent) for _, parent, _ in rows])
    return names, parents, np.array([offset for _, _, offset in rows])


NAMES, PARENTS, OFFSETS = _build()
"""Names (24), parents (24,) with -1 for the root, and translations (24, 3) from the parent at rest, in metres."""

INDEX = {name: joint for joint, name in enumerate(NAMES)}


def joint_paths() -> list[str]:
    """Return the joints as UsdSkel spells them: the path from the root, parents before children."""
    paths: list[str] = []
    for name, parent in zip(NAMES, PARENTS, strict=True):
        paths.append(name if parent < 0 else f"{paths[parent]}/{name}")
    return paths


def rest_positions() -> np.ndarray:
    """Return where the joints are at rest: (24, 3), metres."""
    positions = OFFSETS.copy()
    for joint, parent in enumerate(PARENTS):
        if parent >= 0:
            positions[joint] += positions[parent]
    return positions


def forward_kinematics(rotations: np.ndarray, root: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Carry joint-local rotations and the root's track to the world.

    Parameters
    ----------
    rotations : (F, 24, 4)
        Local rotations, unit quaternions, scalar last.
    root : (F, 3)
        Positions of the root, metres.

    Returns
    -------
    positions : (F, 24, 3)
        Positions of the joints, metres.
    orientations : (F, 24, 3, 3)
        Orientations of the joints, rotation matrices.
    """
    local = Rotation.from_quat(rotations.reshape(-1, 4)).as_matrix().reshape(*rotations.shape[:2], 3, 3)
    positions, orientations = np.empty(rotations.shape[:2] + (3,)), local.copy()
    positions[:, 0] = root
    for joint, parent in enumerate(PARENTS):
        if parent >= 0:
            positions[:, joint] = positions[:, parent] + orientations[:, parent] @ OFFSETS[joint]
            orientations[:, joint] = orientations[:, parent] @ local[:, joint]
    return positions, orientations
