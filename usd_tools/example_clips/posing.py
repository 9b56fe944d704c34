"""From key poses to joint rotations: what an animator specifies, and the curves and limbs that follow from it.

A pose is told in anatomical terms. Turns are (bend, twist, lean) in degrees: forwards, to the left, to the left. An
arm or a leg is told by where its hand or foot is; two-bone inverse kinematics finds the shoulder and elbow, hip and
knee. One kind of curve joins everything.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly, PchipInterpolator
from scipy.spatial.transform import Rotation

from usd_tools.example_clips.biped import INDEX, NAMES, OFFSETS, forward_kinematics

Vector = tuple[float, float, float]

RATE = 30
"""Samples per second."""

GRAVITY = 9.81
"""Metres per second squared."""

_BALL_HEIGHT = OFFSETS[INDEX["Hips"], 1] + sum(
    OFFSETS[INDEX[f"Left{name}"], 1] for name in ("Thigh", "Shin", "Foot", "Toes")
)
_SIDES = (("Left", 1.0), ("Right", -1.0))

# Overlapping action: seconds by which a joint follows the pose, more along the chain.
_LAG = {"Chest": 0.02, "UpperChest": 0.04, "Neck": 0.05, "Head": 0.07}
_LAG |= {
    side + name: lag
    for side, _ in _SIDES
    for name, lag in (("Shoulder", 0.04), ("UpperArm", 0.05), ("ForeArm", 0.07), ("Hand", 0.1), ("Fingers", 0.12))
}

# Breathing and balance: amplitudes in degrees about x, y and z.
_SWAY = {"Spine": (0.5, 0.8, 0.6), "Chest": (0.9, 0.6, 0.5), "UpperChest": (0.8, 0.5, 0.5), "Neck": (0.8, 0.9, 0.6)}
_SWAY |= {"Head": (0.9, 1.2, 0.8)}
_SWAY |= {side + "UpperArm": (1.2, 1.0, 1.2) for side, _ in _SIDES}
_SWAY |= {side + "Hand": (1.5, 2.0, 2.0) for side, _ in _SIDES}


@dataclass(frozen=True)
class Arm:
    """An arm, described for the left; the right one is its mirror image.

    `hand` is where the wrist is, from the shoulder's place at rest, in the upper chest's frame: x outwards, metres.
    `elbow` is the direction in which the elbow points. `wrist` is (pronation, deviation towards the back, extension)
    in degrees; `curl` bends the fingers, degrees.
    """

    hand: Vector = (0.09, -0.505, 0.04)
    elbow: Vector = (0.4, 0.0, -1.0)
    wrist: Vector = (0.0, 0.0, 0.0)
    curl: float = 25.0


@dataclass(frozen=True)
class Foot:
    """A foot, described by its ball, so that the heel can rise while the ball stays.

    `ball` is where it is: (x, height above standing, z), metres. `yaw` turns the toes to the left and `pitch` lifts
    the heel, degrees; the toes stay flat while the ball is on the ground. A foot that changes place between two
    poses on the ground steps over. `knee` turns the knee to the left, degrees.
    """

    ball: Vector
    yaw: float = 0.0
    pitch: float = 0.0
    knee: float = 0.0

    @property
    def toes(self) -> float:
        """Return the angle by which the toes bend upwards, degrees."""
        return self.pitch if self.ball[1] == 0.0 else 0.0


@dataclass(frozen=True)
class Pose:
    """A whole body. `hips` None: in flight, falling freely between the neighbouring poses."""

    hips: Vector | None = (0.0, 0.943, 0.0)
    turn: Vector = (0.0, 0.0, 0.0)
    spine: Vector = (0.0, 0.0, 0.0)
    head: Vector = (0.0, 0.0, 0.0)
    left: Arm = Arm()
    right: Arm = Arm()
    left_foot: Foot = Foot((0.1, 0.0, 0.12), yaw=8.0)
    right_foot: Foot = Foot((-0.1, 0.0, 0.12), yaw=-8.0)

    def but(self, **changes: object) -> Pose:
        """Return this pose with some parts changed."""
        return replace(self, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Motion:
    """Samples of a motion, RATE per second.

    `rotations` (F, 24, 4) are joint-local unit quaternions, scalar last, without sign flips; `hips` (F, 3) is the
    root's track in metres; `box`, if anything is sat upon, its lowest and highest corner in metres.
    """

    rotations: np.ndarray
    hips: np.ndarray
    box: tuple[Vector, Vector] | None = None


Keys = list[tuple[float, Pose]]
"""Poses and when they are struck, seconds; the first at 0, the last where the clip ends."""


def smooth(
    keys: ArrayLike,
    values: ArrayLike,
    times: ArrayLike,
    slopes: dict[int, ArrayLike] | None = None,
    fall: ArrayLike = 0.0,
) -> np.ndarray:
    """Join values by a curve with continuous acceleration that holds still between equal values and never overshoots.

    Parameters
    ----------
    keys : (K,)
        When the values are reached, seconds.
    values : (K, ...)
        The values.
    times : (F,)
        When to evaluate, seconds; the ends are held.
    slopes : dict
        Slopes to prescribe at some of the keys.
    fall : float or (...)
        Second derivative at those keys; it is zero at the others.

    Returns
    -------
    curve : (F, ...)
        The curve at the times.
    """
    keys, values = np.asarray(keys, dtype=float), np.asarray(values, dtype=float)
    first = PchipInterpolator(keys, values).derivative()(keys)
    second = np.zeros_like(values)
    for key, slope in (slopes or {}).items():
        first[key], second[key] = slope, fall
    return BPoly.from_derivatives(keys, np.stack([values, first, second], axis=1))(np.clip(times, keys[0], keys[-1]))


def _turns(degrees: ArrayLike) -> Rotation:
    """Make rotations of (..., 3) bends, twists and leans: lean first, then bend, then twist."""
    bend, twist, lean = np.moveaxis(np.asarray(degrees, dtype=float), -1, 0)
    return Rotation.from_euler("YXZ", np.stack([twist, bend, -lean], axis=-1), degrees=True)


def _mirrored(degrees: ArrayLike, mirror: float) -> np.ndarray:
    """Mirror an arm's rotation vectors at the plane x = 0."""
    return np.asarray(degrees, dtype=float) * (1.0, mirror, mirror)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def two_bones(
    reach: np.ndarray, pole: np.ndarray, bones: tuple[float, float], rest: ArrayLike, rest_pole: ArrayLike
) -> tuple[Rotation, Rotation]:
    """Bend a limb of two bones so that it ends where it should.

    Near full length the limb straightens softly and falls short, for a limb that snaps straight looks like a fault.

    Parameters
    ----------
    reach : (N, 3)
        From the limb's beginning to its end, metres.
    pole : (N, 3)
        The direction in which its middle points.
    bones : tuple of float
        The bones' lengths, metres.
    rest, rest_pole : (3,)
        The limb's and the pole's direction where both rotations are the identity.

    Returns
    -------
    upper, lower : Rotation
        The bones' orientations, N each.
    """
    upper, lower = bones
    distance = np.linalg.norm(reach, axis=-1)
    limit, soft = 0.99 * (upper + lower), 0.0095 * (upper + lower)
    excess = np.maximum(distance - limit, 0.0)
    length = np.where(excess > 0.0, limit + soft * (1.0 - np.exp(-excess / soft)), distance)
    length = np.maximum(length, 1.02 * abs(upper - lower) + 0.05)
    ahead = _unit(reach)
    side = _unit(pole - np.sum(pole * ahead, axis=-1, keepdims=True) * ahead)
    hinge = np.cross(side, ahead)
    cosine = (upper**2 + length**2 - lower**2) / (2.0 * upper * length)
    first = cosine[:, None] * ahead + np.sqrt(1.0 - cosine**2)[:, None] * side
    second = _unit(length[:, None] * ahead - upper * first)

    def orient(bone: np.ndarray, axis: np.ndarray) -> np.ndarray:
        return np.stack([bone, axis, np.cross(bone, axis)], axis=-1)

    rest, rest_pole = np.asarray(rest, dtype=float), np.asarray(rest_pole, dtype=float)
    back = orient(rest, np.cross(rest_pole, rest)).T
    return Rotation.from_matrix(orient(first, hinge) @ back), Rotation.from_matrix(orient(second, hinge) @ back)


def _pose_arm(arm: Arm, side: str, mirror: float) -> dict[str, Rotation]:
    """Find an arm's local rotations."""
    outwards = np.array([mirror, 1.0, 1.0])
    rest = np.array([mirror, 0.0, 0.0])
    hand, elbow = outwards * arm.hand, outwards * arm.elbow
    swing = np.cross(rest, _unit(hand))
    angle = np.arctan2(np.linalg.norm(swing), rest @ _unit(hand))
    collar = Rotation.from_rotvec(0.15 * angle * swing / max(np.linalg.norm(swing), 1e-9))
    offset = OFFSETS[INDEX[side + "UpperArm"]]
    reach = collar.inv().apply(hand + offset - collar.apply(offset))
    bones = (abs(OFFSETS[INDEX[side + "ForeArm"], 0]), abs(OFFSETS[INDEX[side + "Hand"], 0]))
    upper, lower = two_bones(reach[None], collar.inv().apply(elbow)[None], bones, rest, (0.0, 0.0, -1.0))
    pronation, deviation, extension = arm.wrist
    return {
        side + "Shoulder": collar,
        side + "UpperArm": upper[0],
        side + "ForeArm": upper[0].inv() * lower[0] * Rotation.from_euler("x", 0.6 * pronation, degrees=True),
        side + "Hand": Rotation.from_rotvec(_mirrored((0.4 * pronation, deviation, extension), mirror), degrees=True),
        side + "Fingers": Rotation.from_rotvec(_mirrored((0.0, 0.0, -arm.curl), mirror), degrees=True),
    }


def _pose_joints(pose: Pose) -> dict[str, Rotation]:
    """Find the local rotations of all joints but the hips and the legs."""
    spine, head = np.array(pose.spine), np.array(pose.head)
    return {
        "Spine": _turns(0.35 * spine),
        "Chest": _turns(0.35 * spine),
        "UpperChest": _turns(0.3 * spine),
        "Neck": _turns(0.45 * head),
        "Head": _turns(0.55 * head),
        **_pose_arm(pose.left, "Left", 1.0),
        **_pose_arm(pose.right, "Right", -1.0),
    }


def _step_over(moments: list[float], feet: list[Foot], times: np.ndarray) -> np.ndarray:
    """Lift a foot that changes place between two poses on the ground: heights (F,), metres."""
    lift = np.zeros(len(times))
    for key, (foot, later) in enumerate(itertools.pairwise(feet)):
        distance = np.linalg.norm(np.subtract(later.ball, foot.ball))
        if distance > 0.0 and foot.ball[1] == later.ball[1] == 0.0:
            part = np.clip((times - moments[key]) / (moments[key + 1] - moments[key]), 0.0, 1.0)
            lift += (0.02 + 0.15 * distance) * (4.0 * part * (1.0 - part)) ** 3
    return lift


def _pose_legs(keys: Keys, times: np.ndarray, hips: np.ndarray, turn: Rotation) -> dict[str, Rotation]:
    """Find the legs' local rotations from the feet's curves and the hips' track, frame by frame."""
    moments = [time for time, _ in keys]
    found = {}
    for side, _ in _SIDES:
        feet = [pose.left_foot if side == "Left" else pose.right_foot for _, pose in keys]
        ball = smooth(moments, [foot.ball for foot in feet], times) + (0.0, _BALL_HEIGHT, 0.0)
        ball[:, 1] += _step_over(moments, feet, times)
        yaw, pitch, toes, knee = smooth(moments, [(f.yaw, f.pitch, f.toes, f.knee) for f in feet], times).T
        foot = Rotation.from_euler("YX", np.stack([yaw, pitch], axis=1), degrees=True)
        ankle = ball - foot.apply(OFFSETS[INDEX[side + "Toes"]])
        reach = turn.inv().apply(ankle - hips) - OFFSETS[INDEX[side + "Thigh"]]
        pole = turn.inv().apply(Rotation.from_euler("Y", (yaw + knee)[:, None], degrees=True).apply((0.0, 0.5, 1.0)))
        bones = (-OFFSETS[INDEX[side + "Shin"], 1], -OFFSETS[INDEX[side + "Foot"], 1])
        thigh, shin = two_bones(reach, pole, bones, (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
        found[side + "Thigh"] = thigh
        found[side + "Shin"] = thigh.inv() * shin
        found[side + "Foot"] = shin.inv() * turn.inv() * foot
        found[side + "Toes"] = Rotation.from_euler("X", -toes[:, None], degrees=True)
    return found


def _sway(times: np.ndarray, joint: int) -> Rotation:
    """Breathe and balance: slow rotations about all three axes, each joint in a phase of its own."""
    phase = 2.4 * joint + np.array([0.0, 2.1, 4.2])
    waves = np.sin(2.0 * np.pi * np.array([0.45, 0.31, 0.38]) * times[:, None] + phase)
    return Rotation.from_rotvec(waves * _SWAY.get(NAMES[joint], (0.0, 0.0, 0.0)), degrees=True)


def _drag(rotations: np.ndarray, hips: np.ndarray) -> None:
    """Let the hands trail behind the turning forearms, as loose wrists do."""
    _, orientations = forward_kinematics(rotations, hips)
    for side, _ in _SIDES:
        forearm = Rotation.from_matrix(orientations[:, INDEX[side + "ForeArm"]])
        speed = np.zeros((len(rotations), 3))
        speed[1:-1] = (forearm[:-2].inv() * forearm[2:]).as_rotvec() * (0.5 * RATE)
        speed[:, 0] = 0.0  # a forearm's own twist takes the hand along
        trail = -0.03 * speed
        trail /= 1.0 + np.linalg.norm(trail, axis=1, keepdims=True) / 0.6
        hand = INDEX[side + "Hand"]
        rotations[:, hand] = (Rotation.from_rotvec(trail) * Rotation.from_quat(rotations[:, hand])).as_quat()


def _track_hips(keys: Keys, times: np.ndarray) -> np.ndarray:
    """Join the hips' positions; between poses with a flight in between they follow a parabola exactly."""
    grounded = [key for key, (_, pose) in enumerate(keys) if pose.hips is not None]
    moments = np.array([keys[key][0] for key in grounded])
    values = np.array([keys[key][1].hips for key in grounded])
    gravity = np.array([0.0, -GRAVITY, 0.0])
    slopes = {}
    for start in np.flatnonzero(np.diff(grounded) > 1):
        duration = moments[start + 1] - moments[start]
        mean = (values[start + 1] - values[start]) / duration
        slopes[start] = mean - 0.5 * duration * gravity
        slopes[start + 1] = mean + 0.5 * duration * gravity
    return smooth(moments, values, times, slopes, gravity)


def animate(keys: Keys, feet_follow_hips: bool = False) -> Motion:
    """Turn key poses into samples.

    Parameters
    ----------
    keys : list of (float, Pose)
        The poses and when they are struck, seconds.
    feet_follow_hips : bool
        The feet are told in the hips' frame rather than in the world's.

    Returns
    -------
    motion : Motion
        The samples, from the first pose to the last.
    """
    times = np.arange(round(keys[-1][0] * RATE) + 1) / RATE
    moments = [time for time, _ in keys]
    hips = _track_hips(keys, times)
    # Angles rather than rotations, for no rotation tells how many full turns led to it.
    turn = _turns(smooth(moments, [pose.turn for _, pose in keys], times))
    posed = [_pose_joints(pose) for _, pose in keys]
    rotations = np.zeros((len(times), len(NAMES), 4))
    rotations[:, INDEX["Hips"]] = turn.as_quat()
    for name in posed[0]:
        quats = continuous(np.array([joints[name].as_quat() for joints in posed]))
        curve = Rotation.from_quat(smooth(moments, quats, times - _LAG.get(name, 0.0)))
        rotations[:, INDEX[name]] = (curve * _sway(times, INDEX[name])).as_quat()
    fixed = (np.zeros(3), Rotation.identity(len(times))) if feet_follow_hips else (hips, turn)
    for name, rotation in _pose_legs(keys, times, *fixed).items():
        rotations[:, INDEX[name]] = rotation.as_quat()
    _drag(rotations, hips)
    return Motion(continuous(rotations), hips)


def continuous(quats: np.ndarray) -> np.ndarray:
    """Flip the signs of quaternions (F, ..., 4) so that none is far from the one before it."""
    flips = np.sum(quats[1:] * quats[:-1], axis=-1, keepdims=True) < 0.0
    signs = np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
    return np.concatenate([quats[:1], signs * quats[1:]])
