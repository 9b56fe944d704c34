import builtins
import time

import numpy as np
import pytest
from swings import N_JOINTS, objective_of, swinging

from geomstats_anim import Animation, MetricParameters, uniform_keyframes
from geomstats_anim.learning.clips import Corpus
from geomstats_anim.learning.gradient import search_gradient
from geomstats_anim.learning.objective import Objective
from geomstats_anim.learning.tune import ray_runtime
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.learning.tune.tpe import Convergence, Space, search_tpe, search_tpe_joint
from geomstats_anim.parameters import CurveParameters


def slerp_value(objective):
    return objective.value(CurveParameters.plain("geodesic", N_JOINTS))


@pytest.fixture(scope="module")
def ray_instance():
    with ray_runtime.running(cpus=2) as workers:
        yield workers


@pytest.mark.parametrize("kind", ["loc", "rot", "hyb"])
def test_parts_of_joints_add_up_to_the_quality(kind):
    objective = objective_of(kind=kind)
    parameters = CurveParameters.geodesic(
        MetricParameters([2.0, 0.5, 3.0], [0.3, 1.0, 2.0], None, ("left", "right", "right"))
    )
    rotation, part = objective.errors_by_joint(parameters)
    assert part.sum() == pytest.approx(objective.value(parameters), rel=1e-12)
    assert rotation == pytest.approx(objective.rotation_errors_by_joint(parameters), rel=1e-6)


@pytest.mark.parametrize(("family", "invariance"), [("diagonal", "joint"), ("diagonal", "clip"), ("spd", "left")])
def test_space_begins_at_the_identity(family, invariance):
    space = Space(range(2), family, invariance)
    assert set(space.expression()) == set(space.identity)
    parameters = space.parameters(space.identity).metric
    assert (parameters.matrices == np.eye(3)).all()
    assert parameters.invariance == ("left", "left")


def test_convergence_is_a_window_without_improvement():
    convergence = Convergence(3, 0.1)
    assert [convergence.reached(value) for value in (1.0, 0.95, 0.8, 0.79, 0.9, 0.75)] == [False] * 5 + [True]
    never = Convergence(0, 0.1)
    assert not any(never.reached(1.0) for _ in range(100))


@pytest.mark.parametrize("kind", ["rot", "hyb"])
def test_joint_by_joint_comes_near_the_gradient(kind):
    objective = objective_of(kind=kind)
    settings = TuneSettings(trials=60)
    found = search_tpe(objective, N_JOINTS, seed=1, settings=settings)
    best = search_gradient(objective, N_JOINTS).value
    assert found.value == objective.value(found.curve)
    assert found.value - best < 0.25 * (slerp_value(objective) - best)


def test_joint_by_joint_repeats():
    one, other = (search_tpe(objective_of(), N_JOINTS, seed=1, settings=TuneSettings(trials=5)) for _ in range(2))
    assert (one.curve.metric.alpha == other.curve.metric.alpha).all()


@pytest.mark.parametrize(("family", "invariance"), [("spd", "joint"), ("diagonal", "clip"), ("diagonal", "right")])
def test_joint_by_joint_is_never_worse_than_slerp(family, invariance):
    objective = objective_of()
    seen = []
    found = search_tpe(
        objective, N_JOINTS, family, invariance, "geodesic", 0, TuneSettings(trials=3), lambda *now: seen.append(now)
    )
    assert found.value <= slerp_value(objective)
    assert [count for count, _ in seen[:3]] == [1, 2, 3]
    if invariance != "joint":
        assert len(set(found.curve.metric.invariance)) == 1


def test_a_still_animation_stops_early():
    moving = swinging()
    still = Animation(moving.skeleton, moving.times, np.repeat(moving.rotations[:1], 33, 0), moving.translations)
    found = search_tpe(Objective(still, uniform_keyframes(33, 0.2)), N_JOINTS, settings=TuneSettings(window=5))
    assert found.value == pytest.approx(0.0, abs=1e-9)
    assert found.evaluations < 100


@pytest.mark.parametrize("search", [search_tpe, search_tpe_joint])
def test_words_are_checked(search):
    with pytest.raises(ValueError, match="There is no family 'odd'"):
        search(objective_of(), N_JOINTS, "odd")
    with pytest.raises(ValueError, match="There is no invariance 'odd'"):
        search(objective_of(), N_JOINTS, "spd", "odd")


@pytest.mark.parametrize("wrong", [{"trials": 0}, {"window": -1}, {"threshold": float("nan")}, {"resume": True}])
def test_settings_are_checked(wrong):
    with pytest.raises(ValueError):
        TuneSettings(**wrong)


@pytest.mark.parametrize("search", [search_tpe, search_tpe_joint])
def test_missing_packages_name_the_extra(search, monkeypatch):
    def fail(module, *rest):
        if module == "hyperopt":
            raise ModuleNotFoundError("No module named 'hyperopt'", name="hyperopt")
        return builtins.__import__(module)

    monkeypatch.setattr(ray_runtime.importlib, "import_module", fail)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'geomstats-anim\[tune\]'"):
        search(objective_of(), N_JOINTS)


@pytest.mark.parametrize(
    ("address", "message"),
    [("127.0.0.1:1", "There is no Ray cluster at 127.0.0.1:1"), ("nowhere", "The address of a Ray cluster is")],
)
def test_no_cluster_is_told_at_once(address, message):
    begin = time.monotonic()
    with pytest.raises(ConnectionError, match=message):
        with ray_runtime.running(address):
            pass
    assert time.monotonic() - begin < 20.0


@pytest.mark.slow
def test_all_joints_at_once(ray_instance, tmp_path, capfd):
    objective = objective_of()
    settings = TuneSettings(trials=12, cpus=1, folder=tmp_path / "results")
    seen = []
    found = search_tpe_joint(objective, N_JOINTS, seed=3, settings=settings, progress=lambda *now: seen.append(now))
    assert capfd.readouterr() == ("", "")
    assert seen[0] == (1, pytest.approx(slerp_value(objective), rel=1e-12))
    assert seen[-1] == (12, found.value)
    assert found.evaluations == 12
    assert found.value == pytest.approx(objective.value(found.curve), rel=1e-12)
    again = search_tpe_joint(objective, N_JOINTS, seed=3, settings=TuneSettings(trials=12, cpus=1))
    assert (again.curve.metric.alpha == found.curve.metric.alpha).all()
    assert again.value == found.value
    with pytest.raises(ValueError, match="resume it, or name another folder"):
        search_tpe_joint(objective, N_JOINTS, settings=settings)
    with pytest.raises(ValueError, match="other joints, another family, invariance or seed"):
        search_tpe_joint(objective, N_JOINTS, seed=4, settings=TuneSettings(folder=tmp_path / "results", resume=True))
    with pytest.raises(ValueError, match="no search to resume"):
        search_tpe_joint(objective, N_JOINTS, settings=TuneSettings(folder=tmp_path / "empty", resume=True))


@pytest.mark.slow
def test_all_joints_at_once_stop_when_converged(ray_instance):
    settings = TuneSettings(trials=50, cpus=2, window=4, threshold=0.99)
    found = search_tpe_joint(Corpus([objective_of(), objective_of(1)]), N_JOINTS, invariance="clip", settings=settings)
    assert 5 <= found.evaluations < 10


@pytest.mark.slow
def test_a_failing_objective_ends_the_search(ray_instance):
    class Failing(Objective):
        def value(self, parameters):
            raise ArithmeticError("no such luck")

    objective = Failing(swinging(), np.arange(0, 33, 8))
    with pytest.raises(RuntimeError, match="A trial of the search failed twice.*no such luck"):
        search_tpe_joint(objective, N_JOINTS, settings=TuneSettings(trials=50, cpus=1))
