import subprocess
import sys

import pytest

import geomstats_anim
from geomstats_anim import names
from geomstats_anim.criteria import kind_shares
from geomstats_anim.interpolation.schemes import SCHEMES, Geodesic


def _modules_after(code: str) -> set[str]:
    printed = subprocess.check_output([sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules)"], text=True)
    return set(printed.split())


def test_the_words_for_schemes_are_the_schemes():
    assert tuple(SCHEMES) == names.SCHEME_NAMES
    assert tuple(name for name, curve in SCHEMES.items() if issubclass(curve, Geodesic)) == names.WITH_METRIC
    assert names.DEFAULT_SCHEME in names.WITH_METRIC


@pytest.mark.parametrize("kind", names.KINDS)
def test_every_word_for_a_kind_of_quality_is_one(kind):
    assert sum(kind_shares(kind)) == 1.0


@pytest.mark.parametrize("code", ["import geomstats_anim", "from geomstats_anim import names, __version__"])
def test_the_package_and_its_words_need_nothing(code):
    assert not _modules_after(code) & {"numpy", "scipy", "numba", "geomstats"}


def test_a_clip_and_a_metric_are_made_and_compared_without_compiled_code():
    code = """
from geomstats_anim import Animation, LearnedMetric, MetricParameters, Skeleton, rotations
skeleton = Skeleton(["arm"], [-1], [[0, 0, 0]], [[0, 0, 0, 1]])
turn = Animation(skeleton, [0, 1], [[[0, 0, 0, 1]], [[1, 0, 0, 0]]], [[[0, 0, 0]], [[0, 0, 1]]])
assert abs(rotations.distance(turn.rotations[1:], turn.rotations[:-1]).item() - 3.14159265) < 1e-8
metric = LearnedMetric(["arm"], MetricParameters(2.0, 0.5))
assert LearnedMetric.from_json(metric.to_json()).parameters.alpha == 2.0
"""
    assert not _modules_after(code) & {"scipy", "numba", "geomstats"}


@pytest.mark.parametrize("name", geomstats_anim.__all__)
def test_every_public_name_is_listed_and_imported_on_first_use(name):
    assert name in dir(geomstats_anim)
    assert getattr(geomstats_anim, name) is not None


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="nonsense"):
        geomstats_anim.nonsense  # noqa: B018
