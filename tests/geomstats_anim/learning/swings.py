"""Small animations that an anisotropic metric made."""

import numpy as np
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, MetricParameters, Skeleton, interpolate
from geomstats_anim.learning.objective import Objective

N_JOINTS = 3


def swinging(seed=0, n_frames=33, n_joints=N_JOINTS):
    """An animation made of geodesics of an anisotropic metric, so that identity is far from the best."""
    rng = np.random.default_rng(seed)
    skeleton = Skeleton(
        [f"j{i}" for i in range(n_joints)],
        [i - 1 for i in range(n_joints)],
        np.tile([0.0, 0.3, 0.0], (n_joints, 1)),
        np.tile([0.0, 0.0, 0.0, 1.0], (n_joints, 1)),
    )
    n_keys = (n_frames - 1) // 8 + 1
    turns = np.cumsum(rng.uniform(-1.0, 1.0, (n_keys, n_joints, 3)), axis=0)
    poses = Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(n_keys, n_joints, 4)
    keys = Animation(skeleton, np.arange(n_keys) * 8.0, poses, np.tile(skeleton.rest_translations, (n_keys, 1, 1)))
    truth = MetricParameters(np.full(n_joints, 4.0), np.full(n_joints, 0.5), None, ("left", "right", "left")[:n_joints])
    return interpolate(keys, np.arange(float(n_frames)), "geodesic", truth)


def objective_of(seed=0, kind="hyb"):
    return Objective(swinging(seed), np.arange(0, 33, 8), kind)
