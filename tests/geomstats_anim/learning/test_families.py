"""A larger family never scores worse, in sample, than one that it contains."""

from itertools import product

import numpy as np
import pytest
from real_files import CLIPS, needs_shared
from wanderings import N_JOINTS, real, wandering

from geomstats_anim import learn_metric, uniform_keyframes
from geomstats_anim.learning.descent import Tally
from geomstats_anim.learning.families import Families
from geomstats_anim.learning.gradient import search_gradient
from geomstats_anim.learning.objective import Objective
from geomstats_anim.names import FAMILIES, INVARIANCE_CHOICES, LEARNABLE
from geomstats_anim.parameters import CurveParameters

KEYS = uniform_keyframes(41, 0.15)
EXACT = 1.0 + 1e-9
LARGER_SIDES = (("clip", "left"), ("clip", "right"), ("joint", "clip"))


def check_order(score):
    """Check every pair of families of which one contains the other; the keys are scheme, family and invariance."""
    for family, invariance in product(FAMILIES, INVARIANCE_CHOICES):
        assert score["geodesic-spline", family, invariance] <= EXACT * score["geodesic", family, invariance]
    for scheme, invariance in product(LEARNABLE, INVARIANCE_CHOICES):
        assert score[scheme, "spd", invariance] <= EXACT * score[scheme, "diagonal", invariance]
    for scheme, family, (larger, smaller) in product(LEARNABLE, FAMILIES, LARGER_SIDES):
        assert score[scheme, family, larger] <= EXACT * score[scheme, family, smaller]


def scores(animation, keys, **words):
    """Score every family by itself."""
    found = {}
    for key in product(LEARNABLE, FAMILIES, INVARIANCE_CHOICES):
        scheme, family, invariance = key
        metric = learn_metric(animation, keys, scheme=scheme, family=family, invariance=invariance, **words)
        found[key] = metric.provenance["score"]
        rivals = ["slerp_score", *(["plain_score"] if scheme == "geodesic-spline" else [])]  # geodesics are no splines
        assert found[key] <= EXACT * min(metric.provenance[rival] for rival in rivals)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["loc", "rot", "hyb"])
@pytest.mark.parametrize("seed", range(2))
def test_families_of_a_made_up_motion(seed, kind):
    check_order(scores(wandering(seed), KEYS, kind=kind))


@needs_shared
@pytest.mark.slow
@pytest.mark.parametrize("clip", CLIPS)
def test_families_of_a_real_clip(clip):
    animation = real(clip)
    check_order(scores(animation, uniform_keyframes(animation.n_frames, 0.1)))


@pytest.mark.parametrize("kind", ["rot", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("loc", "hyb"))])
def test_diagonal_families(kind):
    animation = wandering(3)
    found = {
        (scheme, side): learn_metric(animation, KEYS, scheme=scheme, invariance=side, kind=kind).provenance["score"]
        for scheme, side in product(LEARNABLE, INVARIANCE_CHOICES)
    }
    for side in INVARIANCE_CHOICES:
        assert found["geodesic-spline", side] <= EXACT * found["geodesic", side]
    for scheme, (larger, smaller) in product(LEARNABLE, LARGER_SIDES):
        assert found[scheme, larger] <= EXACT * found[scheme, smaller]


def test_what_is_contained_wins_where_the_search_itself_finds_nothing_better(monkeypatch):
    """The optimum of a contained family is a candidate whatever becomes of the search."""
    objective = Objective(wandering(), KEYS)
    families = Families(objective, N_JOINTS, Tally(lambda evaluations, value: None))
    contained = [families.best("geodesic", "diagonal", side) for side in ("left", "right")]
    plain = families._plain("geodesic", "left")
    monkeypatch.setattr(Families, "_search", lambda *arguments: plain._replace(quality=np.inf))
    best = families.best("geodesic", "spd", "joint")
    assert best.quality == min(one.quality for one in contained)


def test_the_quality_is_the_value_without_smoothing():
    objective = Objective(wandering(), KEYS, "rot")
    curve = CurveParameters.plain("geodesic-spline", N_JOINTS)
    difference = objective.quality(curve) - objective.value(curve)
    assert 0.0 < difference < 1e-5 * N_JOINTS
    by_hand = learn_metric(wandering(), KEYS, kind="rot").provenance["plain_score"]
    assert objective.quality(curve) == pytest.approx(by_hand, rel=1e-12)


def test_a_search_reports_what_it_returns():
    found = search_gradient(Objective(wandering(), KEYS), N_JOINTS, "diagonal", "joint", "geodesic-spline")
    assert found.value == Objective(wandering(), KEYS).value(found.curve)
