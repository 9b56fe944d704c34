"""What Geomstats' own test cases need from pytest.

Its `pytest_make_parametrize_id` is left out: it would rename the parameters of every other test by their `repr`.
"""

from geomstats.test.conf import pytest_collection_modifyitems  # noqa: F401


def pytest_configure(config):
    for mark in ("ignore", "mathprop", "random", "shape", "type", "validation", "vec"):
        config.addinivalue_line("markers", f"{mark}: set by geomstats.test_cases")
