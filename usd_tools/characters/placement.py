"""Placement of a character: its skeleton's place in the world, in metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pxr import Usd, UsdGeom

from geomstats_anim import Animation
from usd_tools.skel.clip import SkelClip


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


def placed(clip: SkelClip, animation: Animation) -> Animation:
    """Put an animation where its clip's skeleton stands in the world."""
    return replace(animation, world=clip.placements(animation.times * clip.codes_per_second))
