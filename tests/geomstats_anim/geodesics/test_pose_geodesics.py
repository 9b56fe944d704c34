"""Geodesics on SO(3)^B between poses: any SPD matrix and either side, against Euler's equations and by their laws."""

import numpy as np
import oracles
import pytest
import samples

from geomstats_anim import LogStatus, MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics import pose_geodesics as geodesics_module
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics

pytestmark = pytest.mark.filterwarnings("error")

BAR = 1e-10  # radians
SIDES = ("left", "right")


def pairs(rng, n_segments, n_joints, low, high):
    """Two poses, shape=[n_segments, n_joints, 4], that are `low` to `high` degrees apart."""
    initial = samples.quaternions(rng, n_segments, n_joints)
    turn = samples.gaps(rng, n_segments * n_joints, low, high).reshape(n_segments, n_joints, 3)
    return initial, quat.multiply(initial, quat.exp(turn))


def at(geodesics, parameter):
    """Poses of every geodesic at one parameter, shape=[n, B, 4]."""
    n = len(geodesics.initial)
    return geodesics(np.arange(n), np.full(n, float(parameter)))


def certain(seed=1, n_segments=5, n_joints=40, **kind):
    """Geodesics so short that there is only one shortest."""
    rng = np.random.default_rng(seed)
    parameters = samples.parameters(rng, n_joints, 8.0, **kind)
    initial, end = pairs(rng, n_segments, n_joints, 0.0, 40.0)
    return initial, end, parameters


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(
    "low, high, n, at_least",
    [
        (0.0, 170.0, 1000, 0.999),
        (170.0, 180.0, 400, 0.99),
        pytest.param(0.0, 170.0, 25_000, 0.999, marks=pytest.mark.slow),
        pytest.param(170.0, 180.0, 5_000, 0.99, marks=pytest.mark.slow),
    ],
)
def test_ends_where_it_should(full, side, low, high, n, at_least):
    rng = np.random.default_rng(2)
    parameters = samples.parameters(rng, n, 100.0, full=full, invariance=side)
    initial, end = pairs(rng, 1, n, low, high)
    with np.errstate(all="raise", under="ignore"):
        geodesics = PoseGeodesics.between(initial, end, parameters)
        reached = at(geodesics, 1.0)
    converged = geodesics.status == LogStatus.CONVERGED
    assert converged.mean() >= at_least
    for values in (geodesics.velocity, geodesics.residual, reached):
        assert np.isfinite(values).all()
    assert quat.distance(reached, end)[converged].max() < BAR

    # Euler's equations say the same, from the velocity alone
    some = np.flatnonzero(converged[0])[:200]

    def solved(velocity):
        start = quat.to_matrix(initial[0, some])
        return oracles.velocity_form(parameters.matrices[some], velocity, start, right=parameters.is_right[some])[0][0]

    velocity = geodesics.velocity[0, some]
    found = solved(velocity)
    errors = oracles.angle_between(found, quat.to_matrix(end[0, some]))
    # A turn of more than 360 degrees close to a separatrix blows up the rounding of the velocity itself.
    rounding = 2.0 * np.spacing(1.0) * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0]])
    far = np.flatnonzero(errors >= BAR)
    if len(far):
        assert len(far) <= 0.01 * len(some) and (np.linalg.norm(velocity[far], axis=-1) > 2.0 * np.pi).all()
        moved = [oracles.angle_between(solved(velocity * (1.0 + by)), found)[far] for by in rounding]
        assert (errors[far] <= np.max(moved, axis=0)).all()


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
def test_in_between_it_obeys_eulers_equations(full):
    initial, end, parameters = certain(full=full)
    geodesics = PoseGeodesics.between(initial, end, parameters)
    inner = [0.1, 0.5, 0.9]
    for k in range(len(initial)):
        poses, _ = oracles.velocity_form(
            parameters.matrices, geodesics.velocity[k], quat.to_matrix(initial[k]), parameters.is_right, inner
        )
        mine = geodesics(np.full(3, k), np.array(inner))
        assert oracles.angle_between(quat.to_matrix(mine), poses).max() < BAR


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
def test_from_a_velocity_it_obeys_eulers_equations(full):
    rng = np.random.default_rng(3)
    parameters = samples.parameters(rng, 100, 100.0, full=full)
    initial = samples.quaternions(rng, 1, 100)
    velocity = samples.gaps(rng, 100, 0.0, 360.0)[None]
    geodesics = PoseGeodesics(initial, velocity, parameters)
    poses, _ = oracles.velocity_form(
        parameters.matrices, velocity[0], quat.to_matrix(initial[0]), parameters.is_right, [0.5, 1.0]
    )
    assert oracles.angle_between(quat.to_matrix(geodesics(np.zeros(2, int), np.array([0.5, 1.0]))), poses).max() < BAR
    energy = np.einsum("bi,bij,bj->b", velocity[0], parameters.matrices, velocity[0])
    np.testing.assert_allclose(geodesics.length[0], np.sqrt(energy), rtol=1e-12)


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
def test_exp_after_log_and_log_after_exp(full):
    initial, end, parameters = certain(full=full)
    log = PoseGeodesics.between(initial, end, parameters)
    exp = PoseGeodesics(initial, log.velocity, parameters)
    assert quat.distance(at(exp, 1.0), end).max() < BAR
    np.testing.assert_allclose(exp.length, log.length, rtol=1e-12)
    again = PoseGeodesics.between(initial, at(exp, 1.0), parameters)
    np.testing.assert_allclose(again.velocity, log.velocity, atol=1e-10)


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
def test_right_is_left_of_the_inverses(full):
    initial, end, parameters = certain(full=full, invariance="left")
    right = MetricParameters(parameters.alpha, parameters.beta, parameters.axes, "right")
    mine = PoseGeodesics.between(initial, end, right)
    inverse = PoseGeodesics.between(quat.conjugate(initial), quat.conjugate(end), parameters)
    for t in (0.0, 0.3, 1.0):
        assert quat.distance(at(mine, t), quat.conjugate(at(inverse, t))).max() < BAR


@pytest.mark.parametrize("side", SIDES)
def test_full_is_diagonal_conjugated(side):
    initial, end, parameters = certain(full=True, invariance=side)
    axes = parameters.axes_quaternions
    diagonal = MetricParameters(parameters.alpha, parameters.beta, None, side)

    def conjugated(pose):
        return quat.multiply(quat.multiply(axes, pose), quat.conjugate(axes))

    mine = PoseGeodesics.between(initial, end, parameters)
    other = PoseGeodesics.between(conjugated(initial), conjugated(end), diagonal)
    np.testing.assert_allclose(mine.length, other.length, rtol=1e-10)
    for t in (0.3, 1.0):
        assert quat.distance(conjugated(at(mine, t)), at(other, t)).max() < BAR


@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
def test_back_is_the_same_way(full):
    initial, end, parameters = certain(full=full)
    there = PoseGeodesics.between(initial, end, parameters)
    back = PoseGeodesics.between(end, initial, parameters)
    np.testing.assert_allclose(back.length, there.length, rtol=1e-10)
    for t in (0.0, 0.25, 0.8, 1.0):
        assert quat.distance(at(back, 1.0 - t), at(there, t)).max() < BAR


@pytest.mark.parametrize("side", SIDES)
def test_translations_of_its_own_side_are_isometries(side):
    initial, end, parameters = certain(full=True, invariance=side)
    shift = samples.quaternions(np.random.default_rng(4), 40)

    def moved(pose):
        return quat.multiply(shift, pose) if side == "left" else quat.multiply(pose, shift)

    mine = PoseGeodesics.between(initial, end, parameters)
    other = PoseGeodesics.between(moved(initial), moved(end), parameters)
    np.testing.assert_allclose(other.velocity, mine.velocity, atol=1e-10)
    assert quat.distance(moved(at(mine, 0.4)), at(other, 0.4)).max() < BAR


@pytest.mark.parametrize("side", SIDES)
def test_the_scale_of_the_matrix_does_not_matter(side):
    initial, end, parameters = certain(full=True, invariance=side)
    one, seven = (MetricParameters.from_matrices(s * parameters.matrices, side) for s in (1.0, 7.0))
    ends = [at(PoseGeodesics.between(initial, end, z), 0.5) for z in (one, seven)]
    assert quat.distance(*ends).max() < BAR


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("axes", [None, (0.4, -0.2, 0.9)])
def test_the_identity_metric_slerps(side, axes):
    rng = np.random.default_rng(5)
    initial, end = pairs(rng, 4, 50, 0.0, 179.0)
    ones = np.ones(50)
    parameters = MetricParameters(ones, ones, None if axes is None else np.tile(axes, (50, 1)), side)
    geodesics = PoseGeodesics.between(initial, end, parameters)
    assert (geodesics.status == LogStatus.CONVERGED).all()
    np.testing.assert_allclose(geodesics.length, quat.distance(initial, end), atol=1e-12)
    for t in (0.0, 0.37, 1.0):
        assert quat.distance(at(geodesics, t), quat.slerp(initial, end, np.full((4, 50), t))).max() < 1e-12


def test_the_sign_of_a_quaternion_does_not_matter():
    initial, end, parameters = certain()
    one, two = (PoseGeodesics.between(initial, sign * end, parameters) for sign in (1.0, -1.0))
    np.testing.assert_array_equal(one.velocity, two.velocity)


def test_playback_far_beyond_the_end_and_at_repeated_parameters():
    initial, end, parameters = certain(n_segments=1, full=True)
    geodesics = PoseGeodesics.between(initial, end, parameters)
    parameter = np.array([0.0, 0.0, 0.5, 0.5, 1.0, 6.0, 6.0])
    poses = geodesics(np.zeros(7, dtype=int), parameter)
    for i in (0, 2, 5):
        np.testing.assert_array_equal(poses[i], poses[i + 1])
    expected, _ = oracles.velocity_form(
        parameters.matrices, geodesics.velocity[0], quat.to_matrix(initial[0]), parameters.is_right, [6.0]
    )
    assert oracles.angle_between(quat.to_matrix(poses[-1]), expected[0]).max() < BAR


def test_geodesics_without_samples_are_skipped():
    initial, end, parameters = certain(n_segments=4)
    geodesics = PoseGeodesics.between(initial, end, parameters)
    poses = geodesics(np.array([1, 3]), np.array([1.0, 1.0]))
    assert quat.distance(poses, end[[1, 3]]).max() < BAR
    assert geodesics(np.empty(0, dtype=int), np.empty(0)).shape == (0, 40, 4)


@pytest.mark.parametrize("n_segments, n_joints", [(0, 3), (1, 1), (3, 0), (0, 0)])
def test_no_segments_or_joints(n_segments, n_joints):
    rng = np.random.default_rng(6)
    initial, end = pairs(rng, n_segments, n_joints, 0.0, 90.0)
    geodesics = PoseGeodesics.between(initial, end, samples.parameters(rng, n_joints, 4.0))
    assert geodesics.status.shape == (n_segments, n_joints)
    if n_segments:
        assert at(geodesics, 1.0).shape == (n_segments, n_joints, 4)


@pytest.mark.parametrize("change", ["float32", "not contiguous", "read-only"])
def test_arrays_of_every_kind(change):
    initial, end, parameters = certain()
    if change == "float32":
        initial, end = initial.astype(np.float32), end.astype(np.float32)
    if change == "not contiguous":
        initial, end = np.asfortranarray(initial), np.repeat(end, 2, axis=1)[:, ::2]
    if change == "read-only":
        initial.setflags(write=False)
        end.setflags(write=False)
    geodesics = PoseGeodesics.between(initial, end, parameters)
    assert quat.distance(at(geodesics, 1.0), end).max() < (1e-6 if change == "float32" else BAR)


def test_the_same_bits_alone_and_among_others():
    initial, end, parameters = certain(full=True)
    together = PoseGeodesics.between(initial, end, parameters)
    alone = PoseGeodesics.between(initial[2:3], end[2:3], parameters)
    np.testing.assert_array_equal(alone.velocity[0], together.velocity[2])
    np.testing.assert_array_equal(at(alone, 0.7)[0], at(together, 0.7)[2])


def test_where_none_is_found_it_is_the_bi_invariant_one(monkeypatch):
    initial, end, parameters = certain(full=True)
    solve = geodesics_module.shortest_momenta

    def fail_some(*problems):
        found = solve(*problems)
        found.status[::3], found.energy[::3] = LogStatus.STALLED, np.inf
        return found

    monkeypatch.setattr(geodesics_module, "shortest_momenta", fail_some)
    geodesics = PoseGeodesics.between(initial, end, parameters)
    failed = geodesics.status == LogStatus.STALLED
    assert failed.ravel()[::3].all() and failed.sum() == len(failed.ravel()[::3])
    assert np.isinf(geodesics.length[failed]).all() and np.isfinite(geodesics.length[~failed]).all()
    for t in (0.0, 0.3, 1.0):
        slerped = quat.slerp(initial, end, np.full(failed.shape, t))
        assert quat.distance(at(geodesics, t), slerped)[failed].max() < 1e-12


def test_every_status_has_a_sentence():
    for status in LogStatus:
        assert str(status)[0].isupper() and str(status).endswith(".")
