"""A boxer's combination."""

from __future__ import annotations

from usd_tools.example_clips.posing import Arm, Foot, Motion, Pose, animate

_FIST = 85.0


def punching() -> Motion:
    """Step in, left foot forward: jab, cross, hook, a duck under the answer, and out again."""
    high = Arm((-0.07, 0.1, 0.27), (0.25, -1.0, 0.1), (-10.0, 0.0, 10.0), _FIST)
    chin = Arm((-0.1, 0.08, 0.2), (0.3, -1.0, -0.1), (-10.0, 0.0, 10.0), _FIST)
    guard = Pose(
        hips=(-0.03, 0.87, 0.05),
        turn=(6.0, -32.0, 0.0),
        spine=(14.0, -6.0, 0.0),
        head=(-8.0, 34.0, 2.0),
        left=high,
        right=chin,
        left_foot=Foot((0.1, 0.0, 0.3), -12.0, 2.0),
        right_foot=Foot((-0.16, 0.0, -0.12), -48.0, 18.0),
    )
    bounce = guard.but(hips=(-0.02, 0.9, 0.06), turn=(4.0, -36.0, 2.0), spine=(12.0, -8.0, 3.0))
    sink = guard.but(
        hips=(-0.05, 0.855, 0.03),
        turn=(6.0, -38.0, -3.0),
        left=Arm((-0.06, 0.06, 0.24), (0.3, -1.0, 0.0), (-10.0, 0.0, 10.0), _FIST),
    )
    reach = guard.but(
        hips=(-0.01, 0.865, 0.24),
        right=Arm((-0.04, 0.1, 0.24), (0.6, -1.0, 0.1), (10.0, 0.0, 10.0), _FIST),
        left_foot=Foot((0.1, 0.06, 0.48), -12.0, -4.0),
        right_foot=Foot((-0.16, 0.0, -0.12), -48.0, 38.0),
    )
    near = guard.but(
        hips=(-0.03, 0.87, 0.33),
        left_foot=Foot((0.1, 0.0, 0.58), -12.0, 2.0),
        right_foot=Foot((-0.16, 0.0, 0.16), -48.0, 18.0),
    )
    jab = near.but(
        hips=(0.01, 0.865, 0.38),
        turn=(8.0, -46.0, 2.0),
        spine=(14.0, -22.0, 4.0),
        head=(-8.0, 60.0, 0.0),
        left=Arm((0.38, 0.2, 0.27), (0.6, -0.8, -0.4), (65.0, 0.0, 0.0), _FIST),
        right=Arm((-0.12, 0.12, 0.17), (0.5, -1.0, 0.2), (20.0, 0.0, 10.0), _FIST),
        right_foot=Foot((-0.16, 0.0, 0.16), -50.0, 30.0),
    )
    load = near.but(
        hips=(-0.04, 0.85, 0.3),
        turn=(8.0, -44.0, -3.0),
        spine=(12.0, -14.0, -4.0),
        head=(-6.0, 50.0, 2.0),
        right=Arm((0.1, -0.06, 0.18), (0.7, -0.7, -0.5), (0.0, 0.0, 10.0), _FIST),
    )
    cross = near.but(
        hips=(0.03, 0.85, 0.4),
        turn=(10.0, 20.0, 4.0),
        spine=(16.0, 30.0, 8.0),
        head=(-10.0, -44.0, -6.0),
        left=chin,
        right=Arm((0.28, 0.18, 0.38), (0.6, -0.8, -0.4), (65.0, 0.0, 0.0), _FIST),
        right_foot=Foot((-0.16, 0.0, 0.16), -8.0, 48.0),
    )
    coil = near.but(
        hips=(0.05, 0.84, 0.38),
        turn=(10.0, 16.0, 8.0),
        spine=(16.0, 22.0, 8.0),
        head=(-10.0, -34.0, -6.0),
        left=Arm((0.08, -0.06, 0.22), (1.0, -0.5, -0.3), (0.0, 0.0, 10.0), _FIST),
        right=Arm((0.04, 0.06, 0.26), (1.0, -0.6, 0.0), (30.0, 0.0, 10.0), _FIST),
        right_foot=Foot((-0.16, 0.0, 0.16), -16.0, 40.0),
    )
    hook = near.but(
        hips=(-0.02, 0.86, 0.37),
        turn=(6.0, -48.0, -4.0),
        spine=(10.0, -30.0, -6.0),
        head=(-4.0, 68.0, 4.0),
        left=Arm((-0.1, 0.07, 0.33), (1.0, 0.1, 0.2), (20.0, 0.0, 0.0), _FIST),
        right=Arm((-0.13, 0.14, 0.14), (0.7, -1.0, 0.3), (0.0, 10.0, 10.0), _FIST),
        left_foot=Foot((0.1, 0.0, 0.58), -40.0, 34.0),
        right_foot=Foot((-0.16, 0.0, 0.16), -44.0, 14.0),
    )
    duck_left = near.but(
        hips=(0.08, 0.72, 0.33),
        turn=(22.0, -20.0, 12.0),
        spine=(26.0, 6.0, 18.0),
        head=(-34.0, 12.0, -14.0),
        right=Arm((-0.02, 0.16, 0.18), (1.0, -0.5, 0.3), (-20.0, 0.0, 0.0), _FIST),
    )
    duck_right = near.but(
        hips=(-0.12, 0.74, 0.31), turn=(18.0, -44.0, -10.0), spine=(22.0, -6.0, -18.0), head=(-28.0, 44.0, 14.0)
    )
    back = near.but(
        hips=(-0.04, 0.88, 0.16),
        right_foot=Foot((-0.16, 0.05, -0.04), -48.0, 20.0),
        left_foot=Foot((0.1, 0.0, 0.58), -12.0, 14.0),
    )
    return animate(
        [
            (0.0, guard),
            (0.25, bounce),
            (0.5, sink),
            (0.7, bounce),
            (0.9, sink),
            (1.08, reach),
            (1.25, jab),
            (1.48, load),
            (1.7, cross),
            (1.95, coil),
            (2.2, hook),
            (2.5, near),
            (2.8, duck_left),
            (3.15, duck_right),
            (3.5, near),
            (3.75, back),
            (4.0, guard.but(left_foot=Foot((0.1, 0.03, 0.36), -12.0, 6.0))),
            (4.25, sink),
            (4.5, bounce),
            (4.8, guard),
        ]
    )
