"""Up axes of a skeleton and of the world."""

from __future__ import annotations

import numpy as np
from pxr import UsdGeom

from usd_tools.skel.clip import SkelClip


def up_in_world(clip: SkelClip) -> np.ndarray:
    """Return the unit vector upwards in the world, shape=[3]."""
    return np.eye(3)[1 if UsdGeom.GetStageUpAxis(clip.source.stage) == UsdGeom.Tokens.y else 2]


def vertical(clip: SkelClip) -> np.ndarray:
    """Return the unit vector upwards in the space of a clip's skeleton where it begins, shape=[3]."""
    up = up_in_world(clip)
    if not clip.source.rig:
        return up
    in_skeleton = clip.world_matrices(clip.codes[:1])[0, :3, :3] @ up
    length = np.linalg.norm(in_skeleton)
    return np.asarray(in_skeleton / length) if np.isfinite(length) and length > 0.0 else up
