"""Pack pieces of a motion: from samples to integers, searched, to bytes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Animation, backwards
from geomstats_anim.codec import entropy
from geomstats_anim.codec.chart import choose_turns, references, to_vectors
from geomstats_anim.codec.lattice import Steps, code_of, new_lattice, to_coefficients, to_lattice_coordinates, to_values
from geomstats_anim.codec.search import EFFORTS, joints_below, marker_places, search, search_plain
from geomstats_anim.codec.stream import Header, Segment
from geomstats_anim.kernels import lattice_search as kernel
from geomstats_anim.kernels.context_coder import LARGEST
from geomstats_anim.kernels.contexts import PLAIN, Lattice
from geomstats_anim.kernels.lattice_search import Pose
from geomstats_anim.markers import Markers, joint_matrices
from geomstats_anim.rotations import Array

_STEP = 0.75
"""Step over tolerance, at the joint's lever."""

_FINER = 10
"""Steps that are searched, each finer than the last by a quarter octave."""

_FINEST = 24
"""Steps that there are."""

_SCALE_SHARE = 0.125
"""Part of the tolerance that scales may take."""

_ON_LATTICE = 0.01
"""Of a step: what is nearer than this to whole numbers has been packed before."""

_STILL = 1e-9
"""Radians, metres or units that channels may move and still stand still."""

_STILL_STEPS = 1e-6
"""Steps that a channel may move and still stand still."""


class ExtraChannel(NamedTuple):
    """Numbers beside the joints, such as weights of blend shapes.

    Attributes
    ----------
    values : array-like, shape=[F, C]
    tolerance : float
        How far each decoded value may be from its own.
    """

    values: Array
    tolerance: float


class _Piece(NamedTuple):
    """Frames that make a segment, in the order in which they are stored; one frame if they are still."""

    motion: Animation
    turns: np.ndarray
    values: Array
    coefficients: Array
    n_frames: int
    is_still: bool

    def segment(self, steps: Steps, lattice: Lattice) -> Segment:
        """Return the segment of some integers."""
        return Segment(self.n_frames, self.is_still, steps, self.turns, entropy.encode(lattice))


class Packer:
    """Packs one piece after the other with the same settings."""

    def __init__(
        self,
        animation: Animation,
        header: Header,
        markers: Markers,
        tolerance: float,
        scale_tolerance: float,
        channels: Mapping[str, ExtraChannel],
        effort: str,
    ) -> None:
        skeleton = animation.skeleton
        self.animation, self.header, self.tolerance = animation, header, tolerance
        self.effort = EFFORTS[effort]
        self.layout = header.layout(skeleton)
        self.below = joints_below(skeleton.parents)
        order, self.first_marker = marker_places(skeleton, markers.joints[:, 0])
        self.markers = markers.chosen(order)
        self.others = _others(channels, animation.n_frames)
        levers = self.layout.levers[: skeleton.n_joints]
        # a step of scales, at every joint's lever, moves points by a part of the tolerance, and scales by their own
        self.scale_move = min(_SCALE_SHARE * tolerance, scale_tolerance * float(levers.min(initial=1.0)))
        tolerances = [channel.tolerance for channel in channels.values()]
        self.other_tolerances = np.repeat(tolerances, [channel.n_groups for channel in header.channels])
        self.done = 0

    def pack(self, start: int, stop: int, progress: Callable[[int, int], None] | None) -> Segment:
        """Pack the frames from start to stop."""
        piece = self._piece(start, stop)
        segment = self._packed_before(piece) or self._packed(piece)
        if progress is not None:
            self.done += stop - start
            progress(self.done, self.animation.n_frames)
        return segment

    def packed_before(self, start: int, stop: int) -> Segment | None:
        """Return the segment that the frames from start to stop were decoded from, None if they were not."""
        return self._packed_before(self._piece(start, stop))

    @property
    def steps(self) -> list[Steps]:
        """Steps to try, from coarse to fine."""
        motion, scales = code_of(_STEP * self.tolerance), code_of(_STEP * self.scale_move)
        others = [code_of(_STEP * each) for each in self.other_tolerances]
        return [
            Steps(max(motion - n, 0), max(scales - n, 0), tuple(max(code - n, 0) for code in others))
            for n in range(_FINEST)
        ]

    def _piece(self, start: int, stop: int) -> _Piece:
        """Return the frames from start to stop, in the order in which they are stored."""
        motion = self.animation.at_frames(slice(start, stop))
        turns = choose_turns(motion.skeleton.rest_rotations, motion.rotations)
        values = self.values(motion, turns, self.others[start:stop])
        is_still = bool(np.ptp(values, axis=0).max(initial=0.0) < _STILL)
        if is_still:
            motion, values = motion.at_frames(slice(0, 1)), values[:1]
        elif self.header.is_backwards:
            motion, values = backwards(motion), values[::-1]
        return _Piece(motion, turns, values, to_coefficients(values), stop - start, is_still)

    def _packed_before(self, piece: _Piece) -> Segment | None:
        for steps in self.steps:
            lattice, coordinates = self.rounded(piece.coefficients, steps)
            if np.abs(coordinates - lattice.integers).max(initial=0.0) < _ON_LATTICE:
                return piece.segment(steps, lattice)
        return None

    def _packed(self, piece: _Piece) -> Segment:
        """Return a segment that keeps the tolerance, or the finest there is."""
        for steps in self._promising(piece):
            lattice, coordinates = self.rounded(piece.coefficients, steps)
            moving = np.flatnonzero(np.abs(coordinates).max(axis=(0, 2)) > _STILL_STEPS)
            if self._searched(self.pose(piece.motion, piece.turns, piece.values, lattice), lattice, moving):
                return piece.segment(steps, lattice)
        return piece.segment(steps, self.rounded(piece.coefficients, steps)[0])

    def _promising(self, piece: _Piece) -> list[Steps]:
        """Return the steps to search with: without repairs, by bisection, those at which rounding is good enough."""
        if self.effort.repairs:
            return self.steps[:_FINER]
        low, high = 0, len(self.steps) - 1
        while low < high:
            middle = (low + high) // 2
            lattice, _ = self.rounded(piece.coefficients, self.steps[middle])
            pose = self.pose(piece.motion, piece.turns, piece.values, lattice)
            if self._searched(pose, lattice, np.zeros(0, dtype=np.intp)):
                high = middle
            else:
                low = middle + 1
        return self.steps[low:]

    def rounded(self, coefficients: Array, steps: Steps) -> tuple[Lattice, Array]:
        """Return the nearest integers to coefficients, and what was rounded, shape=[F, G, 3]."""
        lattice = new_lattice(self.layout, steps, len(coefficients), with_basis=True)
        coordinates = to_lattice_coordinates(lattice, coefficients)
        lattice.integers[:] = np.rint(coordinates.clip(-LARGEST, LARGEST))
        return lattice, coordinates

    def _searched(self, pose: Pose, lattice: Lattice, moving: np.ndarray) -> bool:
        """Search among plain numbers first, since scales place what the others move; return whether all is kept."""
        is_plain = lattice.kinds[moving] == PLAIN
        if not search_plain(pose, lattice, moving[is_plain], self.effort):
            return False
        if self.layout.n_scales:
            pose.scales[:] = 1.0 + pose.plain[:, : self.layout.n_scales]
        kernel.place_all(pose)
        placing = moving[~is_plain]
        by_joint = placing[np.argsort(lattice.joints[placing], kind="stable")]
        return search(pose, lattice, by_joint, self.tolerance, self.effort)

    def values(self, piece: Animation, turns: np.ndarray, others: Array) -> Array:
        """Return the samples of every channel, shape=[F, G, 3]."""
        skeleton = piece.skeleton
        parts = [to_vectors(references(skeleton.rest_rotations, turns), piece.rotations)]
        if self.header.has_translations:
            parts.append(piece.translations - skeleton.rest_translations)
        if self.header.has_scales and piece.scales is not None:
            parts.append(piece.scales - 1.0)
        return np.concatenate([*parts, others], axis=1)

    def pose(self, piece: Animation, turns: np.ndarray, values: Array, lattice: Lattice) -> Pose:
        """Return the motion of the integers, with markers that should be where the piece has them."""
        skeleton, shape = piece.skeleton, (piece.n_frames, piece.n_joints)
        n_joints, n_plain = skeleton.n_joints, self.layout.n_plain
        now = to_values(lattice)
        plain, targets = now[:, now.shape[1] - n_plain :], values[:, values.shape[1] - n_plain :]
        n_scales = self.layout.n_scales
        # a copy in any case, which tile does not make of nothing
        translations = np.array(np.broadcast_to(skeleton.rest_translations, (*shape, 3)))
        if self.header.has_translations:
            translations += now[:, n_joints : 2 * n_joints]
        return Pose(
            vectors=np.ascontiguousarray(now[:, :n_joints]),
            translations=translations,
            scales=1.0 + plain[:, :n_scales] if n_scales else np.ones((*shape, 3)),
            references=references(skeleton.rest_rotations, turns),
            plain=np.ascontiguousarray(plain),
            plain_targets=np.ascontiguousarray(targets),
            plain_tolerances=np.concatenate([self.scale_move / self.layout.levers[:n_scales], self.other_tolerances]),
            world=np.tile(np.eye(3, 4), (shape[0], 1, 1)) if piece.world is None else np.array(piece.world),
            locals=np.empty((*shape, 3, 4)),
            matrices=np.empty((*shape, 3, 4)),
            parents=np.array(skeleton.parents),
            below=self.below[0],
            members=self.below[1],
            member_parents=self.below[2],
            first_marker=self.first_marker,
            offsets=self.markers.offsets[:, 0].copy(),
            targets=self.markers.places(joint_matrices(piece)),
            weights=np.ones(shape),
        )


def _others(channels: Mapping[str, ExtraChannel], n_frames: int) -> Array:
    """Return the other channels in groups of three, shape=[F, N, 3], the last filled up with zeros."""
    groups = []
    for channel in channels.values():
        values = np.asarray(channel.values, dtype=np.float64)
        padded = np.pad(values, ((0, 0), (0, -values.shape[1] % 3)))
        groups.append(padded.reshape(n_frames, -1, 3))
    return np.concatenate([np.zeros((n_frames, 0, 3)), *groups], axis=1)
