"""Lattices: levers are root mean square distances, values and coordinates are inverse."""

import motions
import numpy as np
import pytest

from geomstats_anim.codec.lattice import (
    LARGEST_CODE,
    Layout,
    Steps,
    code_of,
    levers,
    new_lattice,
    step_of,
    to_coefficients,
    to_lattice_coordinates,
    to_values,
)
from geomstats_anim.kinematics import place
from geomstats_anim.names import SHELL_RADIUS


def test_levers_are_distances_to_what_hangs_below():
    skeleton = motions.rig(9)
    rest = place(skeleton, skeleton.rest_rotations[None], skeleton.rest_translations[None])
    below = np.eye(9, dtype=bool)
    for joint in range(8, 0, -1):
        below[skeleton.parents[joint]] |= below[joint]
    for joint in range(9):
        points = np.concatenate([rest.origins[0][below[joint]], rest.ends[0][below[joint]]])
        square = ((points - rest.origins[0, joint]) ** 2).sum(axis=-1).mean() + SHELL_RADIUS**2
        assert levers(skeleton)[joint] == pytest.approx(np.sqrt(square), rel=2**0.125 - 1 + 1e-6)


def test_codes_of_steps():
    for step in (1e-6, 1e-3, 0.37, 5.0):
        assert step / 2**0.25 * (1 - 1e-9) < step_of(code_of(step)) <= step * (1 + 1e-9)
    assert code_of(1e30) == LARGEST_CODE and code_of(1e-30) == 0
    assert code_of(step_of(17)) == 17


@pytest.mark.parametrize("n_frames", [1, 2, 30])
def test_coordinates_invert_values(n_frames):
    layout = Layout.of(motions.rig(), True, True, 2)
    lattice = new_lattice(layout, Steps(60, 50, (40, 41)), n_frames, with_basis=True)
    lattice.integers[:] = np.random.default_rng(0).integers(-5, 6, lattice.integers.shape)
    coordinates = to_lattice_coordinates(lattice, to_coefficients(to_values(lattice)))
    assert np.abs(coordinates - lattice.integers).max() < 1e-10


def test_other_groups_have_their_own_steps():
    layout = Layout.of(motions.rig(4), False, True, 2)
    lattice = new_lattice(layout, Steps(60, 50, (40, 48)), 1, with_basis=False)
    assert lattice.units[-1, -2:] == pytest.approx(step_of(np.array([40, 48])))
    assert lattice.units[-1, 4:8] * layout.levers[4:8] == pytest.approx(step_of(50))
