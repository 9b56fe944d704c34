"""A walker whose feet are known to be planted: two legs, solved exactly, over footprints."""

import numpy as np

from geomstats_anim import Animation, Skeleton
from geomstats_anim import rotations as quat

BONE = 0.45
ANKLE = 0.08
STANCE = 0.6
"""Seconds that a foot is planted in each cycle of one second."""

_LEG = tuple("hips/thigh_l/shin_l/foot_l/toe_l"[:end] for end in (12, 19, 26, 32))
JOINTS = ("hips", *_LEG, *(joint.replace("_l", "_r") for joint in _LEG), "hips/head")
FEET = tuple(i for i, joint in enumerate(JOINTS) if joint.rsplit("/", 1)[-1][:4] in ("foot", "toe_"))


def skeleton():
    offsets = [[0, 0, 0], [0, 0, 0.1], [0, -BONE, 0], [0, -BONE, 0], [0.15, 0.03 - ANKLE, 0]]
    offsets = [*offsets, *([x, y, -z] for x, y, z in offsets[1:]), [0, 0.7, 0]]
    return Skeleton(JOINTS, [-1, 0, 1, 2, 3, 0, 5, 6, 7, 0], offsets, np.tile(quat.IDENTITY, (10, 1)))


def footprints(times, phase, stride=0.7):
    """Return where an ankle is, shape=[F, 2], forwards and upwards, and whether it is planted."""
    cycle = np.floor(times + phase)
    share = times + phase - cycle
    planted = share <= STANCE
    swing = np.clip((share - STANCE) / (1.0 - STANCE), 0.0, 1.0)
    forward = stride * (cycle + swing**2 * (3.0 - 2.0 * swing) - phase)
    return np.stack([forward, ANKLE + 0.15 * np.sin(np.pi * swing) ** 2], axis=-1), planted


def walk(seconds=3.0, rate=60.0, stride=0.7):
    """Return the motion, y up, walking along x, and whether each foot is planted, shape=[F, 2]."""
    times = np.arange(round(seconds * rate) + 1) / rate
    body = skeleton()
    hips = np.stack([stride * (times - 0.5 * STANCE), 0.86 + 0.01 * np.cos(4 * np.pi * times), 0 * times], axis=-1)
    turns = np.zeros((len(times), len(JOINTS), 3))
    planted = []
    for first, phase in ((1, 0.0), (5, 0.5)):
        ankle, is_planted = footprints(times, phase, stride)
        forward, up = (ankle - hips[:, :2]).T
        length = np.hypot(forward, up)
        bend = np.arccos(np.clip(length / (2 * BONE), -1.0, 1.0))
        leg = np.arctan2(forward, -up)
        turns[:, first, 2], turns[:, first + 1, 2] = leg + bend, -2.0 * bend
        turns[:, first + 2, 2] = -(leg - bend)
        planted.append(is_planted)
    translations = np.tile(body.rest_translations, (len(times), 1, 1))
    translations[:, 0] = hips
    return Animation(body, times, quat.exp(turns), translations), np.stack(planted, axis=-1)
