"""Bytes of ACL, a codec of engines, as a reference for clips that are recognised by their motion; it is not run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geomstats_anim import Animation
from geomstats_anim import rotations as quat

ACL = "ACL 2.1"

SOURCE = (
    "ACL 2.1: bytes measured once with the public library (github.com/nfrechette/acl, level Medium), without names "
    "and metadata; it is not run here. Its precision was bisected until the true error of joints and points 3 cm "
    "around them is within the tolerance."
)
"""Said wherever its bytes are shown."""

CENTIMETRES = (0.01, 0.1, 1.0, 3.0)

_ALIKE = 1e-3
"""Share by which what tells a clip may differ: rates and units may be written otherwise."""


class Reference(NamedTuple):
    """Bytes of ACL for one clip, and what tells it from others whatever its file is called.

    Attributes
    ----------
    n_frames, n_joints : int
    radians : float
        Sum of the turns of all joints from each frame to the next.
    metres : float
        Sum of the lengths of all bones, roots left out.
    sizes : tuple of int or None
        Bytes within each of `CENTIMETRES`; None where ACL does not reach it.
    """

    n_frames: int
    n_joints: int
    radians: float
    metres: float
    sizes: tuple[int | None, ...]


REFERENCES = {
    "sitting": Reference(35, 23, 26.542, 4.61184, (4113, 3101, 2221, 1729)),
    "punching": Reference(36, 23, 50.363, 4.62422, (3646, 2850, 2038, 1726)),
    "pitching": Reference(160, 31, 136.346, 4.14632, (17839, 12783, 7927, 6031)),
    "jumping": Reference(164, 27, 113.825, 1.24477, (16731, 10579, 6255, 4995)),
    "rolling": Reference(195, 31, 163.928, 4.09495, (20803, 14411, 8743, 6547)),
    "hik": Reference(101, 70, 209.548, 27.30549, (None, 11143, 7427, 6363)),
    "12_01": Reference(523, 31, 133.219, 3.89728, (49139, 33019, 19527, 11951)),
    "124_01": Reference(643, 31, 140.285, 4.14631, (59713, 39905, 24909, 16633)),
    "90_02": Reference(781, 31, 223.464, 4.09495, (72629, 48229, 28857, 17481)),
    "02_08": Reference(1500, 31, 346.302, 4.04629, (137819, 90283, 53563, 30999)),
    "131_03": Reference(1102, 31, 500.843, 3.80967, (101399, 68575, 42883, 29243)),
    "14_08": Reference(2625, 31, 666.587, 4.13133, (254287, 174415, 103451, 66219)),
    "dab": Reference(339, 27, 560.03, 1.24477, (32817, 23145, 13797, 10305)),
    "doll_jumping": Reference(654, 27, 115.482, 1.24477, (49743, 30203, 17339, 10599)),
    "jumping_jacks": Reference(125, 31, 143.359, 0.73193, (11825, 8037, 5121, 3381)),
    "zombie": Reference(779, 27, 533.78, 1.24477, (75191, 51267, 30803, 21247)),
}
"""Five clips of UsdSkel, maya-usd's HIK_Export, CMU motion capture at .056444 m per unit, and AnimatedDrawings."""


def acl_bytes(stretches: Sequence[Animation], tolerance: float) -> int | None:
    """Return the bytes that ACL needs for a clip within a tolerance.

    Parameters
    ----------
    stretches : sequence of Animation
        All of its motion.
    tolerance : float
        Centimetres.

    Returns
    -------
    size : int or None
        None for a clip or a tolerance that was not measured.
    """
    if tolerance not in CENTIMETRES:
        return None
    skeleton = stretches[0].skeleton
    n_frames = sum(each.n_frames for each in stretches)
    radians = sum(float(quat.distance(each.rotations[1:], each.rotations[:-1]).sum()) for each in stretches)
    metres = float(np.linalg.norm(skeleton.rest_translations[skeleton.parents >= 0], axis=-1).sum())
    for each in REFERENCES.values():
        is_same = (each.n_frames, each.n_joints) == (n_frames, skeleton.n_joints)
        if is_same and np.allclose([radians, metres], [each.radians, each.metres], rtol=_ALIKE, atol=0.0):
            return each.sizes[CENTIMETRES.index(tolerance)]
    return None
