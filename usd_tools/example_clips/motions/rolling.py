"""Two rolls forward."""

from __future__ import annotations

from dataclasses import replace

from usd_tools.example_clips.contact import roll_on_ground
from usd_tools.example_clips.posing import Arm, Foot, Motion, Pose, Vector, animate

_LOOSE = Arm()


def rolling() -> Motion:
    """Crouch, roll forward twice over the shoulders, and stand up."""

    def feet(y: float, z: float, pitch: float, apart: float = 0.09, left: Vector = (0.0, 0.0, 0.0)) -> dict[str, Foot]:
        """Place the feet in the hips' frame, the left one further by `left`."""
        u, v, w = left
        return {
            "left_foot": Foot((apart + u, y + v - 0.96, z + w), 4.0 + 60.0 * u, pitch - 60.0 * w, 8.0 + 150.0 * u),
            "right_foot": Foot((-apart, y - 0.96, z), -4.0, pitch, -8.0),
        }

    stand = Pose(hips=(0.0, 0.0, 0.0)).but(**feet(0.03, 0.12, 0.0))
    squat = stand.but(
        turn=(30.0, 0.0, 0.0),
        spine=(30.0, 8.0, 0.0),
        head=(-20.0, 0.0, 0.0),
        left=Arm((0.1, 0.0, 0.46), (1.0, -0.3, 0.0), (10.0, 0.0, 30.0), 5.0),
        right=Arm((0.1, -0.04, 0.44), (1.0, -0.3, 0.0), (10.0, 0.0, 30.0), 5.0),
        **feet(0.48, 0.3, -30.0),
    )
    reach = squat.but(
        turn=(78.0, 8.0, 6.0),
        spine=(46.0, 12.0, 4.0),
        head=(20.0, 0.0, 0.0),
        left=Arm((0.08, 0.16, 0.4), (1.0, 0.0, 0.0), (10.0, 0.0, 40.0), 5.0),
        right=Arm((0.06, 0.2, 0.36), (1.0, 0.0, 0.0), (10.0, 0.0, 40.0), 5.0),
        **feet(0.46, 0.34, -30.0),
    )
    shoulder = reach.but(
        turn=(140.0, 14.0, 14.0),
        spine=(66.0, 16.0, 10.0),
        head=(56.0, 10.0, 6.0),
        left=Arm((0.1, 0.18, 0.24), (1.0, 0.0, 0.2), (10.0, 0.0, 30.0), 10.0),
        right=Arm((-0.02, 0.16, 0.18), (1.0, 0.2, 0.2), (10.0, 0.0, 20.0), 10.0),
        **feet(0.46, 0.38, 20.0, 0.07, (0.06, -0.16, -0.12)),
    )
    hug = Arm((0.0, -0.26, 0.36), (1.0, 0.0, -0.2), (20.0, 0.0, 0.0), 45.0)
    back = shoulder.but(
        turn=(230.0, 4.0, -8.0),
        spine=(70.0, -10.0, -8.0),
        head=(52.0, -4.0, -4.0),
        left=hug,
        right=hug,
        **feet(0.58, 0.38, 20.0, 0.12, (-0.06, -0.05, 0.08)),
    )
    seat = back.but(
        turn=(310.0, -4.0, -4.0),
        spine=(62.0, -8.0, -4.0),
        head=(30.0, 0.0, 0.0),
        **feet(0.62, 0.24, 30.0, 0.11, (0.04, -0.06, 0.0)),
    )
    feet_down = seat.but(
        turn=(385.0, 0.0, 2.0),
        spine=(56.0, 4.0, 2.0),
        head=(10.0, 0.0, 0.0),
        left=Arm((0.08, -0.1, 0.42), (1.0, -0.2, 0.0), (10.0, 0.0, 30.0), 10.0),
        right=Arm((0.08, -0.1, 0.42), (1.0, -0.2, 0.0), (10.0, 0.0, 30.0), 10.0),
        **feet(0.56, 0.28, -20.0),
    )

    def flipped(foot: Foot) -> Foot:
        x, y, z = foot.ball
        return Foot((-x, y, z), -foot.yaw, foot.pitch, -foot.knee)

    def again(pose: Pose) -> Pose:
        """Return the mirror image of a pose, a full turn later."""
        bend, twist, lean = pose.turn
        return pose.but(
            turn=(bend + 360.0, -twist, -lean),
            spine=(pose.spine[0], -pose.spine[1], -pose.spine[2]),
            head=(pose.head[0], -pose.head[1], -pose.head[2]),
            left=pose.right,
            right=pose.left,
            left_foot=flipped(pose.right_foot),
            right_foot=flipped(pose.left_foot),
        )

    up = again(squat).but(turn=(750.0, 0.0, 0.0), left=_LOOSE, right=_LOOSE)
    end = stand.but(turn=(720.0, 0.0, 0.0))
    motion = animate(
        [
            (0.0, stand),
            (0.2, stand),
            (0.75, squat),
            (1.05, reach),
            (1.35, shoulder),
            (1.7, back),
            (2.0, seat),
            (2.4, feet_down),
            (2.72, again(reach)),
            (3.02, again(shoulder)),
            (3.37, again(back)),
            (3.67, again(seat)),
            (4.07, again(feet_down)),
            (4.45, up),
            (5.05, end),
            (5.3, end),
        ],
        feet_follow_hips=True,
    )
    return replace(motion, hips=roll_on_ground(motion.rotations))
