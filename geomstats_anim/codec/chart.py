"""Rotations as vectors: logarithms at one reference rotation per joint, without jumps along time.

A reference is the rest rotation, or that followed by one of the 24 rotations of a cube where the motion is far from it.
"""

from __future__ import annotations

from functools import cache
from itertools import permutations, product

import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.rotations import Array

_FAR = 2.0
"""Radians from the rest rotation beyond which a joint gets a nearer reference."""

LONGEST = 5.0
"""Radians from a reference beyond which a chart is cut in two: it ends at a whole turn, 2 pi."""


@cache
def cube_rotations() -> Array:
    """Return the 24 rotations of a cube as quaternions, shape=[24, 4], the identity first."""
    found = []
    for axes, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[range(3), axes] = signs
        if np.linalg.det(matrix) > 0.0:
            found.append(matrix)
    return quat.from_matrix(np.array(found))


def choose_turns(rest: Array, rotations: Array) -> np.ndarray:
    """Choose each joint's reference.

    Parameters
    ----------
    rest : array-like, shape=[B, 4]
    rotations : array-like, shape=[F, B, 4]

    Returns
    -------
    turns : array-like of int, shape=[B]
        Which of `cube_rotations` follows the rest rotation: 0, the identity, unless the motion is far from rest.
    """
    turns = np.zeros(len(rest), dtype=np.intp)
    far = np.flatnonzero(quat.distance(rotations, rest).max(axis=0) > _FAR)
    if len(far):
        candidates = quat.multiply(rest[far, None], cube_rotations()).reshape(-1, 4)
        vectors = to_vectors(candidates, np.repeat(rotations[:, far], len(cube_rotations()), axis=1))
        turns[far] = np.linalg.norm(vectors, axis=-1).max(axis=0).reshape(len(far), -1).argmin(axis=1)
    return turns


def references(rest: Array, turns: np.ndarray) -> Array:
    """Return the reference rotations, shape=[B, 4], that `choose_turns` chose."""
    return quat.multiply(rest, cube_rotations()[turns]) if turns.any() else rest


def to_vectors(reference: Array, rotations: Array) -> Array:
    """Return rotation vectors at the references, shape=[F, B, 3], which may grow beyond pi rather than jump."""
    vectors = quat.difference(np.broadcast_to(reference, rotations.shape), rotations)
    angles = np.linalg.norm(vectors, axis=-1, keepdims=True)
    axes = vectors / np.where(angles > 0.0, angles, 1.0)
    for f in range(1, len(vectors)):
        along = np.einsum("bi,bi->b", vectors[f - 1], axes[f])[:, None]
        vectors[f] = axes[f] * (angles[f] + 2.0 * np.pi * np.round((along - angles[f]) / (2.0 * np.pi)))
    return vectors


def to_rotations(reference: Array, vectors: Array) -> Array:
    """Invert `to_vectors`: unit quaternions, shape=[F, B, 4]."""
    placed = np.empty((*vectors.shape[:-1], 4))
    placed[:] = reference  # faster than to have it broadcast
    return quat.multiply(placed, quat.exp(vectors))


def charted_pieces(rest: Array, rotations: Array, bounds: np.ndarray) -> np.ndarray:
    """Cut pieces of time in halves until one chart covers each.

    Parameters
    ----------
    rest : array-like, shape=[B, 4]
    rotations : array-like, shape=[F, B, 4]
    bounds : array-like of int, shape=[S + 1]
        First frame of each piece, and F.

    Returns
    -------
    bounds : array-like of int
    """
    todo, done = list(zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True))[::-1], [0]
    while todo:
        start, stop = todo.pop()
        piece = rotations[start:stop]
        vectors = to_vectors(references(rest, choose_turns(rest, piece)), piece)
        if stop - start > 1 and np.linalg.norm(vectors, axis=-1).max(initial=0.0) > LONGEST:
            middle = (start + stop) // 2
            todo += [(middle, stop), (start, middle)]
        else:
            done.append(stop)
    return np.array(done, dtype=np.intp)
