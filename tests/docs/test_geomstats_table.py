"""The tables of docs/geomstats.rst list everything that Geomstats has, and say the truth about each row."""

import importlib
import inspect
import pkgutil
import re

import geomstats.learning
import numpy as np
import pytest
from commands import ROOT
from geomstats.geometry.lie_group import MatrixLieGroup
from geomstats.geometry.manifold import Manifold
from geomstats.geometry.riemannian_metric import RiemannianMetric
from geomstats_cases import (
    ESTIMATORS,
    HERE,
    METHODS,
    MODELS,
    SPACE_METHODS,
    estimator_method,
    problem,
    rotations_problem,
)
from sklearn.base import BaseEstimator

PAGE = (ROOT / "docs" / "geomstats.rst").read_text("utf-8")
ROWS = {name.strip("`"): word for name, word in re.findall(r"^ {3}(\S.*?) \| (works|here|no) \|", PAGE, re.MULTILINE)}
ELSEWHERE = {"GaussianMixtureModel", "HyperbolicPlaneExactPGA", "KalmanFilter", "Localization", "LocalizationLinear"}
"""Of one estimator that is in the table, or of models that are not of poses."""

PARTS = re.compile(r"Template|GradientDescent|Regressor|^PCA$|LinearRegression|(Linear|Elastic|Circle)Mean")
"""Of estimators that are in the table, or what FrechetMean makes of other spaces."""


NOT_OF_POSES = {"RiemannianEM", "ExactPGA", "AAC"}
PLUMBING = re.compile(r"^(set|get)(_|$)")
"""Methods of scikit-learn's that have nothing to do with points."""

ON = {"poses": problem, "rotations": rotations_problem}
on = pytest.mark.parametrize("where", ON)


def estimators():
    """Return the public classes of `geomstats.learning` by name."""
    found = {}
    for module in pkgutil.iter_modules(geomstats.learning.__path__):
        module = importlib.import_module(f"geomstats.learning.{module.name}")
        classes = inspect.getmembers(module, inspect.isclass)
        found |= {name: value for name, value in classes if value.__module__ == module.__name__ and name[0] != "_"}
    return {name: value for name, value in found.items() if not PARTS.search(name) and name not in ELSEWHERE}


def estimator_methods():
    """Return the public methods of the estimators that are of poses, as "class.method"."""
    return sorted(
        f"{name}.{method}"
        for name, value in estimators().items()
        for method in set(dir(value)) - set(dir(BaseEstimator))
        if name not in NOT_OF_POSES
        and method[0] != "_"
        and not PLUMBING.match(method)
        and callable(getattr(value, method))
    )


def public(*classes):
    """Return the public names that classes and their bases define."""
    return {name for value in classes for base in value.__mro__ for name in vars(base) if name[0] != "_"}


def test_every_estimator_has_a_row():
    assert {name.partition(",")[0] for name in ESTIMATORS} == set(estimators())
    assert set(ESTIMATORS) <= set(ROWS)
    assert set(MODELS) == set(estimators()) - NOT_OF_POSES
    assert set(estimator_methods()) <= set(ROWS)


def test_every_method_has_a_row():
    assert set(METHODS) == public(RiemannianMetric)
    assert set(SPACE_METHODS) == {
        name for name in public(Manifold, MatrixLieGroup) if not name.startswith("equip_with")
    }
    assert set(METHODS) | {f"space.{name}" for name in SPACE_METHODS} <= set(ROWS)


def refuses(run, *arguments):
    try:
        run(*arguments)
    except Exception:
        return True
    return False


def check(word, run, *arguments):
    if word == "no":
        assert refuses(run, *arguments)
        return
    values = np.asarray(run(*arguments))
    assert values.size and (values.dtype == object or np.isfinite(values).all())


@on
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name == "GeodesicRegression" else name for name in ESTIMATORS],
)
def test_an_estimator_is_as_its_row_says(name, where):
    assert (name in HERE) == (ROWS[name] == "here")
    check(ROWS[name], ESTIMATORS[name], ON[where](), HERE.get(name))


@on
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", estimator_methods())
def test_a_method_of_an_estimator_is_as_its_row_says(name, where):
    estimator, _, method = name.partition(".")
    check(ROWS[name], estimator_method(estimator, method), ON[where](), HERE.get(estimator))


@on
@pytest.mark.parametrize("name", METHODS)
def test_a_method_is_as_its_row_says(name, where):
    if (name, where) != ("geodesic_equation", "rotations"):  # a pair of matrices passes for a point there
        check(ROWS[name], METHODS[name], ON[where]())


@on
@pytest.mark.parametrize("name", SPACE_METHODS)
def test_a_method_of_the_group_is_as_its_row_says(name, where):
    check(ROWS[f"space.{name}"], SPACE_METHODS[name], ON[where]())


def test_neighbors_are_the_nearest_by_the_metric():
    poses = problem()
    distances = np.asarray(poses.space.metric.dist_pairwise(poses.points))
    nearest = HERE["KNearestNeighborsClassifier"](poses.space, n_neighbors=3).fit(poses.points, poses.labels)
    found, index = nearest.kneighbors(poses.points)
    np.testing.assert_allclose(found, np.sort(distances, axis=1)[:, :3], atol=1e-7)
    np.testing.assert_array_equal(index, np.argsort(distances, axis=1)[:, :3])
    np.testing.assert_array_equal(nearest.kneighbors_graph(poses.points).toarray().sum(axis=1), 3)
    dense = HERE["KernelDensityEstimationClassifier"](poses.space, radius=0.4).fit(poses.points, poses.labels)
    inside = [set(row) for row in dense.radius_neighbors(poses.points, return_distance=False)]
    assert inside == [set(np.flatnonzero(row <= 0.4)) for row in distances]
    np.testing.assert_array_equal(dense.radius_neighbors_graph(poses.points).toarray(), distances <= 0.4)
