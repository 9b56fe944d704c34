r"""Mirror images of motion: left and right change places, where the names and the bones of the rig allow it.

Let S be the reflection at the plane between both sides, A_b the orientation of joint b in a pose with two sides and
m(b) its counterpart. A vector v in the frame of b becomes F_b v in that of m(b), with

.. math:: F_b = A_{m(b)}^T S A_b

a rotation R_b becomes F_p R_b F_b^T, where p is the parent, and a vector of rotation c becomes - F_b c. The pose is the
rest pose, or, where that has no two sides, the usual pose of the clips: it is only about the same on both sides, so F_b
is rounded to the nearest that exchanges axes or turns them round, as rigs have it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.kinematics import place
from geomstats_anim.learning.library.parts import body_parts
from geomstats_anim.rotations import Array

_SIDES = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("l", "r"), ("L", "R"))
"""Words anywhere in a name; letters that stand apart or come first."""

_TOLERANCE = 0.05
"""Largest difference of both sides of a rest pose, as a share of its size."""

_AXES = 0.4
"""Largest difference of an entry of F from the nearest whole number."""


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

    @cached_property
    def _turns(self) -> tuple[Array, Array]:
        """Return -F of the parents, and the inverse of -F: reflections turned round are rotations, shape=[B, 4]."""
        return quat.from_matrix(-self.parent_frames), quat.conjugate(quat.from_matrix(-self.frames))

    def rotations(self, rotations: Array) -> Array:
        """Mirror rotations of all joints, shape=[..., B, 4]."""
        before, after = self._turns
        return np.asarray(quat.multiply(quat.multiply(before, rotations), after)[..., self.counterpart, :])

    def rotation_vectors(self, vectors: Array) -> Array:
        """Mirror vectors of rotation in the frames of the joints, shape=[..., B, 3]."""
        by_joint = vectors.reshape(-1, *vectors.shape[-2:]).swapaxes(0, 1) @ -self.frames.swapaxes(-1, -2)
        return np.asarray(by_joint[self.counterpart].swapaxes(0, 1).reshape(vectors.shape))

    def animation(self, animation: Animation) -> Animation:
        """Mirror an animation."""
        moved = np.einsum("bij,...bj->...bi", self.parent_frames, animation.translations)[:, self.counterpart]
        scales = None if animation.scales is None else animation.scales[:, self.counterpart]
        turned = quat.make_continuous(self.rotations(animation.rotations))
        return Animation(animation.skeleton, animation.times, turned, moved, scales)


def mirror_of(skeleton: Skeleton, vertical: Array, usual: Array | None = None) -> Mirror | None:
    """Find how a rig is mirrored, from the names of its joints and a pose with two sides.

    Parameters
    ----------
    skeleton : Skeleton
    vertical : array-like, shape=[3]
        Unit vector upwards; the plane between both sides is upright.
    usual : array-like, shape=[B, 4]
        Rotations of a pose that is about the same on both sides (`usual_pose`), used where the rest pose is not.
        Optional, default: None, only the rest pose.

    Returns
    -------
    mirror : Mirror or None
        None if names have no counterparts, or both sides of the poses differ.
    """
    counterpart = _counterparts(skeleton)
    if counterpart is None:
        return None
    found = _mirror_at_rest(skeleton, vertical, counterpart)
    return found if found is not None or usual is None else _mirror_in_use(skeleton, vertical, counterpart, usual)


def usual_pose(rotations: Array) -> Array:
    """Return the mean rotations of joints, shape=[B, 4], over the frames of clips, shape=[F, B, 4].

    The means are chordal (Markley et al., "Averaging quaternions", JGCD 2007, eq. 12).
    """
    _, vectors = np.linalg.eigh(np.einsum("fbi,fbj->bij", rotations, rotations))
    return np.ascontiguousarray(vectors[..., -1])


def _mirror_at_rest(skeleton: Skeleton, vertical: Array, counterpart: np.ndarray) -> Mirror | None:
    origins, orientations = _placed(skeleton, skeleton.rest_rotations)
    across = _across(origins, counterpart)
    across -= across.dot(vertical) * vertical
    size = np.ptp(origins, axis=0).max()
    if np.linalg.norm(across) <= _TOLERANCE * size:
        return None
    reflection = _reflection(across)
    offset = (origins[counterpart] - origins @ reflection).mean(axis=0)
    if np.abs(origins[counterpart] - origins @ reflection - offset).max() > _TOLERANCE * size:
        return None
    frames = orientations[counterpart].swapaxes(-1, -2) @ reflection @ orientations
    return _with_parents(skeleton, counterpart, frames, reflection)


def _mirror_in_use(skeleton: Skeleton, vertical: Array, counterpart: np.ndarray, usual: Array) -> Mirror | None:
    """Find F from a pose that is about the same on both sides.

    How far joints above the last of the trunk turn, which may be the heading, says nothing of the sides: only the
    vertical keeps its place.
    """
    trunk = body_parts(skeleton).trunk
    in_trunk = usual.copy()
    in_trunk[trunk] = quat.IDENTITY
    origins, orientations = _placed(skeleton, in_trunk)
    across = _across(origins, counterpart)
    size = np.ptp(origins, axis=0).max()
    if np.linalg.norm(across) <= _TOLERANCE * size:
        return None
    exact = orientations[counterpart].swapaxes(-1, -2) @ _reflection(across) @ orientations
    frames = np.round(exact)
    bones = np.setdiff1d(np.flatnonzero(skeleton.parents >= 0), trunk)
    offsets = skeleton.rest_translations
    mirrored = np.einsum("bij,bj->bi", frames[skeleton.parents[bones]], offsets[bones])
    if (
        np.abs(frames @ frames.swapaxes(-1, -2) - np.eye(3)).max() > 0.0
        or np.abs(exact - frames).max() > _AXES
        or np.abs(mirrored - offsets[counterpart[bones]]).max() > _TOLERANCE * size
    ):
        return None
    upright = _reflection(np.cross(vertical, np.eye(3)[np.abs(vertical).argmin()]))
    above = _placed(skeleton, usual)[1][trunk[:-1]]
    frames[trunk[:-1]] = above.swapaxes(-1, -2) @ upright @ above
    return _with_parents(skeleton, counterpart, frames, upright)


def _with_parents(skeleton: Skeleton, counterpart: np.ndarray, frames: Array, reflection: Array) -> Mirror:
    return Mirror(
        counterpart, frames, np.where((skeleton.parents >= 0)[:, None, None], frames[skeleton.parents], reflection)
    )


def _across(origins: Array, counterpart: np.ndarray) -> Array:
    """Sum up the ways from each joint to its counterpart."""
    return np.asarray((origins[counterpart] - origins)[counterpart > np.arange(len(origins))].sum(axis=0))


def _reflection(normal: Array) -> Array:
    unit = normal / np.linalg.norm(normal)
    return np.asarray(np.eye(3) - 2.0 * np.outer(unit, unit))


def _placed(skeleton: Skeleton, rotations: Array) -> tuple[Array, Array]:
    """Return the origins of joints in a pose, shape=[B, 3], and their orientations, shape=[B, 3, 3]."""
    pose = place(skeleton, rotations[None], skeleton.rest_translations[None])
    return pose.origins[0], quat.to_matrix(pose.rotations[0])


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
