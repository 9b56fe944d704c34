"""Metric parameters: what they mean, what they refuse, and how they are stored."""

import json

import numpy as np
import pytest
import samples

from geomstats_anim import LearnedMetric, MetricParameters
from geomstats_anim import rotations as quat

pytestmark = pytest.mark.filterwarnings("error")


def learned(rng, n, full=True, **changes):
    values = {
        "joints": [f"joint{i}" for i in range(n)],
        "parameters": samples.parameters(rng, n, 100.0, full=full),
        "tension": rng.uniform(size=n),
        "translation_tension": rng.uniform(size=n),
        "scheme": "geodesic-spline",
        "quality": "hyb",
        "provenance": {"source": "walk.usda", "seed": 3, "scores": [0.1, 1e-300], "nested": {"a": None}},
    }
    return LearnedMetric(**{**values, **changes})


def assert_same(one, other):
    assert (one.joints, one.scheme, one.quality) == (other.joints, other.scheme, other.quality)
    assert one.provenance == other.provenance
    assert one.parameters.invariance == other.parameters.invariance
    np.testing.assert_array_equal(one.tension, other.tension)
    np.testing.assert_array_equal(one.translation_tension, other.translation_tension)
    for name in ("alpha", "beta", "axes"):
        np.testing.assert_array_equal(getattr(one.parameters, name), getattr(other.parameters, name))


def test_matrices():
    parameters = samples.parameters(np.random.default_rng(0), 50, 100.0, full=True)
    turn = quat.to_matrix(quat.exp(parameters.axes))
    diagonal = np.stack([np.diag([1.0, a, b]) for a, b in zip(parameters.alpha, parameters.beta, strict=True)])
    np.testing.assert_allclose(parameters.matrices, np.swapaxes(turn, -1, -2) @ diagonal @ turn, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.eigvalsh(parameters.matrices), np.sort(parameters.moments), rtol=1e-12)


@pytest.mark.parametrize("full", [False, True])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 7.0])
def test_from_matrices_gives_the_matrices_up_to_scale(full, scale):
    wanted = samples.parameters(np.random.default_rng(1), 50, 100.0, full=full)
    found = MetricParameters.from_matrices(scale * wanted.matrices, wanted.invariance)
    ratio = found.matrices / np.trace(found.matrices, axis1=1, axis2=2)[:, None, None]
    expected = wanted.matrices / np.trace(wanted.matrices, axis1=1, axis2=2)[:, None, None]
    np.testing.assert_allclose(ratio, expected, atol=1e-14)
    assert found.invariance == wanted.invariance
    assert (found.axes is None) == (not full)


def test_identity():
    parameters = MetricParameters.identity(3)
    np.testing.assert_array_equal(parameters.matrices, np.tile(np.eye(3), (3, 1, 1)))
    assert parameters.n_joints == 3
    assert MetricParameters.identity(0).matrices.shape == (0, 3, 3)


@pytest.mark.parametrize(
    "invariance, expected",
    [("right", ("right",) * 2), (["left", "right"], ("left", "right")), (["right"], ("right",) * 2)],
)
def test_invariance(invariance, expected):
    parameters = MetricParameters([1.0, 2.0], [1.0, 2.0], invariance=invariance)
    assert parameters.invariance == expected
    np.testing.assert_array_equal(parameters.is_right, [side == "right" for side in expected])


def test_they_are_frozen_copies():
    alpha = np.ones(2)
    parameters = MetricParameters(alpha, alpha)
    alpha[0] = 5.0
    assert parameters.alpha[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        parameters.alpha[0] = 2.0
    with pytest.raises(AttributeError):
        parameters.alpha = alpha


@pytest.mark.parametrize(
    "arguments, message",
    [
        (([1.0, 0.0], [1.0, 1.0]), "alpha of joint 1 is 0.0, but it must be a positive number."),
        (([1.0, 1.0], [-2.0, 1.0]), "beta of joint 0 is -2.0, but it must be a positive number."),
        (([np.nan], [1.0]), "alpha of joint 0 is nan, but it must be a positive number."),
        (([1.0], [np.inf]), "beta of joint 0 is inf, but it must be a positive number."),
        (([1.0, 1.0], [1.0]), "alpha has shape (2,) and beta (1,); one number per joint is needed."),
        (([[1.0]], [[1.0]]), "alpha has shape (1, 1) and beta (1, 1); one number per joint is needed."),
        (([1.0], [1.0], [0.0, 0.0, 0.0]), "axes has shape (3,); finite numbers of shape (1, 3) are needed."),
        (([1.0], [1.0], [[0.0, np.nan, 0.0]]), "axes has shape (1, 3); finite numbers of shape (1, 3) are needed."),
        (([1.0] * 3, [1.0] * 3, None, ["left"] * 2), "invariance has 2 words, but there are 3 joints."),
        (([1.0], [1.0], None, "up"), 'invariance of joint 0 is \'up\', but it must be "left" or "right".'),
    ],
)
def test_what_parameters_refuse(arguments, message):
    with pytest.raises(ValueError) as error:
        MetricParameters(*arguments)
    assert str(error.value) == message


@pytest.mark.parametrize(
    "matrices, message",
    [
        (np.eye(3), "matrices has shape (3, 3), but (B, 3, 3) is needed."),
        ([np.eye(3), np.full((3, 3), np.nan)], "matrices has a value that is not finite."),
        ([np.eye(3), np.eye(3) + np.eye(3, k=1)], "The matrix of joint 1 is not symmetric."),
        ([np.eye(3), np.diag([1.0, -2.0, 1.0])], "The matrix of joint 1 has the eigenvalue -2; it must be positive."),
        (
            [np.ones((3, 3)) * 2.0 - 3.0 * np.eye(3)],
            "The matrix of joint 0 has the eigenvalue -3; it must be positive.",
        ),
    ],
)
def test_what_from_matrices_refuses(matrices, message):
    with pytest.raises(ValueError) as error:
        MetricParameters.from_matrices(matrices)
    assert str(error.value) == message


@pytest.mark.parametrize("full", [False, True])
def test_json_round_trip_is_exact(full):
    metric = learned(np.random.default_rng(2), 20, full)
    text = metric.to_json()
    again = LearnedMetric.from_json(text)
    assert_same(again, metric)
    assert again.to_json() == text


def test_json_of_the_plainest_metric():
    metric = LearnedMetric(["a"], MetricParameters(2.0, 0.5))
    assert_same(LearnedMetric.from_json(metric.to_json()), metric)
    np.testing.assert_array_equal(metric.tension, [0.0])


def test_for_joints_matches_by_name():
    metric = learned(np.random.default_rng(3), 4)
    names = ("joint2", "new", "joint0")
    matched, missing = metric.for_joints(names)
    assert matched.joints == names
    assert missing == ("new",)
    for name in ("alpha", "beta", "axes"):
        values = getattr(matched.parameters, name)
        np.testing.assert_array_equal(values[[0, 2]], getattr(metric.parameters, name)[[2, 0]])
    sides = metric.parameters.invariance
    assert matched.parameters.invariance == (sides[2], "left", sides[0])
    np.testing.assert_allclose(matched.parameters.matrices[1], np.eye(3))
    for name in ("tension", "translation_tension"):
        values, usual = getattr(metric, name), float(metric.scheme == "geodesic-spline")
        np.testing.assert_array_equal(getattr(matched, name), [values[2], usual, values[0]])
    assert matched.provenance == metric.provenance


def test_for_its_own_joints_it_is_itself():
    metric = learned(np.random.default_rng(4), 5)
    matched, missing = metric.for_joints(metric.joints)
    assert missing == ()
    assert_same(matched, metric)


@pytest.mark.parametrize("joints", [(), ("x", "y")])
def test_for_joints_it_does_not_know(joints):
    matched, missing = learned(np.random.default_rng(5), 3).for_joints(joints)
    assert missing == joints
    assert matched.parameters.n_joints == len(joints)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"joints": ["a", "b", "a"]}, "Joint names must be unique, but 'a' is there twice."),
        ({"joints": ["a", "b"]}, "There are 2 joints, but metric parameters for 3."),
        ({"tension": [0.0, 1.0]}, "tension has shape (2,), but there are 3 joints."),
        ({"tension": [0.0, 1.0, np.nan]}, "tension of joint 2 is nan; it must be from 0 to 2."),
        ({"translation_tension": [0.0, -1.0, 3.0]}, "translation_tension of joint 1 is -1.0; it must be from 0 to 2."),
    ],
)
def test_what_a_learned_metric_refuses(changes, message):
    with pytest.raises(ValueError) as error:
        learned(np.random.default_rng(6), 3, **changes)
    assert str(error.value) == message


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda d: "{", "This is not JSON: "),
        (lambda d: "[1]", 'This JSON is not a metric: its "format" is not "geodesicMetric".'),
        (
            lambda d: json.dumps({**d, "format": "x"}),
            'This JSON is not a metric: its "format" is not "geodesicMetric".',
        ),
        (lambda d: json.dumps({**d, "version": 99}), "This metric has format version 99, but this program reads 1."),
        (lambda d: json.dumps({k: v for k, v in d.items() if k != "beta"}), "This metric has no 'beta'."),
        (lambda d: json.dumps({k: v for k, v in d.items() if k != "tension"}), "This metric has no 'tension'."),
        (lambda d: json.dumps({**d, "invariance": 3}), "This metric has a value of the wrong type: "),
        (lambda d: json.dumps({**d, "alpha": {}}), "This metric has a value of the wrong type: "),
        (
            lambda d: json.dumps({**d, "alpha": [-1.0] * 3}),
            "alpha of joint 0 is -1.0, but it must be a positive number.",
        ),
    ],
)
def test_what_from_json_refuses(change, message):
    document = json.loads(learned(np.random.default_rng(7), 3).to_json())
    with pytest.raises(ValueError) as error:
        LearnedMetric.from_json(change(document))
    assert str(error.value).startswith(message)
