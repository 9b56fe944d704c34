"""Smooth random motions for the tests of the codec, always from a seed."""

import numpy as np

from geomstats_anim import Animation, Skeleton
from geomstats_anim import rotations as quat


def rig(n_joints=6, seed=0):
    """A skeleton with branches, bones of 5 to 40 cm, and any rest pose."""
    rng = np.random.default_rng(seed)
    parents = [-1, *(int(rng.integers(max(0, joint - 3), joint)) for joint in range(1, n_joints))]
    names = [f"joint{i}" for i in range(n_joints)]
    offsets = rng.normal(size=(n_joints, 3))
    offsets *= rng.uniform(0.05, 0.4, (n_joints, 1)) / np.linalg.norm(offsets, axis=-1, keepdims=True)
    return Skeleton(names, parents, offsets, quat.normalize(rng.normal(size=(n_joints, 4))))


def waves(rng, n_frames, n_channels, speed=3.0):
    """Sums of a few sines, shape=[F, C], of size about one."""
    time = np.linspace(0.0, 1.0, n_frames)[:, None, None]
    frequency, phase = rng.uniform(0.0, speed, (2, 1, n_channels, 4)) * [[[[1.0]]], [[[2.0 * np.pi / speed]]]]
    return np.sin(2.0 * np.pi * frequency * time + phase).mean(axis=-1)


def motion(n_frames=40, n_joints=6, seed=0, size=0.8, rate=30.0, scales=False):
    """A motion of `rig` whose root travels, and whose joints turn about their rest rotations."""
    rng, skeleton = np.random.default_rng([seed, 1]), rig(n_joints, seed)
    turns = size * waves(rng, n_frames, 3 * n_joints).reshape(n_frames, n_joints, 3)
    translations = np.tile(skeleton.rest_translations, (n_frames, 1, 1))
    translations[:, 0] += waves(rng, n_frames, 3)
    stretch = 1.0 + 0.3 * waves(rng, n_frames, 3 * n_joints).reshape(turns.shape) if scales else None
    rotations = quat.multiply(skeleton.rest_rotations, quat.exp(turns))
    return Animation(skeleton, np.arange(n_frames) / rate, rotations, translations, stretch)


def held(animation, n_frames):
    """The first pose, for a number of frames."""
    still = np.zeros(n_frames, dtype=np.intp)
    scales = None if animation.scales is None else animation.scales[still]
    times = np.arange(n_frames) / 30.0
    return Animation(animation.skeleton, times, animation.rotations[still], animation.translations[still], scales)
