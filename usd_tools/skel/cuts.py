"""Find cuts: gaps between samples across which the pose jumps, so that no curve may lead from one to the other."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from geomstats_anim import Animation
from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import world_pose
from geomstats_anim.rotations import Array

JUMP = 6.0
"""A cut is a step this many times larger than each of its neighbours: in 600 recordings no step of a motion is three
times larger, while a teleport is hundreds of times larger."""

NEIGHBOURS = 3
"""Gaps on either side that a step is compared with. Animation on twos or threes has steps as large among them, and so
has a pose that is away for one sample."""

SHARE_OF_JOINTS = 0.25
"""Share of the joints that must jump: a thumb that flips, or a prop that changes hands, is no cut of the whole pose."""

LONGEST_GAP = 0.2
"""Seconds; samples further apart are sparse keys, and a large step between them is motion."""

LEAST_TURN = np.radians(1.0)
LEAST_SHARE_OF_SPACE = 1e-3
"""Steps of less than this share of the space that the motion fills need not be held."""

NO_MOVE = 1e-6
"""Metres that are none: what float32 makes of a constant."""


def find_cuts(keys: Animation) -> np.ndarray:
    """Return a mask of the gaps between frames across which the pose jumps.

    Parameters
    ----------
    keys : Animation

    Returns
    -------
    is_cut : array-like of bool, shape=[F - 1]
    """
    return find_cuts_in_parts(keys.times, [keys])


def find_cuts_in_parts(times: Array, parts: Iterable[Animation]) -> np.ndarray:
    """Do as `find_cuts`, part by part.

    Parameters
    ----------
    times : array-like, shape=[F]
        Seconds, of all frames.
    parts : iterable of Animation
        Each begins with the last frame of the one before.

    Returns
    -------
    is_cut : array-like of bool, shape=[F - 1]
    """
    gaps = np.diff(times)
    if len(gaps) <= NEIGHBOURS:
        return np.zeros(len(gaps), dtype=bool)
    turns, moves, bounds = [], [], []
    for keys in parts:
        origins = world_pose(keys).origins
        turns.append(quat.distance(keys.rotations[1:], keys.rotations[:-1]))
        moves.append(np.linalg.norm(np.diff(origins, axis=0), axis=-1))
        if origins.size:
            bounds += [origins.min(axis=(0, 1)), origins.max(axis=(0, 1))]
    space = np.ptp(bounds, axis=0).max() if bounds else 0.0
    jumps = _stands_out(_usual(np.concatenate(turns)), gaps, LEAST_TURN)
    jumps |= _stands_out(_usual(np.concatenate(moves)), gaps, max(NO_MOVE, LEAST_SHARE_OF_SPACE * space))
    return jumps & (gaps <= LONGEST_GAP)


def _usual(steps: Array) -> Array:
    """Return the step that a quarter of the joints that ever move reach, shape=[F - 1]."""
    moving = steps[:, (steps > NO_MOVE).any(axis=0)]
    if not moving.shape[1]:
        return np.zeros(len(steps))
    return np.quantile(moving, 1.0 - SHARE_OF_JOINTS, axis=1, method="higher")


def _stands_out(steps: Array, gaps: Array, least: float) -> np.ndarray:
    """Return a mask of the steps that are far larger, and faster, than all of their neighbours."""
    return (steps > least) & (steps > JUMP * _around(steps)) & (steps / gaps > JUMP * _around(steps / gaps))


def _around(values: Array) -> Array:
    """Return the largest of the neighbours of each value."""
    n = len(values)
    padded = np.pad(values, NEIGHBOURS)
    others = [padded[shift : shift + n] for shift in range(2 * NEIGHBOURS + 1) if shift != NEIGHBOURS]
    return np.max(others, axis=0)
