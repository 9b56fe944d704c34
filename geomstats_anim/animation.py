"""Skeletons and their motion, as plain arrays: the data that every part of the project works on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from geomstats_anim import rotations as quat
from geomstats_anim.names import repeated_name
from geomstats_anim.rotations import Array

_UNIT_TOLERANCE = 1e-2
"""Largest deviation of a quaternion's norm from 1 that is taken for rounding."""


_ROUNDING = 1e-15


def _floats(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    """Copy to float64 and check the shape (None: any length) and that every number is finite."""
    array = np.array(value, dtype=np.float64, order="C")
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} has shape {array.shape}, but ({wanted}) is needed.")
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} has a value that is not finite, {array[where]}, at index {where}.")
    return array


def _unit_quaternions(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    array = _floats(name, value, (*shape, 4))
    norm = quat.norm(array)
    excess = np.abs(norm - 1.0)
    if excess.max(initial=0.0) > _UNIT_TOLERANCE:
        where = tuple(int(i) for i in np.argwhere(excess > _UNIT_TOLERANCE)[0])
        raise ValueError(f"{name} has a quaternion of norm {norm[where]:.6g} at index {where}; normalise it first.")
    # what is unit to rounding stays as it is, so that nothing changes when it passes through twice
    return np.divide(array, norm[..., None], out=array, where=excess[..., None] > _ROUNDING)


def increasing_times(value: ArrayLike) -> Array:
    """Copy times, shape=[F], to float64 and check that they are finite and strictly increasing."""
    times = _floats("times", value, (None,))
    falls = times[1:] <= times[:-1]
    if falls.any():
        at = int(falls.argmax())
        raise ValueError(f"times must increase, but time {at} is {times[at]} and time {at + 1} is {times[at + 1]}.")
    return times


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints in a tree, in their rest pose.

    Parameters
    ----------
    joints : sequence of str, shape=[B]
        Full path tokens, unique.
    parents : array-like of int, shape=[B]
        Index of each joint's parent, -1 for a root. Parents come before their children.
    rest_translations : array-like, shape=[B, 3]
        Metres, relative to the parent.
    rest_rotations : array-like, shape=[B, 4]
        Unit quaternions (x, y, z, w), relative to the parent.
    bone_ends : array-like, shape=[B, 3]
        End point of each joint's bone in its own frame, metres.
        Optional, default: `default_bone_ends`.

    Raises
    ------
    ValueError
        If the sizes do not fit, names repeat, or a parent does not come before its child.
    """

    joints: tuple[str, ...]
    parents: np.ndarray
    rest_translations: Array
    rest_rotations: Array
    bone_ends: Array = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        joints = tuple(str(joint) for joint in self.joints)
        n_joints = len(joints)
        twice = repeated_name(joints)
        if twice is not None:
            raise ValueError(f"Joint names must be unique, but {twice!r} is there twice.")
        parents = np.array(self.parents, dtype=np.intp)
        if parents.shape != (n_joints,):
            raise ValueError(f"parents has shape {parents.shape}, but there are {n_joints} joints.")
        for joint, parent in enumerate(parents):
            if not -1 <= parent < joint:
                raise ValueError(f"Joint {joints[joint]!r} is number {joint}, but its parent is number {parent}.")
        translations = _floats("rest_translations", self.rest_translations, (n_joints, 3))
        ends = default_bone_ends(parents, translations) if self.bone_ends is None else self.bone_ends
        values = {
            "joints": joints,
            "parents": parents,
            "rest_translations": translations,
            "rest_rotations": _unit_quaternions("rest_rotations", self.rest_rotations, (n_joints,)),
            "bone_ends": _floats("bone_ends", ends, (n_joints, 3)),
        }
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def n_joints(self) -> int:
        """Return the number of joints, B."""
        return len(self.joints)

    @property
    def depths(self) -> np.ndarray:
        """Return the depth of each joint, shape=[B], counted from 1 at a root."""
        depths = np.ones(self.n_joints, dtype=np.intp)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                depths[joint] = depths[parent] + 1
        return depths


def descendants(skeleton: Skeleton, joints: np.ndarray) -> np.ndarray:
    """Return some joints, by their indices, and all below them, shape=[J], parents before children."""
    is_below = np.zeros(skeleton.n_joints, dtype=bool)
    is_below[joints] = True
    for joint, parent in enumerate(skeleton.parents.tolist()):
        is_below[joint] |= parent >= 0 and is_below[parent]
    return np.flatnonzero(is_below)


def default_bone_ends(
    parents: ArrayLike, rest_translations: ArrayLike, bone_lengths: Sequence[float | None] | None = None
) -> Array:
    """Return the end point of each joint's bone in its own frame.

    It is the mean of the children's rest translations; for a leaf, its authored length along its own rest
    translation, else that rest translation again.

    Parameters
    ----------
    parents : array-like of int, shape=[B]
    rest_translations : array-like, shape=[B, 3]
        Metres.
    bone_lengths : sequence of float or None, shape=[B]
        Authored lengths in metres, None where there is none.
        Optional, default: none at all.

    Returns
    -------
    bone_ends : array-like, shape=[B, 3]
        Metres.
    """
    parents = np.asarray(parents, dtype=np.intp)
    translations = np.asarray(rest_translations, dtype=np.float64)
    has_parent = parents >= 0
    sums = np.zeros_like(translations)
    np.add.at(sums, parents[has_parent], translations[has_parent])
    n_children = np.bincount(parents[has_parent], minlength=len(parents))
    ends = np.where(n_children[:, None] > 0, sums / np.maximum(n_children, 1)[:, None], translations)
    for joint, bone_length in enumerate(bone_lengths or ()):
        own_length = np.linalg.norm(translations[joint])
        if bone_length is not None and n_children[joint] == 0 and own_length > 0.0:
            ends[joint] = translations[joint] * (bone_length / own_length)
    return ends


@dataclass(frozen=True, eq=False)
class Animation:
    """Joint-local motion of a skeleton, sampled in time.

    Parameters
    ----------
    skeleton : Skeleton
    times : array-like, shape=[F]
        Seconds, strictly increasing.
    rotations : array-like, shape=[F, B, 4]
        Quaternions (x, y, z, w); made unit and sign-continuous along time.
    translations : array-like, shape=[F, B, 3]
        Metres.
    scales : array-like, shape=[F, B, 3]
        Optional, default: None, no scaling.
    world : array-like, shape=[F, 3, 4]
        Placement of the skeleton in the world: a point p of its space is at world[:, :3] p + world[:, 3], metres.
        Optional, default: None, where it stands.

    Raises
    ------
    ValueError
        If the sizes do not fit, a number is not finite, or times do not increase.

    Examples
    --------
    >>> from geomstats_anim import Animation, Skeleton
    >>> skeleton = Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]])
    >>> turn = Animation(skeleton, [0.0, 1.0], [[[0, 0, 0, 1]], [[1, 0, 0, 0]]], [[[0, 0, 0]], [[0, 0, 1]]])
    >>> turn.n_frames
    2
    """

    skeleton: Skeleton
    times: Array
    rotations: Array
    translations: Array
    scales: Array | None = None
    world: Array | None = None

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        times = increasing_times(self.times)
        shape = (len(times), self.skeleton.n_joints)
        rotations = _unit_quaternions("rotations", self.rotations, shape)
        values = {
            "times": times,
            "rotations": quat.make_continuous(rotations),
            "translations": _floats("translations", self.translations, (*shape, 3)),
            "scales": None if self.scales is None else _floats("scales", self.scales, (*shape, 3)),
            "world": None if self.world is None else _floats("world", self.world, (len(times), 3, 4)),
        }
        for name, value in values.items():
            if value is not None:
                value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def n_frames(self) -> int:
        """Return the number of frames, F."""
        return len(self.times)

    @property
    def n_joints(self) -> int:
        """Return the number of joints, B."""
        return self.skeleton.n_joints

    def at_frames(self, frames: ArrayLike | slice) -> Animation:
        """Return an animation of some frames only.

        Parameters
        ----------
        frames : array-like of int or bool, or slice
            Increasing indices, as `uniform_keyframes` gives them; a mask, shape=[F]; or a slice.

        Returns
        -------
        animation : Animation

        Raises
        ------
        ValueError
            If the times at the indices do not increase, one is not whole, or the mask has another length.
        """
        index = frames if isinstance(frames, slice) else _indices(np.asarray(frames), self.n_frames)
        scales = None if self.scales is None else self.scales[index]
        world = None if self.world is None else self.world[index]
        return replace(
            self,
            times=self.times[index],
            rotations=self.rotations[index],
            translations=self.translations[index],
            scales=scales,
            world=world,
        )


def backwards(animation: Animation) -> Animation:
    """Return the motion in reverse, at the same times."""
    return replace(
        animation,
        rotations=animation.rotations[::-1],
        translations=animation.translations[::-1],
        scales=None if animation.scales is None else animation.scales[::-1],
        world=None if animation.world is None else animation.world[::-1],
    )


def _indices(frames: np.ndarray, n_frames: int) -> np.ndarray:
    """Turn a mask or indices of frames into indices."""
    if frames.dtype == bool:
        if frames.shape != (n_frames,):
            raise ValueError(f"The mask of frames has shape {frames.shape}, but there are {n_frames} frames.")
        return np.flatnonzero(frames)
    if frames.size and not np.equal(frames, np.round(frames)).all():
        raise ValueError(f"Frames must be whole numbers, but one is {frames[frames != np.round(frames)][0]}.")
    return frames.astype(np.intp)
