"""Pieces that the notebooks share: an example clip as an animation, and skeletons as lines."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from geomstats_anim import Animation, Skeleton
from geomstats_anim.kinematics import world_pose
from geomstats_anim.rotations import from_matrix
from usd_tools.example_clips.biped import OFFSETS, PARENTS, joint_paths
from usd_tools.example_clips.motions import MOTIONS
from usd_tools.example_clips.posing import RATE


def clip(name: str) -> Animation:
    """Make one of the example clips: jumping, pitching, punching, rolling or sitting."""
    motion = MOTIONS[name]()
    n_frames = len(motion.rotations)
    places = np.tile(OFFSETS, (n_frames, 1, 1))
    places[:, 0] = motion.hips
    still = np.tile([0.0, 0.0, 0.0, 1.0], (len(PARENTS), 1))
    skeleton = Skeleton(tuple(joint_paths()), PARENTS, OFFSETS, still)
    return Animation(skeleton, np.arange(n_frames) / RATE, motion.rotations, places)


def posed(animation: Animation, points: np.ndarray) -> Animation:
    """Give poses, shape=[F, B, 3, 3], to a skeleton, which stands where the first frame of an animation does."""
    n_frames = len(points)
    places = np.repeat(animation.translations[:1], n_frames, axis=0)
    return Animation(animation.skeleton, np.arange(float(n_frames)), from_matrix(points), places)


def draw(axes: Axes, animation: Animation, frame: int, color: str, turn: float = 35.0, **style: float) -> None:
    """Draw the bones of a frame, seen from the side, turned by some degrees about the vertical."""
    pose = world_pose(animation)
    angle = np.radians(turn)
    view = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0]])
    width = style.pop("linewidth", 3.0)
    shift = style.pop("shift", 0.0)
    parents = np.asarray(animation.skeleton.parents)
    places = pose.origins[frame]
    lines = [(places[parent], places[joint]) for joint, parent in enumerate(parents) if parent >= 0]
    lines += [(places[joint], pose.ends[frame, joint]) for joint in set(range(len(parents))) - set(parents)]
    for line in lines:
        x, y = view @ np.stack(line, axis=1)
        axes.plot(x + shift, y, color=color, linewidth=width, solid_capstyle="round", **style)
    axes.set_aspect("equal")
    axes.set_axis_off()
