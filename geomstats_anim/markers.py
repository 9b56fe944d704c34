"""Points that move with a skeleton, and how far they are from where they should be in the world."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geomstats_anim.animation import Animation, Skeleton
from geomstats_anim.kernels import affine as kernel
from geomstats_anim.kinematics import breadth_first
from geomstats_anim.names import SHELL_RADIUS
from geomstats_anim.rotations import Array

_CHUNK = 64
"""Frames at a time, where every marker of a skin is measured."""


def joint_matrices(animation: Animation) -> Array:
    """Place every joint in the world, scales and the placement of the skeleton included.

    As in UsdSkel, a joint's own scale comes first, then its rotation and translation, then its parent's matrix.

    Parameters
    ----------
    animation : Animation

    Returns
    -------
    matrices : array-like, shape=[F, B, 3, 4]
        A point p of a joint's frame is at m[:, :3] p + m[:, 3], metres.
    """
    matrices = np.empty((animation.n_frames, animation.n_joints, 3, 4))
    rotations, translations = np.array(animation.rotations), np.array(animation.translations)
    place_some(animation, rotations, translations, breadth_first(animation.skeleton), matrices)
    return matrices


def joint_places(animation: Animation, joints: np.ndarray) -> Array:
    """Place where some joints start in the world, shape=[F, J, 3], metres, and no others but those above them.

    Parameters
    ----------
    animation : Animation
    joints : array-like of int, shape=[J]
    """
    parents, is_needed = animation.skeleton.parents, np.zeros(animation.n_joints + 1, dtype=bool)
    above = np.asarray(joints)
    while (above >= 0).any():
        is_needed[above] = True
        above = np.where(above >= 0, parents[above], -1)
    needed = np.flatnonzero(is_needed[:-1])  # parents come before their children
    parents = np.where(parents[needed] >= 0, np.searchsorted(needed, parents[needed]), -1)
    moves = [animation.rotations, animation.translations]
    moves.append(np.ones((animation.n_frames, animation.n_joints, 3)) if animation.scales is None else animation.scales)
    matrices = np.empty((animation.n_frames, len(needed), 3, 4))
    kernel.place_joints(
        np.arange(len(needed)), parents, _world(animation), *(np.take(each, needed, axis=1) for each in moves), matrices
    )
    return matrices[..., 3][:, np.searchsorted(needed, joints)]


def _world(animation: Animation) -> Array:
    shape = animation.n_frames, 3, 4
    return np.array(np.broadcast_to(np.eye(3, 4), shape) if animation.world is None else animation.world)


def place_some(
    animation: Animation, rotations: Array, translations: Array, joints: np.ndarray, matrices: Array
) -> None:
    """Place some joints of an animation anew, turned and moved otherwise; see `joint_matrices`.

    Parameters
    ----------
    animation : Animation
        What the skeleton, its scales and its place in the world are.
    rotations, translations : array-like, shape=[F, B, 4], shape=[F, B, 3]
        Writeable.
    joints : array-like of int, shape=[J]
        With every joint, all below it, parents first.
    matrices : array-like, shape=[F, B, 3, 4]
        Of all joints; those of the chosen ones are written.
    """
    shape = rotations.shape[:2]
    scales = np.ones((*shape, 3)) if animation.scales is None else animation.scales
    kernel.place_joints(
        joints,
        np.array(animation.skeleton.parents),
        _world(animation),
        rotations,
        translations,
        np.array(scales),
        matrices,
    )


@dataclass(frozen=True, eq=False)
class Markers:
    """Points that move with joints; one that moves with several is blended linearly, as skin is.

    Parameters
    ----------
    joints : array-like of int, shape=[P, I]
        Joints that each marker moves with.
    offsets : array-like, shape=[P, I, 3]
        Place of the marker in the frame of each of them, metres.
    weights : array-like, shape=[P, I]
        Share of each of them.
    """

    joints: np.ndarray
    offsets: Array
    weights: Array

    def __post_init__(self) -> None:
        """Copy to the types that kernels are compiled for."""
        object.__setattr__(self, "joints", np.array(self.joints, dtype=np.intp, order="C"))
        object.__setattr__(self, "offsets", np.array(self.offsets, dtype=np.float64, order="C"))
        object.__setattr__(self, "weights", np.array(self.weights, dtype=np.float64, order="C"))

    @classmethod
    def on_joints(cls, joints: np.ndarray, offsets: Array) -> Markers:
        """Make markers that move with one joint each, shape=[P], at offsets, shape=[P, 3]."""
        return cls(joints[:, None], offsets[:, None], np.ones((len(joints), 1)))

    @classmethod
    def none(cls) -> Markers:
        """Mark nothing."""
        return cls.on_joints(np.zeros(0, dtype=np.intp), np.zeros((0, 3)))

    @classmethod
    def of_ends(cls, skeleton: Skeleton) -> Markers:
        """Mark the end of every bone."""
        return cls.on_joints(np.arange(skeleton.n_joints), skeleton.bone_ends)

    @classmethod
    def of_bones(cls, skeleton: Skeleton) -> Markers:
        """Mark every joint, and the end of its bone."""
        heads = cls.on_joints(np.arange(skeleton.n_joints), np.zeros((skeleton.n_joints, 3)))
        return heads.joined(cls.of_ends(skeleton))

    @classmethod
    def of_shell(cls, animation: Animation, radius: float = SHELL_RADIUS) -> Markers:
        """Mark every joint, the end of its bone, and points around the joint on its axes, so that twists count too.

        Parameters
        ----------
        animation : Animation
            In its first frame the points are at the radius in the world.
        radius : float
            Metres.
            Optional, default: `SHELL_RADIUS`.
        """
        bones = cls.of_bones(animation.skeleton)
        axes = joint_matrices(animation.at_frames(slice(0, 1)))[0, :, :, :3]
        lengths = np.linalg.norm(axes, axis=-2)  # of a joint's axes in the world, shape=[B, 3]
        reach = radius / np.where(lengths > 0.0, lengths, 1.0)
        offsets = np.concatenate([reach[:, :, None] * np.eye(3), -reach[:, :, None] * np.eye(3)], axis=1)
        around = np.repeat(np.arange(animation.n_joints), 6)
        return bones.joined(cls.on_joints(around, offsets.reshape(-1, 3)))

    @property
    def n_markers(self) -> int:
        """Number of markers, P."""
        return len(self.joints)

    @property
    def owners(self) -> np.ndarray:
        """Joint that each marker moves with most, shape=[P]."""
        return np.take_along_axis(self.joints, self.weights.argmax(axis=-1)[:, None], axis=-1)[:, 0]

    def chosen(self, markers: np.ndarray) -> Markers:
        """Keep some of the markers, by index or mask."""
        return Markers(self.joints[markers], self.offsets[markers], self.weights[markers])

    def joined(self, other: Markers) -> Markers:
        """Put the markers of two sets into one."""
        width = max(self.joints.shape[1], other.joints.shape[1])
        parts = [each._widened(width) for each in (self, other)]
        return Markers(*(np.concatenate([getattr(part, name) for part in parts]) for name in vars(self)))

    def _widened(self, width: int) -> Markers:
        room = ((0, 0), (0, width - self.joints.shape[1]))
        return Markers(np.pad(self.joints, room), np.pad(self.offsets, (*room, (0, 0))), np.pad(self.weights, room))

    def places(self, matrices: Array) -> Array:
        """Place the markers in the world by `joint_matrices`, shape=[F, B, 3, 4]: shape=[F, P, 3], metres."""
        places = np.empty((len(matrices), self.n_markers, 3))
        kernel.place_markers(matrices, self.joints, self.offsets, self.weights, places)
        return places


def spread(markers: Markers) -> np.ndarray:
    """Choose the markers that reach furthest from their joints.

    Parameters
    ----------
    markers : Markers

    Returns
    -------
    chosen : array-like of int
        Indices, at most 14 per joint: the furthest along every axis of its frame, and every diagonal between them.
    """
    grid = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3)).reshape(3, -1).T
    directions = grid[np.isin(np.abs(grid).sum(axis=-1), (1.0, 3.0))]
    owners, strongest = markers.owners, markers.weights.argmax(axis=-1)
    reach = markers.offsets[np.arange(markers.n_markers), strongest] @ directions.T
    own = [np.flatnonzero(owners == joint) for joint in np.unique(owners)]
    return np.unique(np.array([some[reach[some].argmax(axis=0)] for some in own], dtype=np.intp))


def largest_by_marker(animation: Animation, reference: Animation, markers: Markers) -> Array:
    """Measure the largest distance of each marker over all frames, shape=[P], metres; see `world_errors`."""
    largest = np.zeros(markers.n_markers)
    for start in range(0, reference.n_frames, _CHUNK):
        frames = slice(start, start + _CHUNK)
        distances = np.zeros((len(reference.times[frames]), markers.n_markers))
        part, truth = animation.at_frames(frames), reference.at_frames(frames)
        placed = joint_matrices(replace(part, world=truth.world)), joint_matrices(truth)
        _raise_distances(*placed, markers, np.arange(len(largest)), distances)
        largest = np.maximum(largest, distances.max(axis=0))
    return largest


def world_errors(animation: Animation, reference: Animation, markers: Markers | None = None) -> Array:
    """Measure how far markers are from where they should be in the world.

    Parameters
    ----------
    animation, reference : Animation
        Same joints and times. Where the skeleton is in the world, `reference` says.
    markers : Markers
        Optional, default: every joint, and the end of its bone.

    Returns
    -------
    distances : array-like, shape=[F, B]
        Metres: the largest among the markers that move most with each joint; 0 for a joint without markers.
    """
    markers = markers or Markers.of_bones(reference.skeleton)
    placed = joint_matrices(replace(animation, world=reference.world)), joint_matrices(reference)
    return distances_between(*placed, markers)


def distances_between(matrices: Array, others: Array, markers: Markers) -> Array:
    """Measure how far markers are apart under two motions, shape=[F, B]; see `world_errors`.

    Parameters
    ----------
    matrices, others : array-like, shape=[F, B, 3, 4]
        What `joint_matrices` gives.
    markers : Markers
    """
    distances = np.zeros(matrices.shape[:2])
    _raise_distances(matrices, others, markers, markers.owners, distances)
    return distances


def _raise_distances(matrices: Array, others: Array, markers: Markers, owners: np.ndarray, distances: Array) -> None:
    kernel.largest_distances(matrices, others, owners, markers.joints, markers.offsets, markers.weights, distances)
