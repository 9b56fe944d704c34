"""Meaning of the integers of a packed motion: groups of channels, and their steps."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from geomstats_anim.animation import Skeleton
from geomstats_anim.codec.wavelets import Wavelets
from geomstats_anim.kernels import wavelets as kernel
from geomstats_anim.kernels.contexts import PLAIN, ROTATION, TRANSLATION, Lattice
from geomstats_anim.names import SHELL_RADIUS
from geomstats_anim.rotations import Array, multiply, rotate

STEPS_PER_OCTAVE = 4
_SMALLEST_STEP = 2.0**-30
"""Step of code 0, in metres, or in units of a channel."""

_COARSER, _COARSEST = 1.15, 1.2
"""Growth of steps from each band to the next coarser, and those of scaling coefficients for every level."""

LARGEST_CODE = 60 * STEPS_PER_OCTAVE


def step_of(code: int | Array) -> Array:
    """Return the step of a code, or of an array of them."""
    return _SMALLEST_STEP * 2.0 ** (np.asarray(code, dtype=np.float64) / STEPS_PER_OCTAVE)


def code_of(step: float) -> int:
    """Return the code of the largest step that is not larger, within bounds."""
    code = int(np.floor(STEPS_PER_OCTAVE * np.log2(step / _SMALLEST_STEP) + 1e-9))
    return min(max(code, 0), LARGEST_CODE)


@lru_cache(maxsize=4)
def wavelets_of(n_frames: int) -> Wavelets:
    """Return the transform of a number of frames, kept since segments are equally long."""
    return Wavelets(n_frames)


class Layout(NamedTuple):
    """Groups of three channels: rotations, then translations, scales and other channels, as far as there are any.

    Attributes
    ----------
    kinds, joints, parents : array-like of int, shape=[G]
        As in `Lattice`; scales and other channels have places among the plain numbers instead of joints.
    levers : array-like, shape=[G]
        What a step is divided by: metres that a radian, or a scale, moves what hangs below a joint; 1 otherwise.
    n_scales, n_plain : int
        Groups of scales, and of plain numbers, scales included.
    """

    kinds: np.ndarray
    joints: np.ndarray
    parents: np.ndarray
    levers: Array
    n_scales: int
    n_plain: int

    @classmethod
    @lru_cache(maxsize=8)
    def of(cls, skeleton: Skeleton, has_translations: bool, has_scales: bool, n_others: int) -> Layout:
        """Lay out the groups of a skeleton, and of a number of other groups."""
        n_joints = skeleton.n_joints
        n_moved, n_scales = n_joints * has_translations, n_joints * has_scales
        numbers = np.arange(n_joints)
        lever_lengths = levers(skeleton)
        return cls(
            kinds=np.repeat([ROTATION, TRANSLATION, PLAIN], [n_joints, n_moved, n_scales + n_others]),
            joints=np.concatenate([numbers, numbers[:n_moved], np.arange(n_scales + n_others)]).astype(np.intp),
            parents=np.concatenate([skeleton.parents, np.full(n_moved + n_scales + n_others, -1)]).astype(np.intp),
            levers=np.concatenate([lever_lengths, np.ones(n_moved), lever_lengths[:n_scales], np.ones(n_others)]),
            n_scales=n_scales,
            n_plain=n_scales + n_others,
        )


@lru_cache(maxsize=8)
def levers(skeleton: Skeleton) -> Array:
    """Return how far a radian at each joint moves what hangs below it, in the rest pose.

    Parameters
    ----------
    skeleton : Skeleton

    Returns
    -------
    levers : array-like, shape=[B]
        Root mean square distance to the joints and bone ends below, and to the shell, in metres, rounded to quarter
        octaves.
    """
    n_joints = skeleton.n_joints
    heads, turns = np.empty((n_joints, 3)), np.empty((n_joints, 4))
    ends = np.empty((n_joints, 3))
    for joint, parent in enumerate(skeleton.parents):
        q, t = skeleton.rest_rotations[joint], skeleton.rest_translations[joint]
        turns[joint] = q if parent < 0 else multiply(turns[parent], q)
        heads[joint] = t if parent < 0 else heads[parent] + rotate(turns[parent], t)
        ends[joint] = heads[joint] + rotate(turns[joint], skeleton.bone_ends[joint])
    # counts, sums and sums of squares of the points below each joint
    points = np.stack([heads, ends])
    count, total, squares = np.full(n_joints, 2.0), points.sum(axis=0), (points**2).sum(axis=(0, 2))
    for joint in range(n_joints - 1, 0, -1):
        parent = skeleton.parents[joint]
        if parent >= 0:
            count[parent] += count[joint]
            total[parent] += total[joint]
            squares[parent] += squares[joint]
    mean = squares / count - 2.0 * (total * heads).sum(axis=-1) / count + (heads**2).sum(axis=-1)
    lengths = np.sqrt(np.maximum(mean, 0.0) + SHELL_RADIUS**2)
    return 2.0 ** (np.round(STEPS_PER_OCTAVE * np.log2(lengths)) / STEPS_PER_OCTAVE)


class Steps(NamedTuple):
    """Step codes of a segment: of motion, of scales, and of every other group."""

    motion: int
    scales: int
    channels: tuple[int, ...]


def new_lattice(layout: Layout, steps: Steps, n_frames: int, with_basis: bool) -> Lattice:
    """Return a lattice of zeros.

    Parameters
    ----------
    layout : Layout
    steps : Steps
    n_frames : int
    with_basis : bool
        Whether it is searched, for which basis functions are needed.
    """
    wavelets = wavelets_of(n_frames)
    units = step_of(steps.motion) / layout.levers
    if layout.n_plain:
        scales = slice(len(units) - layout.n_plain, len(units) - layout.n_plain + layout.n_scales)
        units[scales] = step_of(steps.scales) / layout.levers[scales]
        units[scales.stop :] = step_of(np.array(steps.channels, dtype=np.float64))
    gains = band_gains(len(wavelets.bands) - 1)
    basis = wavelets.basis if with_basis else None
    return Lattice(
        integers=np.zeros((n_frames, len(layout.kinds), 3), dtype=np.int32),
        bands=wavelets.bands,
        kinds=layout.kinds,
        joints=layout.joints,
        parents=layout.parents,
        units=gains[:, None] * units,
        pointers=basis.pointers if basis else np.zeros(1, dtype=np.intp),
        starts=basis.starts if basis else np.zeros(0, dtype=np.intp),
        values=basis.values if basis else np.zeros(0),
    )


@lru_cache
def band_gains(n_bands: int) -> Array:
    """Return what steps of each band are multiplied by, from coarse to fine."""
    gains: Array = np.power(_COARSER, n_bands - 1.0 - np.arange(n_bands, dtype=np.float64))
    gains[0] = _COARSEST ** (n_bands - 1.0)
    return gains


def units_of(lattice: Lattice) -> Array:
    """Return what each integer stands for, shape=[F, G, 1]."""
    return np.repeat(lattice.units, np.diff(lattice.bands), axis=0)[:, :, None]


def to_values(lattice: Lattice) -> Array:
    """Return the samples of every channel, shape=[F, G, 3]."""
    integers = lattice.integers
    used = np.flatnonzero(np.bitwise_or.reduce(integers, axis=0).any(axis=-1))
    samples = np.empty((len(integers), 3 * len(used)))
    kernel.scaled(integers, lattice.bands, lattice.units, used, samples)
    kernel.synthesise(samples, wavelets_of(len(integers)).sizes)
    values = np.zeros(integers.shape)
    values[:, used] = samples.reshape(len(integers), -1, 3)
    return values


def to_coefficients(values: Array) -> Array:
    """Return the coefficients of samples, shape=[F, G, 3]."""
    return wavelets_of(len(values)).analyse(values.reshape(len(values), -1)).reshape(values.shape)


def to_lattice_coordinates(lattice: Lattice, coefficients: Array) -> Array:
    """Return coefficients, shape=[F, G, 3], in units of the lattice, before rounding."""
    units = units_of(lattice)
    return np.divide(coefficients, units, out=np.zeros_like(coefficients), where=units > 0.0)
