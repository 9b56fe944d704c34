"""Take values of a transform op apart into turns, points and sizes, which schemes interpolate, and join them again."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array

EXACT = 1e-7
"""Share of its size by which a matrix may miss being a scale, a turn and a move."""

WRAP = 45.0
"""Degrees; an angle that is a full turn, and at most this, away from the one before has been wrapped."""

HALF_TURN = 180.0
"""Degrees."""


class Parts(NamedTuple):
    """Split values of a transform op; parts that it lacks are at rest.

    Attributes
    ----------
    turns : array-like, shape=[K, 4]
        Unit quaternions.
    path : array-like, shape=[K, 3]
    sizes : array-like, shape=[K, 3]
        Interpolated linearly.
    """

    turns: Array
    path: Array
    sizes: Array

    @classmethod
    def of(cls, turns: Array | None = None, path: Array | None = None, sizes: Array | None = None) -> Parts:
        """Fill in what is at rest; one-dimensional paths and sizes, shape=[K, C], are padded."""
        n_keys = next(len(each) for each in (turns, path, sizes) if each is not None)
        padded = [None if each is None else np.pad(each, ((0, 0), (0, 3 - each.shape[1]))) for each in (path, sizes)]
        return cls(
            np.tile(quat.IDENTITY, (n_keys, 1)) if turns is None else turns,
            np.zeros((n_keys, 3)) if padded[0] is None else padded[0],
            np.ones((n_keys, 3)) if padded[1] is None else padded[1],
        )


class Codec(NamedTuple):
    """Convert numbers of an op at its samples, shape=[K, C], to parts, and parts in between to numbers.

    Attributes
    ----------
    split : callable
        From numbers to parts.
    join : callable
        From parts at F times, the numbers at the samples, and the index, shape=[F], of the sample before each time, to
        numbers, shape=[F, C].
    """

    split: Callable[[Array], Parts]
    join: Callable[[Parts, Array, np.ndarray], Array]


def codec_of(op_type: str, numbers: Array) -> Codec | None:
    """Choose how to interpolate an op.

    Parameters
    ----------
    op_type : str
        Such as "translate", "rotateXYZ", "orient".
    numbers : array-like, shape=[K, C]
        Its values; quaternions as (x, y, z, w), angles in degrees, matrices by rows.

    Returns
    -------
    codec : Codec or None
        None for matrices that are not exactly a scale, a turn and a move.
    """
    if op_type == "transform":
        return Codec(_split_matrices, _join_matrices) if _is_rigid_but_for_scale(numbers) else None
    if op_type == "orient":
        return Codec(lambda values: Parts.of(turns=quat.normalize(values)), _join_quaternions)
    if op_type.startswith("scale"):
        return Codec(lambda values: Parts.of(sizes=values), lambda parts, keys, _: parts.sizes[:, : keys.shape[1]])
    if not op_type.startswith("rotate"):
        return Codec(lambda values: Parts.of(path=values), lambda parts, keys, _: parts.path[:, : keys.shape[1]])
    order = op_type.removeprefix("rotate").lower()
    # about one axis angles are all there is, and beyond half a turn only they tell how far it goes
    if len(order) == 1 or not _goes_the_short_way(order, numbers):
        return Codec(lambda values: Parts.of(path=_unwrapped(values)), _join_angles)
    return turning(order)


def turning(order: str) -> Codec:
    """Return the codec of three angles that name a turn, in an order such as "xyz"."""
    return Codec(
        lambda values: Parts.of(turns=_from_euler(order, values)),
        lambda parts, keys, segment: _to_euler(order, parts.turns, keys[segment]),
    )


def _join_quaternions(parts: Parts, keys: Array, segment: np.ndarray) -> Array:
    dots = (parts.turns * keys[segment]).sum(axis=-1)
    return parts.turns * np.where(dots < 0.0, -1.0, 1.0)[:, None]


def _unwrapped(degrees: Array) -> Array:
    """Take out the full turns by which angles, shape=[K, C], jump though they hardly move."""
    steps = np.diff(degrees, axis=0)
    turns = np.round(steps / 360.0) * 360.0
    wrapped = (turns != 0.0) & (np.abs(steps - turns) <= WRAP)
    return degrees - np.concatenate([np.zeros((1, degrees.shape[1])), np.cumsum(wrapped * turns, axis=0)])


def _join_angles(parts: Parts, keys: Array, segment: np.ndarray) -> Array:
    return parts.path[:, : keys.shape[1]] + (keys - _unwrapped(keys))[segment]


def _goes_the_short_way(order: str, degrees: Array) -> bool:
    """Check that no step of three angles, shape=[K, 3], is half a turn or more, other names of the turn allowed."""
    steps = np.diff(_unwrapped(degrees), axis=0)
    renamed = _other_name(order, degrees[1:]) - degrees[:-1]
    renamed -= 360.0 * np.round(renamed / 360.0)
    return bool(((np.abs(steps) < HALF_TURN).all(axis=1) | (np.abs(renamed) <= WRAP).all(axis=1)).all())


def _other_name(order: str, degrees: Array) -> Array:
    """Return the other three angles about x, y and z, shape=[K, 3], of the same turn."""
    other = degrees + HALF_TURN
    middle = "xyz".index(order[1])
    other[:, middle] = HALF_TURN - degrees[:, middle]
    return other


def _from_euler(order: str, degrees: Array) -> Array:
    from scipy.spatial.transform import Rotation

    in_order = degrees[:, ["xyz".index(axis) for axis in order]]
    return Rotation.from_euler(order, in_order, degrees=True).as_quat()


def _to_euler(order: str, turns: Array, near: Array) -> Array:
    """Return the angles about x, y and z of turns, degrees, shape=[F, 3]: of all names, those nearest to some."""
    from scipy.spatial.transform import Rotation

    in_order = Rotation.from_quat(turns).as_euler(order, degrees=True)
    degrees = in_order[:, [order.index(axis) for axis in "xyz"]]
    choices = np.stack([degrees, _other_name(order, degrees)])
    choices += 360.0 * np.round((near - choices) / 360.0)
    nearest = np.abs(choices - near).sum(axis=-1).argmin(axis=0)
    return np.take_along_axis(choices, nearest[None, :, None], axis=0)[0]


def _is_rigid_but_for_scale(matrices: Array) -> bool:
    blocks = matrices.reshape(-1, 4, 4)
    products = blocks[:, :3, :3] @ blocks[:, :3, :3].swapaxes(1, 2)
    squares = np.einsum("kii->ki", products)
    largest = squares.max(axis=1)
    off = np.abs(products - squares[:, :, None] * np.eye(3)).max(axis=(1, 2))
    is_affine = np.abs(blocks[:, :, 3] - [0.0, 0.0, 0.0, 1.0]).max() <= EXACT
    return bool(
        is_affine
        and (squares.min(axis=1) > EXACT**2 * largest).all()
        and (off <= EXACT * squares.min(axis=1)).all()
        and (np.linalg.det(blocks[:, :3, :3]) > 0.0).all()
    )


def _split_matrices(matrices: Array) -> Parts:
    blocks = matrices.reshape(-1, 4, 4)
    sizes = np.linalg.norm(blocks[:, :3, :3], axis=-1)
    # OpenUSD multiplies rows, so its matrices are the transposed ones
    turns = quat.from_matrix((blocks[:, :3, :3] / sizes[..., None]).swapaxes(1, 2))
    return Parts(turns, blocks[:, 3, :3], sizes)


def _join_matrices(parts: Parts, keys: Array, segment: np.ndarray) -> Array:
    blocks = np.zeros((len(segment), 4, 4))
    blocks[:, :3, :3] = parts.sizes[..., None] * quat.to_matrix(parts.turns).swapaxes(1, 2)
    blocks[:, 3, :3], blocks[:, 3, 3] = parts.path, 1.0
    return blocks.reshape(-1, 16)
