"""The search's polynomials against errors that are measured anew, and its stops."""

import motions
import numpy as np
import pytest

from geomstats_anim.codec.lattice import to_coefficients, to_values
from geomstats_anim.codec.packer import Packer
from geomstats_anim.codec.search import EFFORTS, largest_errors, search
from geomstats_anim.codec.stream import Header
from geomstats_anim.kernels import lattice_search as kernel
from geomstats_anim.kernels.contexts import ROTATION, TRANSLATION
from geomstats_anim.markers import Markers


def started(animation, scales):
    """What is searched: integers, the motion that they stand for, and the samples that they should."""
    header = Header(animation.times, True, scales, ())
    packer = Packer(animation, header, Markers.of_shell(animation), 0.01, 1e-3, {}, "full")
    turns = np.zeros(animation.n_joints, dtype=np.intp)
    values = packer.values(animation, turns, packer.others)
    lattice, _ = packer.rounded(to_coefficients(values), packer.steps[0])
    return lattice, packer.pose(animation, turns, values, lattice)


@pytest.fixture
def pose():
    """A pose a little beside its targets, with scales and a placement in the world."""
    animation = motions.motion(12, scales=True)
    _, pose = started(animation, True)
    rng = np.random.default_rng(0)
    pose.vectors[:] += 0.003 * rng.normal(size=pose.vectors.shape)
    pose.world[:] = rng.normal(size=(1, 3, 4))
    kernel.place_all(pose)
    matrices = pose.matrices[:, np.repeat(np.arange(6), np.diff(pose.first_marker))]
    places = np.einsum("fpij,pj->fpi", matrices[..., :3], pose.offsets) + matrices[..., 3]
    pose.targets[:] = places + 0.004 * rng.normal(size=places.shape)
    return pose


def total(pose, tolerance):
    """Sum of the eighth powers of the errors over the tolerance, frame by frame."""
    matrices = pose.matrices[:, np.repeat(np.arange(6), np.diff(pose.first_marker))]
    places = np.einsum("fpij,pj->fpi", matrices[..., :3], pose.offsets) + matrices[..., 3]
    return ((np.linalg.norm(places - pose.targets, axis=-1) / tolerance) ** 8).sum(axis=-1)


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("kind", [ROTATION, TRANSLATION])
def test_polynomials_are_errors_to_first_order(pose, joint, kind):
    tolerance, step = 0.01, 1e-6
    below = pose.members[pose.below[joint] : pose.below[joint + 1]]
    terms, relative = np.empty((kernel.TERMS, 12)), np.empty((6, 3, 4))
    for c in range(3):
        place = pose.vectors if kind == ROTATION else pose.translations
        kernel.gather(pose, joint, kind, c, tolerance, relative, terms)
        others = total(pose, tolerance)
        slopes = []
        for sign in (1.0, -2.0):
            place[:, joint, c] += sign * step
            kernel.place_all(pose)
            slopes.append(total(pose, tolerance))
        place[:, joint, c] += step
        kernel.place_all(pose)
        slope = (slopes[0] - slopes[1]) / (2.0 * step)
        assert terms[1] == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(slope).max())
        assert (terms[0] <= others * (1 + 1e-12)).all() and len(below) >= 1
    if joint == 0:
        assert terms[0] == pytest.approx(others, rel=1e-12)


def test_translations_are_exact_at_any_distance(pose):
    terms, relative, tolerance = np.empty((kernel.TERMS, 12)), np.empty((6, 3, 4)), 0.01
    kernel.gather(pose, 0, TRANSLATION, 1, tolerance, relative, terms)
    before = total(pose, tolerance)
    predicted = kernel.change(terms, 0, np.ones(12), 0.02)
    pose.translations[:, 0, 1] += 0.02
    kernel.place_all(pose)
    assert total(pose, tolerance).sum() - before.sum() == pytest.approx(predicted, rel=1e-9)


def test_shifted_polynomials_are_the_same_polynomials():
    rng = np.random.default_rng(0)
    terms, values = rng.normal(size=(kernel.TERMS, 7)), rng.normal(size=5)
    moved = terms.copy()
    kernel.shift(moved, 1, values, 0.3)
    assert kernel.change(moved, 1, values, 0.2) == pytest.approx(
        kernel.change(terms, 1, values, 0.5) - kernel.change(terms, 1, values, 0.3), rel=1e-10
    )


def test_the_search_leaves_integers_and_motion_in_step():
    lattice, pose = started(motions.motion(30), False)
    kernel.place_all(pose)
    groups = np.argsort(lattice.joints, kind="stable")
    assert search(pose, lattice, groups, 0.01, EFFORTS["full"])
    assert largest_errors(pose).max() <= 0.01
    values = to_values(lattice)
    assert np.abs(pose.vectors - values[:, :6]).max() < 1e-12
    rest = motions.rig().rest_translations
    assert np.abs(pose.translations - rest - values[:, 6:12]).max() < 1e-12
