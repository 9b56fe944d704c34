"""A search that has converged leaves trials in flight, whose logs must end with it."""

import gc
import time
import warnings

import pytest
from swings import N_JOINTS, objective_of

from geomstats_anim.learning.tune import ray_runtime
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.learning.tune.tpe import search_tpe_joint


def search(folder, **settings):
    settings = TuneSettings(trials=50, cpus=2, window=4, threshold=0.99, folder=folder, **settings)
    found = search_tpe_joint(objective_of(), N_JOINTS, settings=settings)
    assert found.evaluations < 10
    # whatever was closed too late, or never, is collected within the test that is to blame
    gc.collect()


@pytest.fixture(scope="module")
def ray_instance():
    with ray_runtime.running(cpus=2) as workers:
        yield workers


@pytest.mark.slow
def test_no_file_stays_open(ray_instance, tmp_path):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResourceWarning)
        search(tmp_path / "results")
        search(tmp_path / "results", resume=True)
    assert [str(warning.message) for warning in caught if warning.category is ResourceWarning] == []


@pytest.mark.slow
def test_weights_and_biases_are_not_waited_for(ray_instance, tmp_path, monkeypatch):
    monkeypatch.setenv("WANDB_MODE", "offline")
    monkeypatch.setenv("WANDB_DIR", str(tmp_path))
    begin = time.monotonic()
    search(tmp_path / "results", wandb="geomstats-anim")
    assert time.monotonic() - begin < 600.0  # it would be half an hour
