"""A standing jump."""

from __future__ import annotations

from usd_tools.example_clips.posing import Arm, Foot, Motion, Pose, animate


def jumping() -> Motion:
    """Jump from standing, a quarter turn to the left: swing, crouch, flight with the knees drawn up, landing, rise."""
    start = Pose()
    reach = start.but(
        hips=(0.0, 0.945, 0.02),
        spine=(-6.0, -8.0, 0.0),
        head=(-6.0, -4.0, 0.0),
        left=Arm((0.12, 0.2, 0.44), (0.8, -0.6, 0.0), (20.0, 0.0, 10.0)),
        right=Arm((0.2, 0.12, 0.44), (0.8, -0.6, 0.0), (20.0, 0.0, 10.0)),
    )
    crouch = start.but(
        hips=(-0.01, 0.6, -0.1),
        turn=(38.0, -14.0, -2.0),
        spine=(34.0, -18.0, -4.0),
        head=(-40.0, 14.0, 4.0),
        left=Arm((0.16, -0.4, -0.24), (0.4, 0.2, -1.0), (30.0, 0.0, -20.0)),
        right=Arm((0.22, -0.36, -0.3), (0.4, 0.2, -1.0), (30.0, 0.0, -20.0)),
        left_foot=Foot((0.1, 0.0, 0.12), 8.0, 8.0),
        right_foot=Foot((-0.1, 0.0, 0.12), -8.0, 8.0),
    )
    takeoff = start.but(
        hips=(0.02, 1.01, 0.1),
        turn=(6.0, 14.0, 2.0),
        spine=(-6.0, 12.0, 2.0),
        head=(-8.0, 10.0, 0.0),
        left=Arm((0.2, 0.3, 0.36), (0.9, -0.5, 0.0), (30.0, 0.0, 0.0)),
        right=Arm((0.06, 0.36, 0.36), (0.9, -0.5, 0.0), (30.0, 0.0, 0.0)),
        left_foot=Foot((0.1, 0.0, 0.12), 8.0, 50.0),
        right_foot=Foot((-0.1, 0.0, 0.12), -8.0, 52.0),
    )
    tuck = takeoff.but(
        hips=None,
        turn=(12.0, 50.0, -6.0),
        spine=(24.0, 16.0, -6.0),
        head=(-16.0, 14.0, 4.0),
        left=Arm((0.36, 0.16, 0.2), (0.5, -0.3, -1.0), (20.0, 0.0, 20.0), 10.0),
        right=Arm((0.32, 0.24, 0.24), (0.5, -0.3, -1.0), (20.0, 0.0, 20.0), 10.0),
        left_foot=Foot((0.24, 0.62, 0.42), 50.0, 34.0, 10.0),
        right_foot=Foot((0.1, 0.56, 0.52), 44.0, 38.0, -10.0),
    )
    spring = takeoff.but(
        hips=None,
        turn=(4.0, 26.0, -2.0),
        left_foot=Foot((0.14, 0.25, 0.18), 18.0, 62.0),
        right_foot=Foot((-0.06, 0.24, 0.22), 4.0, 64.0),
    )
    left, right = Foot((0.34, 0.0, 0.58), 96.0), Foot((0.36, 0.0, 0.8), 80.0)
    landing = start.but(
        hips=(0.2, 0.93, 0.68),
        turn=(10.0, 84.0, 2.0),
        spine=(16.0, 4.0, 2.0),
        head=(-6.0, 2.0, -2.0),
        left=Arm((0.36, -0.06, 0.24), (0.5, 0.0, -1.0), (10.0, 0.0, 20.0), 15.0),
        right=Arm((0.32, -0.02, 0.28), (0.5, 0.0, -1.0), (10.0, 0.0, 20.0), 15.0),
        left_foot=Foot(left.ball, left.yaw, 22.0),
        right_foot=Foot(right.ball, right.yaw, 22.0),
    )
    prepare = landing.but(
        hips=None,
        turn=(8.0, 79.0, 0.0),
        left_foot=Foot((0.33, 0.16, 0.57), 91.0, 28.0),
        right_foot=Foot((0.34, 0.15, 0.79), 77.0, 28.0),
    )
    absorb = landing.but(
        hips=(0.19, 0.6, 0.69),
        turn=(42.0, 96.0, -4.0),
        spine=(32.0, 14.0, -6.0),
        head=(-42.0, -8.0, 4.0),
        left=Arm((0.24, -0.22, 0.34), (0.9, 0.0, -0.8), (10.0, 0.0, 20.0)),
        right=Arm((0.2, -0.3, 0.3), (0.9, 0.0, -0.8), (10.0, 0.0, 20.0)),
        left_foot=left,
        right_foot=right,
    )
    rise = absorb.but(
        hips=(0.235, 0.945, 0.69),
        turn=(-3.0, 88.0, 2.0),
        spine=(-6.0, -4.0, 2.0),
        head=(4.0, -6.0, 0.0),
        left=Arm((0.14, -0.48, -0.02), (0.4, 0.0, -1.0)),
        right=Arm((0.12, -0.48, 0.04), (0.4, 0.0, -1.0)),
    )
    rest = start.but(hips=(0.23, 0.943, 0.69), turn=(0.0, 88.0, 0.0), left_foot=left, right_foot=right)
    off = 1.7
    down = off + 0.57
    return animate(
        [
            (0.0, start),
            (0.2, start),
            (0.75, reach),
            (1.32, crouch),
            (off, takeoff),
            (off + 0.12, spring),
            (off + 0.3, tuck),
            (down - 0.06, prepare),
            (down, landing),
            (down + 0.33, absorb),
            (down + 0.6, absorb.but(hips=(0.21, 0.66, 0.69), turn=(36.0, 92.0, 2.0), spine=(28.0, -4.0, 2.0))),
            (down + 1.15, rise),
            (down + 1.6, rest),
            (4.3, rest),
        ]
    )
