"""The derivative of geodesics between fixed poses by their metric, against central finite differences."""

import numpy as np
import oracles
import pytest
import samples

from geomstats_anim import LogStatus, MetricParameters
from geomstats_anim import rotations as quat
from geomstats_anim.geodesics.pose_geodesics import PoseGeodesics

N_JOINTS = 11
N_SEGMENTS = 3
INDEX = np.repeat(np.arange(N_SEGMENTS), 7)
# the ends included; the same sample twice
PARAMETER = np.tile([0.0, 0.1, 0.1, 0.5, 0.73, 0.99, 1.0], N_SEGMENTS)
# hat(e) of the basis vectors e
GENERATORS = oracles.cross_matrix(np.eye(3))


def problem(seed, low, high, condition=8.0, full=False, invariance=None):
    rng = np.random.default_rng(seed)
    initial = samples.quaternions(rng, N_SEGMENTS, N_JOINTS)
    turns = samples.gaps(rng, N_SEGMENTS * N_JOINTS, low, high).reshape(N_SEGMENTS, N_JOINTS, 3)
    end = quat.multiply(initial, quat.exp(turns))
    parameters = samples.parameters(rng, N_JOINTS, condition, full, invariance)
    return initial, end, parameters, rng.normal(size=(len(INDEX), N_JOINTS, 3, 3))


def scalars(rotations, coefficients):
    """One for each joint: a linear function of the entries of its rotation matrices."""
    return np.einsum("fbij,fbij->b", coefficients, quat.to_matrix(rotations))


def gradient(initial, end, parameters, coefficients, index=INDEX, parameter=PARAMETER):
    geodesics = PoseGeodesics.between(initial, end, parameters)
    rotations = geodesics(index, parameter)
    # body variation x moves R by R hat(x)
    cotangent = np.einsum("fbij,fbik,dkj->fbd", coefficients, quat.to_matrix(rotations), GENERATORS)
    return geodesics, geodesics.pull_back(index, parameter, rotations, cotangent)


def differences(initial, end, parameters, coefficients, step=1e-4):
    """Central, of fourth order: the geodesics of neighbouring metrics are followed, so that the branch is the same."""
    geodesics = PoseGeodesics.between(initial, end, parameters)
    out = np.empty((N_JOINTS, 5))
    for direction in range(5):
        values = []
        for factor in (-2.0, -1.0, 1.0, 2.0):
            near = PoseGeodesics.between(
                initial, end, samples.moved(parameters, direction, factor * step), geodesics.velocity
            )
            values.append(scalars(near(INDEX, PARAMETER), coefficients))
        out[:, direction] = (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)
    return out


@pytest.mark.parametrize("invariance", ["left", "right", None])
@pytest.mark.parametrize("full", [False, True], ids=["diagonal", "full"])
@pytest.mark.parametrize(("low", "high"), [(5, 45), (45, 90), (90, 150)])
def test_finite_differences(low, high, full, invariance):
    case = problem(0, low, high, full=full, invariance=invariance)
    geodesics, found = gradient(*case)
    assert (geodesics.status == LogStatus.CONVERGED).all()
    expected = differences(*case)
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(found - expected) / scale).max() < 1e-5


@pytest.mark.parametrize("condition", [30.0, 100.0])
def test_strongly_anisotropic(condition):
    case = problem(1, 60, 150, condition, full=True)
    _, found = gradient(*case)
    expected = differences(*case)
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(found - expected) / scale).max() < 1e-5


def test_gaps_of_150_degrees():
    case = problem(2, 150, 150)
    _, found = gradient(*case)
    expected = differences(*case)
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(found - expected) / scale).max() < 1e-5


@pytest.mark.parametrize("invariance", ["left", "right"])
def test_at_the_identity_metric(invariance):
    initial, end, _, coefficients = problem(3, 20, 120)
    case = initial, end, MetricParameters(np.ones(N_JOINTS), np.ones(N_JOINTS), None, invariance), coefficients
    _, found = gradient(*case)
    expected = differences(*case)
    assert np.abs(found[:, :2] - expected[:, :2]).max() < 1e-5 * np.abs(expected).max()
    # all axes are the same to a multiple of the identity
    assert np.abs(found[:, 2:]).max() < 1e-12


def test_it_shrinks_with_the_square_of_tiny_gaps():
    initial, _, parameters, coefficients = problem(4, 1, 1, full=True)
    turns = samples.gaps(np.random.default_rng(5), N_SEGMENTS * N_JOINTS, 57.0, 57.0).reshape(N_SEGMENTS, N_JOINTS, 3)
    ratios = []
    for gap in (1e-3, 1e-5):
        end = quat.multiply(initial, quat.exp(gap * turns))
        ratios.append(gradient(initial, end, parameters, coefficients)[1] / gap**2)
    np.testing.assert_allclose(ratios[0], ratios[1], atol=1e-2 * np.abs(ratios[1]).max())


@pytest.mark.parametrize("gap", [0.0, 1e-300, 1e-160, 1e-12])
def test_no_gap_no_derivative(gap):
    initial, _, parameters, coefficients = problem(6, 1, 1, full=True)
    end = quat.multiply(initial, quat.exp(np.full((N_SEGMENTS, N_JOINTS, 3), gap)))
    _, found = gradient(initial, end, parameters, coefficients)
    assert np.abs(found).max() < 1e-10


def test_a_segment_without_gap_beside_others_adds_nothing():
    initial, end, parameters, coefficients = problem(7, 20, 90)
    end[1] = initial[1]
    _, found = gradient(initial, end, parameters, coefficients)
    kept = INDEX != 1
    _, others = gradient(initial, end, parameters, coefficients[kept], INDEX[kept], PARAMETER[kept])
    np.testing.assert_allclose(found, others, atol=1e-12)


def test_the_ends_do_not_move():
    initial, end, parameters, coefficients = problem(8, 20, 150, full=True)
    index, parameter = np.repeat(np.arange(N_SEGMENTS), 2), np.tile([0.0, 1.0], N_SEGMENTS)
    _, found = gradient(initial, end, parameters, coefficients[: len(index)], index, parameter)
    assert np.abs(found).max() < 1e-10


def test_no_samples():
    initial, end, parameters, coefficients = problem(9, 20, 90)
    none = INDEX < 0
    _, found = gradient(initial, end, parameters, coefficients[none], INDEX[none], PARAMETER[none])
    assert not found.any()


def test_joints_are_independent_of_their_company():
    initial, end, parameters, coefficients = problem(10, 20, 150, full=True)
    _, together = gradient(initial, end, parameters, coefficients)
    for joint in range(N_JOINTS):
        one = slice(joint, joint + 1)
        alone = MetricParameters(
            parameters.alpha[one], parameters.beta[one], parameters.axes[one], parameters.invariance[one]
        )
        _, found = gradient(initial[:, one], end[:, one], alone, coefficients[:, one])
        np.testing.assert_allclose(found[0], together[joint], rtol=1e-9, atol=1e-12)


def test_a_fallback_does_not_depend_on_the_metric():
    initial, end, parameters, coefficients = problem(11, 20, 90)
    geodesics, before = gradient(initial, end, parameters, coefficients)
    rotations = geodesics(INDEX, PARAMETER)
    geodesics.status[:, 3] = LogStatus.STALLED
    after = geodesics.pull_back(INDEX, PARAMETER, rotations, np.ones((len(INDEX), N_JOINTS, 3)))
    assert before[3].any() and not after[3].any()
    assert after[4].any()
