"""Imports that are made before they are needed."""

import subprocess
import sys

import pytest

KEYS = """
import sys
import numpy as np
from geomstats_anim import Animation, Skeleton, interpolate
keys = Animation(
    Skeleton(["arm"], [-1], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0, 1.0]]),
    [0.0, 1.0, 3.0],
    [[[0, 0, 0, 1]], [[0.6, 0, 0, 0.8]], [[0, 0.6, 0, 0.8]]],
    np.arange(9.0).reshape(3, 1, 3),
)
"""


def loaded(code):
    return subprocess.check_output([sys.executable, "-c", code + "print(*sys.modules)"], text=True).split()


HEAVY = {"scipy.interpolate", "scipy.spatial", "scipy.optimize", "scipy.special", "ray", "hyperopt"}


@pytest.mark.parametrize("scheme", ["linear", "slerp", "geodesic", "geodesic-spline"])
def test_schemes_of_our_own_need_no_scipy(scheme):
    modules = loaded(f"{KEYS}interpolate(keys, [0.5, 2.0], {scheme!r})\n")
    assert not HEAVY & set(modules)


@pytest.mark.parametrize("scheme", ["squad", "rotation-spline"])
def test_the_peers_import_it_when_they_are_used(scheme):
    assert "scipy.interpolate" in loaded(f"{KEYS}interpolate(keys, [0.5, 2.0], {scheme!r})\n")


@pytest.mark.parametrize("module", ["parameters", "learned_metric", "learning.learn", "learning.clips"])
def test_learning_is_read_without_what_searches(module):
    assert not HEAVY & set(loaded(f"import sys\nimport geomstats_anim.{module}\n"))


def test_settings_need_nothing():
    modules = loaded("import sys\nimport geomstats_anim.learning.tune.settings\n")
    assert not (HEAVY | {"numba", "numpy"}) & set(modules)
