"""Motions for the tests of learning: smooth ones of a small tree of joints, and the real clips."""

import numpy as np
from real_files import real_file

from geomstats_anim import Animation, MetricParameters, Skeleton
from geomstats_anim import rotations as quat

PARENTS = (-1, 0, 1, 0, 3, 3)
N_JOINTS = len(PARENTS)


def tree():
    """Joints that branch, with bones of about 30 cm."""
    rng = np.random.default_rng(7)
    rest = rng.normal(scale=0.2, size=(N_JOINTS, 3))
    return Skeleton([f"joint{i}" for i in range(N_JOINTS)], PARENTS, rest, np.tile(quat.IDENTITY, (N_JOINTS, 1)))


def of_vectors(vectors, translations=None):
    """Animation at 30 frames a second of rotation vectors, shape=[F, B, 3]."""
    skeleton = tree()
    if translations is None:
        translations = np.tile(skeleton.rest_translations, (len(vectors), 1, 1))
    return Animation(skeleton, np.arange(len(vectors)) / 30.0, quat.exp(vectors), translations)


def wandering(seed=0, n_frames=41):
    """Smooth turns of about half a radian back and forth, and a root that walks."""
    rng = np.random.default_rng(seed)
    time = np.arange(n_frames)[:, None, None] / 30.0
    vectors = sum(
        rng.normal(scale=0.3, size=(N_JOINTS, 3)) * np.sin(speed * time + rng.uniform(0.0, 6.3, (N_JOINTS, 3)))
        for speed in (3.0, 5.0, 8.0)
    )
    translations = np.tile(tree().rest_translations, (n_frames, 1, 1))
    translations[:, 0] += np.sin(2.0 * time[:, 0]) * rng.normal(scale=0.3, size=3)
    return of_vectors(vectors, translations)


def noise(seed=0, n_frames=121):
    """Frames that have nothing to do with each other."""
    return of_vectors(np.random.default_rng(seed).normal(scale=0.3, size=(n_frames, N_JOINTS, 3)))


def metric(seed=0, full=False, sides=None):
    """Moments between 1/e and e; sides left, right or mixed."""
    rng = np.random.default_rng(seed)
    alpha, beta = np.exp(rng.uniform(-1.0, 1.0, (2, N_JOINTS)))
    axes = rng.normal(size=(N_JOINTS, 3)) if full else None
    return MetricParameters(alpha, beta, axes, sides or ("left", "right") * (N_JOINTS // 2))


def real(name):
    """Read one of the real clips, or skip the test where it is not there."""
    from usd_tools.files.stages import open_stage
    from usd_tools.skel.clip import read_clip
    from usd_tools.skel.find import find_animations
    from usd_tools.skel.resampling import animation_of

    stage = open_stage(real_file(name))
    return animation_of(read_clip(find_animations(stage)[0]))
