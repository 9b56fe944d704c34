"""Where a character stands: its skeleton's place in the world, in metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pxr import Usd, UsdGeom

from geomstats_anim import Animation
from usd_tools.skel.clip import SkelClip
from usd_tools.skel.skeleton import metres_per_unit, world_matrices


def up_axis(clip: SkelClip) -> str:
    """Return the axis of the world that is up, "y" or "z"."""
    return str(UsdGeom.GetStageUpAxis(clip.source.stage)).lower()


def upright(clip: SkelClip) -> np.ndarray:
    """Rotation from a skeleton's space to a world in which z is up, shape=[3, 3], for row vectors."""
    source = clip.source
    turn = np.eye(3)
    if source.skeletons:
        imageable = UsdGeom.Imageable(source.skeletons[0])
        matrix = imageable.ComputeLocalToWorldTransform(Usd.TimeCode.EarliestTime())
        turn = np.array(matrix.RemoveScaleShear().ExtractRotationMatrix())
    if UsdGeom.GetStageUpAxis(source.stage) == UsdGeom.Tokens.y:
        turn = turn @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    return turn


def placements(clip: SkelClip, times: np.ndarray) -> np.ndarray:
    """Place a clip's skeleton in the world.

    Parameters
    ----------
    clip : SkelClip
    times : array-like, shape=[F]
        Seconds.

    Returns
    -------
    world : array-like, shape=[F, 3, 4]
        From the skeleton's space, in metres, to the world; see `Animation.world`.
    """
    unmoved = np.broadcast_to(np.eye(3, 4), (len(times), 3, 4))
    if not clip.source.rig:
        return unmoved
    matrices = world_matrices(clip.source.rig[0], times * clip.codes_per_second).transpose(0, 2, 1)[:, :3]
    unit = metres_per_unit(clip.source.stage)
    linear = matrices[..., :3] * (unit / clip.world_scale)
    world = np.concatenate([linear, matrices[..., 3:] * unit], axis=-1)
    return world if np.isfinite(world).all() else unmoved


def placed(clip: SkelClip, animation: Animation) -> Animation:
    """Put an animation where its clip's skeleton stands in the world."""
    return replace(animation, world=placements(clip, animation.times))
