"""Quality of an animation against its reference, by the criteria of the papers.

Kushner, Modi, Miolane, "Learning Riemannian metrics for interpolating animations", equations 7 to 9.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.kinematics import world_pose
from geomstats_anim.rotations import Array

_SAME_TIME = 1e-2
"""Share of the spacing of frames within which two times are the same; of a second, where there is one frame."""


def quality(
    animation: Animation,
    reference: Animation,
    kind: str = "hyb",
    weights: str | ArrayLike | None = None,
    location_weight: float = 0.5,
) -> float:
    """Compare an animation with its reference, frame by frame; 0 where they agree.

    Parameters
    ----------
    animation, reference : Animation
        Same joints and times.
    kind : str
        "loc": squared distance of bone ends, square metres. "rot": angle between local rotations, radians.
        "hyb": location_weight loc + (1 - location_weight) rot.
        Optional, default: "hyb".
    weights : str or array-like, shape=[B]
        Weight of each joint in the sum; "depth" is its depth in the skeleton, 1 at a root.
        Optional, default: None, 1 everywhere.
    location_weight : float
        Optional, default: 0.5.

    Returns
    -------
    quality : float
        Sum over joints, mean over frames.

    Raises
    ------
    ValueError
        If joints or times differ, or there is no such kind.

    Examples
    --------
    >>> import numpy as np
    >>> from geomstats_anim import Animation, Skeleton, quality
    >>> skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    >>> still = Animation(skeleton, [0.0], [[[0, 0, 0, 1]]], [[[0, 0, 0]]])
    >>> turned = Animation(skeleton, [0.0], [[[0.6, 0, 0, 0.8]]], [[[0, 0, 0]]])
    >>> round(quality(turned, still, kind="rot"), 4)
    1.287
    """
    if animation.skeleton.joints != reference.skeleton.joints:
        raise ValueError("The two animations have different joints.")
    _check_times(animation.times, reference.times)
    shares = kind_shares(kind, location_weight)
    total = np.zeros(reference.n_joints)
    if shares.location:
        total += shares.location * (location_errors(animation, reference) ** 2).mean(axis=0)
    if shares.rotation:
        total += shares.rotation * rotation_errors(animation, reference).mean(axis=0)
    return float(total @ joint_weights(weights, reference.skeleton))


def _check_times(times: Array, expected: Array) -> None:
    """Raise if times, shape=[F], are further apart than a small part of the spacing of frames."""
    if len(times) != len(expected):
        raise ValueError(f"The two animations have different times: {len(times)} and {len(expected)} frames.")
    spacing = np.diff(expected).min(initial=np.inf)
    apart = np.abs(times - expected)
    if (apart > _SAME_TIME * min(spacing, 1.0)).any():
        worst = int(apart.argmax())
        raise ValueError(
            f"The two animations have different times: {times[worst]:g} s and {expected[worst]:g} s in frame {worst}."
        )


class Shares(NamedTuple):
    """Weights of the two criteria in a sum."""

    location: float
    rotation: float


def kind_shares(kind: str, location_weight: float = 0.5) -> Shares:
    """Look up the weights of location and rotation in a kind of quality.

    Raises
    ------
    ValueError
        If there is no such kind, or the weight is outside [0, 1].
    """
    if not 0.0 <= location_weight <= 1.0:
        raise ValueError(f"location_weight must be between 0 and 1, but it is {location_weight}.")
    shares = {
        "loc": Shares(1.0, 0.0),
        "rot": Shares(0.0, 1.0),
        "hyb": Shares(location_weight, 1.0 - location_weight),
    }
    if kind not in shares:
        raise ValueError(f"There is no quality {kind!r}; the kinds are {', '.join(shares)}.")
    return shares[kind]


def joint_weights(weights: str | ArrayLike | None, skeleton: Skeleton) -> Array:
    """Resolve the weights of joints.

    Parameters
    ----------
    weights : None, "depth" or array-like, shape=[B]
    skeleton : Skeleton

    Returns
    -------
    weights : array-like, shape=[B]

    Raises
    ------
    ValueError
        If there is not one number that is at least 0 for each joint.
    """
    if weights is None:
        return np.ones(skeleton.n_joints)
    if isinstance(weights, str):
        if weights != "depth":
            raise ValueError(f'weights must be None, "depth" or one number per joint, but it is {weights!r}.')
        return skeleton.depths.astype(np.float64)
    values = np.asarray(weights, dtype=np.float64)
    if values.shape != (skeleton.n_joints,) or not (values >= 0.0).all():
        raise ValueError(
            f"weights has shape {values.shape}, but {skeleton.n_joints} numbers that are at least 0 are needed."
        )
    return values


def rotation_errors(animation: Animation, reference: Animation) -> Array:
    """Return the angles in radians between local rotations, shape=[F, B]."""
    return quat.distance(reference.rotations, animation.rotations)


def location_errors(animation: Animation, reference: Animation) -> Array:
    """Return the distances in metres between bone ends, shape=[F, B]."""
    return np.linalg.norm(world_pose(animation).ends - world_pose(reference).ends, axis=-1)
