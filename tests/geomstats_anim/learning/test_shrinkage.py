"""How far a fit is trusted: as far as all folds agree, and no further."""

import numpy as np
import pytest
from wanderings import N_JOINTS, metric

from geomstats_anim import MetricParameters
from geomstats_anim.learning.learnable import Found
from geomstats_anim.learning.shrinkage import FACTORS, N_FOLDS, Fold, blocks, scaled, shrink
from geomstats_anim.parameters import CurveParameters


class Bowl:
    """Errors that grow with the square of the distance to a metric of one's own, joint by joint."""

    def __init__(self, log_alpha):
        self.log_alpha = np.asarray(log_alpha, dtype=float)

    def rotation_errors_by_joint(self, curve, effort="thorough"):
        return 1.0 + (np.log(curve.metric.alpha) - self.log_alpha) ** 2

    def value(self, curve):
        return float(self.rotation_errors_by_joint(curve).sum())


def best_of(bowl):
    """The search: it knows the answer."""
    curve = CurveParameters.geodesic(MetricParameters(np.exp(bowl.log_alpha), np.ones(len(bowl.log_alpha))))
    return Found(curve, bowl.value(curve), 1)


def shrunk(folds, fitted, find=best_of):
    curve = CurveParameters.geodesic(fitted)
    return shrink(folds, curve, CurveParameters.plain("geodesic", fitted.n_joints), find)


def folds_of(train, test):
    return [Fold(Bowl(one), Bowl(other)) for one, other in zip(train, test, strict=True)]


def test_folds_that_agree_keep_the_fit():
    fitted = metric(full=True)
    target = np.tile(np.log(fitted.alpha), (4, 1))
    result = shrunk(folds_of(target, target), fitted)
    np.testing.assert_array_equal(result.factors, 1.0)
    np.testing.assert_allclose(result.curve.metric.matrices, fitted.matrices, rtol=1e-14)
    assert result.score == pytest.approx(N_JOINTS)
    assert result.slerp_score == pytest.approx(N_JOINTS + (target[0] ** 2).sum())


@pytest.mark.parametrize("seed", range(10))
def test_folds_of_pure_noise_give_the_identity(seed):
    train, test = np.random.default_rng(seed).normal(size=(2, 4, 20))
    result = shrunk(folds_of(train, test), MetricParameters(np.full(20, 3.0), np.ones(20)))
    # one joint in twenty may be lucky in all folds
    assert np.mean(result.factors == 0.0) >= 0.85
    assert result.score <= result.slerp_score


def test_folds_that_contradict_each_other_give_the_identity():
    train = np.array([1.0, -1.0, 1.0, -1.0])[:, None] * np.ones(N_JOINTS)
    fitted = metric()
    result = shrunk(folds_of(train, -train), fitted)
    np.testing.assert_array_equal(result.factors, 0.0)
    np.testing.assert_array_equal(result.curve.metric.matrices, np.tile(np.eye(3), (N_JOINTS, 1, 1)))
    assert result.score == result.slerp_score


def test_a_fit_that_goes_too_far_is_taken_half_way():
    fitted = MetricParameters(np.full(3, np.exp(2.0)), np.ones(3))
    train = np.full((4, 3), 2.0)
    result = shrunk(folds_of(train, train / 2.0), fitted)
    np.testing.assert_array_equal(result.factors, 0.5)
    np.testing.assert_allclose(np.log(result.curve.metric.alpha), 1.0)


def test_each_joint_for_itself():
    train = np.tile([1.0, 1.0], (4, 1))
    result = shrunk(folds_of(train, train * [1.0, -1.0]), MetricParameters(np.full(2, np.e), np.ones(2)))
    np.testing.assert_array_equal(result.factors, [1.0, 0.0])


def test_the_quality_itself_has_the_last_word():
    """Rotations gain, but what counts, the location, loses."""

    class Lopsided(Bowl):
        def value(self, curve):
            return 100.0 - super().value(curve)

    target = np.ones((4, 2))
    folds = [Fold(Lopsided(one), Lopsided(one)) for one in target]
    result = shrunk(folds, MetricParameters(np.full(2, np.e), np.ones(2)))
    np.testing.assert_array_equal(result.factors, 0.0)
    np.testing.assert_array_equal(result.curve.metric.alpha, 1.0)


@pytest.mark.parametrize("n_folds", [0, 1])
def test_fewer_than_two_folds_say_nothing(n_folds):
    def refuse(_):
        raise AssertionError("there is nothing to search")

    folds = folds_of(np.ones((n_folds, N_JOINTS)), np.ones((n_folds, N_JOINTS)))
    result = shrunk(folds, metric(), refuse)
    np.testing.assert_array_equal(result.curve.metric.matrices, np.tile(np.eye(3), (N_JOINTS, 1, 1)))
    np.testing.assert_array_equal(result.factors, 0.0)
    np.testing.assert_equal(result.score, result.slerp_score)


@pytest.mark.parametrize("full", [False, True])
def test_the_ends_of_scaling(full):
    fitted = metric(full=full)
    plain = CurveParameters.plain("geodesic", N_JOINTS)

    def at(factor):
        return scaled(CurveParameters.geodesic(fitted), np.full(N_JOINTS, factor), plain).metric

    at_rest, whole = at(0.0), at(1.0)
    np.testing.assert_allclose(at_rest.matrices, np.tile(np.eye(3), (N_JOINTS, 1, 1)), atol=1e-15)
    np.testing.assert_array_equal(whole.matrices, fitted.matrices)
    half = at(0.5)
    np.testing.assert_allclose(half.matrices @ half.matrices, fitted.matrices, rtol=1e-12, atol=1e-12)
    assert at_rest.invariance == half.invariance == fitted.invariance


def test_the_factors_reach_from_identity_to_fit():
    assert (FACTORS[0], FACTORS[-1]) == (0.0, 1.0)
    assert (np.diff(FACTORS) > 0.0).all()


@pytest.mark.parametrize("n_segments", [0, 1, 2, 3, 4, 5, 17, 100])
def test_blocks_cover_all_segments_once(n_segments):
    found = blocks(n_segments)
    np.testing.assert_array_equal(np.concatenate([*found, []]), np.arange(n_segments))
    assert len(found) == min(n_segments, N_FOLDS)
    lengths = [len(block) for block in found]
    assert not lengths or max(lengths) - min(lengths) <= 1
