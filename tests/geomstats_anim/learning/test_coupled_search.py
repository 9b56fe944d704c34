"""Learning metrics that couple joints."""

import dataclasses

import numpy as np
import pytest
from swings import objective_of, swinging

from geomstats_anim import LearnedMetric, interpolate, learn_metric, quality
from geomstats_anim import rotations as quat
from geomstats_anim.parameters import CurveParameters, MetricParameters

KEYS = np.arange(0, 33, 8)


def gently_swinging(seed):
    animation = swinging(seed)
    turns = quat.log(quat.multiply(quat.conjugate(animation.rotations[:1]), animation.rotations))
    return dataclasses.replace(animation, rotations=quat.exp(0.5 * turns))


def some_curve(rng, tension=1.2):
    metric = MetricParameters([2.0, 0.5, 1.0], [0.7, 1.5, 2.0], rng.normal(size=(3, 3)), ("left", "right", "left"))
    return CurveParameters(metric, np.full(3, tension), np.full(3, 0.8), 0.4 * rng.normal(size=(3, 3, 2)))


def test_the_objective_and_its_derivative_by_the_coupling():
    rng = np.random.default_rng(0)
    objective, curve = objective_of(), some_curve(rng)
    metric = LearnedMetric(
        objective.skeleton.joints,
        curve.metric,
        curve.tension,
        "geodesic-spline",
        translation_tension=curve.translation_tension,
        coupling=curve.coupling,
    )
    rebuilt = interpolate(objective.animation.at_frames(KEYS), objective.animation.times, metric=metric)
    assert objective.quality(curve) == pytest.approx(quality(rebuilt, objective.animation), rel=1e-9)
    value, gradient = objective.value_and_gradient(curve)
    assert value == pytest.approx(objective.value(curve), rel=1e-9)
    assert gradient.shape == (3, 7 + 6)
    step, direction = 1e-4, rng.normal(size=curve.coupling.shape)
    ends = [dataclasses.replace(curve, coupling=curve.coupling + sign * step * direction) for sign in (1.0, -1.0)]
    slope = (objective.value(ends[0]) - objective.value(ends[1])) / (2.0 * step)
    assert (gradient[:, 5:-2].reshape(direction.shape) * direction).sum() == pytest.approx(slope, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "invariance"), [("geodesic", "joint"), ("geodesic-spline", "left")])
def test_a_coupled_metric_is_never_worse_than_what_it_contains(scheme, invariance):
    words = {"scheme": scheme, "invariance": invariance, "kind": "rot"}
    animation = gently_swinging(2)
    spd = learn_metric(animation, KEYS, family="spd", **words)
    coupled = learn_metric(animation, KEYS, family="coupled", **words)
    assert coupled.provenance["score"] <= spd.provenance["score"] * (1.0 + 1e-9)
    rebuilt = interpolate(animation.at_frames(KEYS), animation.times, metric=LearnedMetric.from_json(coupled.to_json()))
    assert quality(rebuilt, animation, "rot") == pytest.approx(coupled.provenance["score"], rel=1e-9)


@pytest.mark.slow
def test_a_coupling_that_made_a_motion_is_worth_learning():
    """A motion along geodesics of a coupled metric is rebuilt far better than metrics joint by joint can."""
    animation, rng = gently_swinging(1), np.random.default_rng(4)
    parameters = MetricParameters([2.0, 0.5, 1.0], [0.7, 1.5, 2.0])
    metric = LearnedMetric(animation.skeleton.joints, parameters, coupling=rng.normal(size=(3, 3, 2)))
    made = interpolate(animation.at_frames(KEYS), animation.times, metric=metric)
    words = {"scheme": "geodesic", "invariance": "left", "kind": "rot"}
    scores = [learn_metric(made, KEYS, family=family, **words).provenance["score"] for family in ("spd", "coupled")]
    assert scores[1] < 0.2 * scores[0]


@pytest.mark.parametrize("words", [{"search": "tpe"}, {"purpose": "predict"}])
def test_what_cannot_be_coupled_is_refused(words):
    with pytest.raises(ValueError, match='"coupled" is learned with the search "gradient" and the purpose'):
        learn_metric(swinging(), KEYS, family="coupled", **words)
    with pytest.raises(ValueError, match="the families are diagonal, spd, coupled"):
        learn_metric(swinging(), KEYS, family="full")
