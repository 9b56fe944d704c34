"""A two-legged rig, its gaits, which are alike but for speed, width and phase, and a small library of them."""

from functools import cache

import numpy as np

from geomstats_anim import Animation, MotionLibrary, Skeleton, learn_library
from geomstats_anim import rotations as quat

_BONES = [
    # name, parent, rest translation
    ("hips", -1, (0.0, 1.0, 0.0)),
    ("hips/spine", 0, (0.0, 0.2, 0.0)),
    ("hips/spine/chest", 1, (0.0, 0.2, 0.0)),
    ("hips/spine/chest/head", 2, (0.0, 0.25, 0.0)),
    ("hips/spine/chest/arm_L", 2, (0.2, 0.15, 0.0)),
    ("hips/spine/chest/arm_L/fore_L", 4, (0.28, 0.0, 0.0)),
    ("hips/spine/chest/arm_L/fore_L/hand_L", 5, (0.25, 0.0, 0.0)),
    ("hips/spine/chest/arm_R", 2, (-0.2, 0.15, 0.0)),
    ("hips/spine/chest/arm_R/fore_R", 7, (-0.28, 0.0, 0.0)),
    ("hips/spine/chest/arm_R/fore_R/hand_R", 8, (-0.25, 0.0, 0.0)),
    ("hips/thigh_L", 0, (0.1, -0.05, 0.0)),
    ("hips/thigh_L/shin_L", 10, (0.0, -0.4, 0.0)),
    ("hips/thigh_L/shin_L/foot_L", 11, (0.0, -0.4, 0.0)),
    ("hips/thigh_R", 0, (-0.1, -0.05, 0.0)),
    ("hips/thigh_R/shin_R", 13, (0.0, -0.4, 0.0)),
    ("hips/thigh_R/shin_R/foot_R", 14, (0.0, -0.4, 0.0)),
]


def biped() -> Skeleton:
    """Make the rig."""
    names, parents, rests = zip(*_BONES, strict=True)
    return Skeleton(names, parents, rests, [[0.0, 0.0, 0.0, 1.0]] * len(names))


def gait(seed: int, n_frames: int = 80) -> Animation:
    """Make a walk at 30 frames per second: every joint swings about its own axis, sharper than a sine."""
    skeleton, rng = biped(), np.random.default_rng(seed)
    styles = np.random.default_rng(0)
    axes = styles.normal(size=(skeleton.n_joints, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    lags, widths = styles.uniform(0.0, 2 * np.pi, skeleton.n_joints), styles.uniform(0.2, 0.7, skeleton.n_joints)
    times = np.arange(n_frames) / 30.0
    phase = 2 * np.pi * (rng.uniform(0.9, 1.1) * times[:, None] + rng.uniform()) + lags
    swing = np.sin(phase + 0.5 * np.sin(phase)) + 0.3 * np.sin(2.0 * phase)
    turns = rng.uniform(0.85, 1.15) * widths * swing
    rotations = quat.exp(turns[..., None] * axes)
    translations = np.broadcast_to(skeleton.rest_translations, (n_frames, skeleton.n_joints, 3)).copy()
    translations[:, 0, 2] += 1.2 * times
    return Animation(skeleton, times, rotations, translations)


@cache
def library() -> MotionLibrary:
    """Learn from eight gaits, for gaps of 4, 8 and 16 frames."""
    return learn_library([gait(seed) for seed in range(1, 9)], gaps=(4, 8, 16))
