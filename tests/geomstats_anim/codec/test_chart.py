"""Charts: rotations return exactly, vectors do not jump, spins are cut."""

import motions
import numpy as np

from geomstats_anim import rotations as quat
from geomstats_anim.codec import chart
from geomstats_anim.codec.chart import (
    LONGEST,
    charted_pieces,
    choose_turns,
    cube_rotations,
    references,
    to_rotations,
    to_vectors,
)


def spin(turns, n_frames=200):
    """One joint that turns about an axis at rest, shape=[F, 1, 4]."""
    axis = np.array([0.6, 0.0, 0.8])
    return quat.exp(2.0 * np.pi * turns * np.linspace(0.0, 1.0, n_frames)[:, None, None] * axis)


def test_the_cube_has_a_group_of_rotations():
    cube = cube_rotations()
    assert len(cube) == 24 and np.allclose(np.abs(cube[0]), [0, 0, 0, 1])
    products = quat.multiply(cube[:, None], cube[None]).reshape(-1, 1, 4)
    assert quat.distance(products, cube).min(axis=-1).max() < 1e-7


def test_rotations_return():
    animation = motions.motion(size=2.5)
    rest = animation.skeleton.rest_rotations
    reference = references(rest, choose_turns(rest, animation.rotations))
    vectors = to_vectors(reference, animation.rotations)
    assert quat.distance(to_rotations(reference, vectors), animation.rotations).max() < 1e-7


def test_vectors_grow_beyond_half_a_turn_without_a_jump():
    rotations = spin(0.9)
    vectors = to_vectors(np.array([[0.0, 0.0, 0.0, 1.0]]), rotations)
    assert np.linalg.norm(vectors[-1, 0]) > 0.89 * 2.0 * np.pi
    assert np.linalg.norm(np.diff(vectors, axis=0), axis=-1).max() < 0.03


def test_joints_far_from_rest_get_a_near_reference():
    rest = np.array([[0.0, 0.0, 0.0, 1.0]] * 2)
    rotations = np.stack([quat.exp(np.array([0.1, 0.0, 0.0])), quat.exp(np.array([3.0, 0.1, 0.0]))])[None]
    turns = choose_turns(rest, rotations)
    assert turns[0] == 0
    assert quat.distance(references(rest, turns)[1], rotations[0, 1]) < 0.3


def test_spins_have_charts_without_jumps():
    rotations, rest = spin(4.0), np.array([[0.0, 0.0, 0.0, 1.0]])
    bounds = charted_pieces(rest, rotations, np.array([0, len(rotations)]))
    assert bounds[0] == 0 and bounds[-1] == len(rotations)
    for start, stop in zip(bounds[:-1], bounds[1:], strict=True):
        piece = rotations[start:stop]
        vectors = to_vectors(references(rest, choose_turns(rest, piece)), piece)
        assert np.linalg.norm(vectors, axis=-1).max() <= LONGEST
        assert np.linalg.norm(np.diff(vectors, axis=0), axis=-1).max() < 1.0


def test_what_no_reference_covers_is_cut(monkeypatch):
    monkeypatch.setattr(chart, "LONGEST", 0.5)
    rotations, rest = spin(1.0), np.array([[0.0, 0.0, 0.0, 1.0]])
    bounds = charted_pieces(rest, rotations, np.array([0, len(rotations)]))
    assert len(bounds) > 4 and (np.diff(bounds) > 0).all()
