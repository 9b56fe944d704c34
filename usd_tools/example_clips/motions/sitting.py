"""Sitting on a box and swinging the legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usd_tools.example_clips.posing import Arm, Foot, Motion, Pose, animate

_SEAT = 0.6  # metres: the height of the box
_FRONT = -0.12  # metres along z: where the box begins, behind the hollow of the knees


def sitting() -> Motion:
    """Look behind, hop backwards onto a box, swing the legs in turn, wave, and slide off again."""
    stand = Pose()
    behind = stand.but(
        hips=(-0.04, 0.9, 0.0),
        turn=(4.0, -14.0, -2.0),
        spine=(10.0, -34.0, -6.0),
        head=(14.0, -48.0, -4.0),
        right=Arm((0.12, -0.42, -0.22), (0.5, 0.3, -1.0), (30.0, 0.0, 10.0)),
    )
    dip = stand.but(
        hips=(0.0, 0.8, -0.06),
        turn=(28.0, -4.0, 0.0),
        spine=(22.0, -6.0, 0.0),
        head=(-24.0, 0.0, 0.0),
        left=Arm((0.1, -0.4, -0.2), (0.6, 0.3, -1.0), (10.0, 0.0, 50.0)),
        right=Arm((0.1, -0.4, -0.2), (0.6, 0.3, -1.0), (10.0, 0.0, 50.0)),
    )
    low, high = _SEAT + 0.15, _SEAT + 0.19
    lifted = dip.but(
        hips=(0.02, high, -0.22),
        turn=(16.0, 4.0, 6.0),
        spine=(16.0, 2.0, 4.0),
        head=(-12.0, 4.0, -4.0),
        left_foot=Foot((0.1, 0.05, 0.16), 6.0, 24.0),
        right_foot=Foot((-0.1, 0.04, 0.18), -6.0, 22.0),
    )

    def swung(left: float, right: float) -> dict[str, Foot]:
        """Let the shins hang by angles from the vertical, degrees forwards, from knees over the box's edge."""
        feet = {}
        for part, mirror, angle in (("left_foot", 1.0, left), ("right_foot", -1.0, right)):
            sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
            y, z = _SEAT + 0.055 - 0.47 * cosine - 0.03 + 0.09 * sine, 0.09 + 0.47 * sine + 0.09 * cosine
            feet[part] = Foot((mirror * 0.12, y, z), mirror * 6.0, 14.0 - 0.9 * angle)
        return feet

    prop = Arm((0.12, -0.5, 0.04), (0.4, 0.0, -1.0), (50.0, 0.0, 60.0), 5.0)
    thigh = Arm((-0.04, -0.34, 0.24), (0.8, -0.2, -0.6), (20.0, 0.0, 10.0), 30.0)
    sit = Pose(
        hips=(0.0, low, -0.32),
        turn=(-4.0, 0.0, 0.0),
        spine=(14.0, 0.0, 0.0),
        head=(2.0, 0.0, 0.0),
        left=prop,
        right=prop,
        **swung(6.0, 2.0),
    )
    one = sit.but(turn=(-8.0, 4.0, 3.0), spine=(10.0, 10.0, -6.0), head=(-4.0, 20.0, 5.0), **swung(52.0, -14.0))
    two = sit.but(turn=(-8.0, -4.0, -3.0), spine=(10.0, -10.0, 6.0), head=(6.0, -24.0, -5.0), **swung(-14.0, 52.0))
    wave = one.but(
        spine=(6.0, 14.0, -10.0),
        head=(-6.0, 34.0, 8.0),
        left=Arm((0.22, 0.26, 0.2), (1.0, -0.6, 0.0), (-50.0, -15.0, 10.0), 5.0),
        right=thigh,
        **swung(46.0, -12.0),
    )
    wave_out = two.but(
        spine=(6.0, 6.0, -4.0),
        head=(-6.0, 26.0, -6.0),
        left=Arm((0.36, 0.2, 0.16), (1.0, -0.6, 0.0), (-50.0, 20.0, 10.0), 5.0),
        right=thigh,
        **swung(-12.0, 46.0),
    )
    edge = dip.but(
        hips=(0.0, _SEAT + 0.165, -0.2),
        turn=(20.0, 4.0, 0.0),
        spine=(20.0, 4.0, 0.0),
        left_foot=Foot((0.1, 0.04, 0.16), 8.0, 26.0),
        right_foot=Foot((-0.1, 0.06, 0.16), -8.0, 26.0),
    )
    off = dip.but(hips=(0.0, 0.78, -0.02), turn=(26.0, 6.0, 0.0), spine=(18.0, 8.0, 4.0))
    motion = animate(
        [
            (0.0, stand),
            (0.15, stand),
            (0.6, behind),
            (0.95, dip),
            (1.2, lifted),
            (1.5, sit),
            (1.9, one),
            (2.35, two),
            (2.8, one),
            (3.1, wave_out),
            (3.45, wave),
            (3.8, wave_out),
            (4.2, sit),
            (4.55, edge),
            (4.85, off),
            (5.4, stand),
            (5.7, stand),
        ]
    )
    return replace(motion, box=((-0.45, 0.0, _FRONT - 0.8), (0.45, _SEAT, _FRONT)))
