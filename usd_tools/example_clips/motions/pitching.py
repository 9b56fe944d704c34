"""A baseball pitch."""

from __future__ import annotations

from usd_tools.example_clips.posing import Arm, Foot, Motion, Pose, animate


def pitching() -> Motion:
    """Pitch a baseball towards +z with the right hand: wind-up, leg lift, stride, throw, follow-through."""
    together = Arm((-0.11, -0.16, 0.24), (0.5, -1.0, -0.2), curl=45.0)
    ready = Pose(
        hips=(0.0, 0.94, 0.0),
        spine=(6.0, 0.0, 0.0),
        head=(4.0, 0.0, 0.0),
        left=together,
        right=together,
        left_foot=Foot((0.1, 0.0, 0.12), 6.0),
        right_foot=Foot((-0.1, 0.0, 0.12), -8.0),
    )
    rock = ready.but(
        hips=(0.03, 0.915, -0.1),
        turn=(-3.0, 8.0, 3.0),
        spine=(-4.0, 6.0, 4.0),
        head=(6.0, -12.0, -4.0),
        left=Arm((-0.1, 0.12, 0.3), (1.0, -0.5, 0.1), curl=45.0),
        right=Arm((-0.1, 0.12, 0.3), (1.0, -0.5, 0.1), curl=45.0),
        left_foot=Foot((0.14, 0.0, -0.2), 20.0, pitch=12.0),
        right_foot=Foot((-0.1, 0.0, 0.12), -25.0),
    )
    pivot = Foot((-0.1, 0.0, 0.12), -82.0)
    gather = ready.but(
        hips=(-0.03, 0.93, 0.06),
        turn=(0.0, -55.0, 0.0),
        spine=(4.0, -10.0, 0.0),
        head=(2.0, 50.0, 0.0),
        left_foot=Foot((0.12, 0.22, 0.1), -40.0, pitch=25.0),
        right_foot=pivot,
    )
    lift = ready.but(
        hips=(-0.015, 0.925, 0.075),
        turn=(-6.0, -100.0, -4.0),
        spine=(12.0, -22.0, 6.0),
        head=(0.0, 85.0, 4.0),
        left=Arm((-0.1, -0.06, 0.24), (0.6, -1.0, 0.0), curl=45.0),
        right=Arm((-0.1, -0.06, 0.24), (0.6, -1.0, 0.0), curl=45.0),
        left_foot=Foot((-0.22, 0.5, 0.24), -98.0, pitch=22.0),
        right_foot=pivot,
    )
    drive = lift.but(
        hips=(-0.05, 0.83, 0.3),
        turn=(0.0, -92.0, 4.0),
        spine=(8.0, -14.0, -6.0),
        head=(0.0, 85.0, 0.0),
        left=Arm((0.3, -0.18, 0.12), (0.2, -0.6, -1.0), (20.0, 0.0, 0.0), 40.0),
        right=Arm((0.16, -0.44, 0.02), (0.3, 0.0, -1.0), (10.0, 0.0, 10.0), 50.0),
        left_foot=Foot((-0.12, 0.14, 0.75), -60.0, pitch=10.0),
        right_foot=Foot((-0.1, 0.0, 0.12), -82.0, pitch=8.0),
    )
    land = Foot((0.06, 0.0, 1.18), -6.0)
    cock = drive.but(
        hips=(0.0, 0.74, 0.62),
        turn=(4.0, -45.0, 6.0),
        spine=(-8.0, -36.0, -6.0),
        head=(4.0, 70.0, -4.0),
        left=Arm((0.42, 0.05, 0.18), (0.0, -0.6, -1.0), (50.0, 0.0, 0.0), 45.0),
        right=Arm((0.3, 0.2, -0.12), (1.0, -0.3, -0.4), (0.0, 0.0, 25.0), 50.0),
        left_foot=land,
        right_foot=Foot((-0.1, 0.0, 0.12), -70.0, pitch=35.0),
    )
    layback = cock.but(
        hips=(0.02, 0.73, 0.74),
        turn=(8.0, -5.0, 8.0),
        spine=(-12.0, -14.0, 4.0),
        head=(6.0, 22.0, -6.0),
        left=Arm((0.16, -0.12, 0.24), (0.7, -0.6, -0.6), (20.0, 0.0, 0.0), 50.0),
        right=Arm((0.28, 0.1, -0.2), (1.0, 0.1, 0.1), (0.0, 0.0, 45.0), 50.0),
        right_foot=Foot((-0.1, 0.0, 0.12), -45.0, pitch=55.0),
    )
    release = layback.but(
        hips=(0.03, 0.75, 0.82),
        turn=(16.0, 12.0, 12.0),
        spine=(18.0, 14.0, 10.0),
        head=(-12.0, -12.0, -10.0),
        left=Arm((0.04, -0.24, 0.16), (0.8, -0.5, -0.8), (0.0, 0.0, 0.0), 55.0),
        right=Arm((0.24, 0.26, 0.34), (1.0, -0.3, 0.0), (30.0, 0.0, -20.0), 30.0),
        right_foot=Foot((-0.12, 0.1, 0.26), -20.0, pitch=64.0),
    )
    follow = release.but(
        hips=(0.04, 0.77, 0.93),
        turn=(34.0, 30.0, 8.0),
        spine=(42.0, 24.0, 8.0),
        head=(-34.0, -26.0, -6.0),
        left=Arm((0.16, -0.24, 0.16), (0.5, -1.0, -0.5), (0.0, 0.0, 0.0), 50.0),
        right=Arm((-0.28, -0.3, 0.26), (0.8, -0.2, 0.6), (75.0, 0.0, -15.0), 30.0),
        right_foot=Foot((-0.18, 0.24, 0.68), -5.0, pitch=64.0),
    )
    step = follow.but(
        hips=(0.0, 0.82, 1.1),
        turn=(20.0, 20.0, -2.0),
        spine=(26.0, 12.0, -4.0),
        head=(-26.0, -22.0, 0.0),
        left=Arm((0.12, -0.36, 0.2), (0.6, -0.5, -1.0), curl=45.0),
        right=Arm((-0.08, -0.38, 0.24), (1.0, 0.0, -0.4), (40.0, 0.0, 0.0), 30.0),
        right_foot=Foot((-0.24, 0.0, 1.3), -14.0),
    )
    field = step.but(
        hips=(-0.08, 0.88, 1.16),
        turn=(6.0, 2.0, 0.0),
        spine=(12.0, 0.0, 0.0),
        head=(-10.0, 0.0, 0.0),
        left=Arm((0.06, -0.3, 0.3), (0.8, -0.3, -1.0), (30.0, 0.0, 0.0), 45.0),
        right=Arm((0.06, -0.34, 0.28), (0.8, -0.3, -1.0), (30.0, 0.0, 0.0), 30.0),
    )
    return animate(
        [
            (0.0, ready),
            (0.3, ready),
            (0.85, rock),
            (1.35, gather),
            (1.8, lift),
            (2.05, lift.but(hips=(-0.02, 0.915, 0.1), turn=(-4.0, -104.0, -2.0))),
            (2.45, drive),
            (2.8, cock),
            (2.97, layback),
            (3.12, release),
            (3.4, follow),
            (3.85, step),
            (4.4, field),
            (4.7, field),
        ]
    )
