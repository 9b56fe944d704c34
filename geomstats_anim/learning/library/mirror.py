r"""Mirror images of motion: left and right change places, where the names and the bones of the rig allow it.

Let S be the reflection at the plane between both sides, A_b the orientation of joint b in the rest pose and m(b) its
counterpart. A vector v in the frame of b becomes F_b v in that of m(b), with

.. math:: F_b = A_{m(b)}^T S A_b

a rotation R_b becomes F_p R_b F_b^T, where p is the parent, and a vector of rotation c becomes - F_b c.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.kinematics import place
from geomstats_anim.rotations import Array

_SIDES = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("l", "r"), ("L", "R"))
"""Words anywhere in a name; letters that stand apart or come first."""

_TOLERANCE = 0.05
"""Largest difference of both sides of a rest pose, as a share of its size."""


@dataclass(frozen=True, eq=False)
class Mirror:
    """Mirroring of a rig.

    Parameters
    ----------
    counterpart : array-like of int, shape=[B]
        Of each joint; those in the middle are their own.
    frames : array-like, shape=[B, 3, 3]
        F_b, for vectors in the frame of a joint.
    parent_frames : array-like, shape=[B, 3, 3]
        F of the parent; S for a root.
    """

    counterpart: np.ndarray
    frames: Array
    parent_frames: Array

    def rotations(self, rotations: Array) -> Array:
        """Mirror rotations of all joints, shape=[..., B, 4]."""
        turned = self.parent_frames @ quat.to_matrix(rotations) @ self.frames.swapaxes(-1, -2)
        return np.asarray(quat.from_matrix(turned)[..., self.counterpart, :])

    def rotation_vectors(self, vectors: Array) -> Array:
        """Mirror vectors of rotation in the frames of the joints, shape=[..., B, 3]."""
        return np.asarray(-np.einsum("bij,...bj->...bi", self.frames, vectors)[..., self.counterpart, :])

    def animation(self, animation: Animation) -> Animation:
        """Mirror an animation."""
        moved = np.einsum("bij,...bj->...bi", self.parent_frames, animation.translations)[:, self.counterpart]
        scales = None if animation.scales is None else animation.scales[:, self.counterpart]
        turned = quat.make_continuous(self.rotations(animation.rotations))
        return Animation(animation.skeleton, animation.times, turned, moved, scales)


def mirror_of(skeleton: Skeleton, vertical: Array) -> Mirror | None:
    """Find how a rig is mirrored, from the names of its joints.

    Parameters
    ----------
    skeleton : Skeleton
    vertical : array-like, shape=[3]
        Unit vector upwards; the plane between both sides is upright.

    Returns
    -------
    mirror : Mirror or None
        None if names have no counterparts, or both sides of the rest pose differ.
    """
    counterpart = _counterparts(skeleton)
    if counterpart is None:
        return None
    rest = place(skeleton, skeleton.rest_rotations[None], skeleton.rest_translations[None])
    origins, orientations = rest.origins[0], _orientations(skeleton)
    across = (origins[counterpart] - origins)[counterpart > np.arange(skeleton.n_joints)].sum(axis=0)
    across -= across.dot(vertical) * vertical
    size = np.ptp(origins, axis=0).max()
    if np.linalg.norm(across) <= _TOLERANCE * size:
        return None
    across /= np.linalg.norm(across)
    reflection = np.eye(3) - 2.0 * np.outer(across, across)
    offset = (origins[counterpart] - origins @ reflection).mean(axis=0)
    if np.abs(origins[counterpart] - origins @ reflection - offset).max() > _TOLERANCE * size:
        return None
    frames = orientations[counterpart].swapaxes(-1, -2) @ reflection @ orientations
    parents = np.where((skeleton.parents >= 0)[:, None, None], frames[skeleton.parents], reflection)
    return Mirror(counterpart, frames, parents)


def _orientations(skeleton: Skeleton) -> Array:
    """Return the orientations of joints in the rest pose, shape=[B, 3, 3]."""
    found = quat.to_matrix(skeleton.rest_rotations).copy()
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent >= 0:
            found[joint] = found[parent] @ found[joint]
    return found


def _counterparts(skeleton: Skeleton) -> np.ndarray | None:
    """Pair joints by their own names, parents first; None if none is paired, or a side has a joint more."""
    own_names = [re.split("[/:|]", joint)[-1] for joint in skeleton.joints]
    counterpart = np.arange(skeleton.n_joints)
    for joint, parent in enumerate(skeleton.parents.tolist()):
        beside = counterpart[parent] if parent >= 0 else -1
        others = _other_sides(own_names[joint])
        found = [i for i in np.flatnonzero(skeleton.parents == beside) if own_names[i] in others]
        if len(found) == 1:
            counterpart[joint] = found[0]
        elif beside != parent:
            return None
    is_paired = (counterpart[counterpart] == np.arange(len(counterpart))).all()
    return counterpart if is_paired and (counterpart != np.arange(len(counterpart))).any() else None


def _other_sides(name: str) -> set[str]:
    """Return the names that the counterpart of a joint may have."""
    found = set()
    for left, right in _SIDES:
        side = f"({left}|{right})"
        for pattern in (side,) if len(left) > 1 else (f"(?<![a-zA-Z]){side}(?![a-zA-Z])", f"^{side}"):
            found.add(re.sub(pattern, lambda match: right if match[0] == left else left, name))  # noqa: B023, at once
    return found - {name}
