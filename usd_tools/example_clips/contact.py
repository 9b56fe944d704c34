"""Rolling: where the body must be for its skin to touch the ground and not slip on it."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.special import softmax

from usd_tools.example_clips.biped import forward_kinematics
from usd_tools.example_clips.body import build_skin, deform

_SOFTNESS = 0.01  # metres: skin this much higher than the lowest bears a third of its load
_YIELD = 1.0  # samples: flesh gives way, so contact is no shock


def roll_on_ground(rotations: np.ndarray) -> np.ndarray:
    """Find the track of the hips along which the body's lowest points rest on the ground without slipping.

    Parameters
    ----------
    rotations : (F, 24, 4)
        Local rotations, unit quaternions, scalar last.

    Returns
    -------
    hips : (F, 3)
        Positions of the hips, metres; the first above the origin.
    """
    points = deform(build_skin(), *forward_kinematics(rotations, np.zeros((len(rotations), 3))))
    load = softmax(-points[:-1, :, 1] / _SOFTNESS, axis=1)
    slip = np.einsum("fv,fvi->fi", load, np.diff(points, axis=0))
    slip = gaussian_filter1d(slip, 3.0 * _YIELD, axis=0, mode="nearest")
    hips = np.concatenate([np.zeros((1, 3)), -np.cumsum(slip, axis=0)])
    hips[:, 1] = gaussian_filter1d(-points[..., 1].min(axis=1), _YIELD, mode="nearest")
    return hips
