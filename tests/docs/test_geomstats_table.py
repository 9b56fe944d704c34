"""The tables of docs/geomstats.rst list everything that Geomstats has, and say the truth about each row."""

import importlib
import inspect
import pkgutil
import re

import geomstats.learning
import numpy as np
import pytest
from commands import ROOT
from geomstats.geometry.riemannian_metric import RiemannianMetric
from geomstats_cases import ESTIMATORS, HERE, METHODS, problem

PAGE = (ROOT / "docs" / "geomstats.rst").read_text("utf-8")
ROWS = {name.strip("`"): word for name, word in re.findall(r"^ {3}(\S.*?) \| (works|here|no) \|", PAGE, re.MULTILINE)}
ELSEWHERE = {"GaussianMixtureModel", "HyperbolicPlaneExactPGA", "KalmanFilter", "Localization", "LocalizationLinear"}
"""Of one estimator that is in the table, or of models that are not of poses."""

PARTS = re.compile(r"Template|GradientDescent|Regressor|^PCA$|LinearRegression|(Linear|Elastic|Circle)Mean")
"""Of estimators that are in the table, or what FrechetMean makes of other spaces."""


def estimators():
    """Return the names of the public classes of `geomstats.learning`."""
    found = set()
    for module in pkgutil.iter_modules(geomstats.learning.__path__):
        module = importlib.import_module(f"geomstats.learning.{module.name}")
        classes = inspect.getmembers(module, inspect.isclass)
        found |= {name for name, value in classes if value.__module__ == module.__name__ and name[0] != "_"}
    return {name for name in found if not PARTS.search(name)} - ELSEWHERE


def test_every_estimator_has_a_row():
    assert {name.partition(",")[0] for name in ESTIMATORS} == estimators()
    assert set(ESTIMATORS) <= set(ROWS)


def test_every_method_has_a_row():
    public = {name for name, _ in inspect.getmembers(RiemannianMetric, inspect.isfunction) if name[0] != "_"}
    assert set(METHODS) == public
    assert set(METHODS) <= set(ROWS)


def refuses(run, *arguments):
    try:
        run(*arguments)
    except Exception:
        return True
    return False


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name == "GeodesicRegression" else name for name in ESTIMATORS],
)
def test_an_estimator_is_as_its_row_says(name):
    poses = problem()
    assert (name in HERE) == (ROWS[name] == "here")
    if ROWS[name] == "no":
        assert refuses(ESTIMATORS[name], poses, None)
        return
    values = np.asarray(ESTIMATORS[name](poses, HERE.get(name)))
    assert values.size and np.isfinite(values).all()


@pytest.mark.parametrize("name", METHODS)
def test_a_method_is_as_its_row_says(name):
    poses = problem()
    if ROWS[name] == "no":
        assert refuses(METHODS[name], poses)
        return
    values = np.asarray(METHODS[name](poses))
    assert values.size and np.isfinite(values).all()
