import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from swings import N_JOINTS, swinging

from geomstats_anim import MetricParameters
from geomstats_anim.learning.clips import Corpus
from geomstats_anim.learning.gradient import search_gradient
from geomstats_anim.learning.objective import Objective
from geomstats_anim.learning.tune import ray_runtime
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.learning.tune.tpe import search_tpe
from geomstats_anim.parameters import CurveParameters

METRIC = MetricParameters([2.0, 0.5, 3.0], [0.3, 1.0, 2.0], None, ("left", "right", "right"))
PARAMETERS = CurveParameters(METRIC, [0.3, 1.0, 1.7], [1.0, 0.0, 2.0])


def clips():
    lengths = (33, 25, 17, 41, 33)
    for seed, n_frames in enumerate(lengths):
        yield Objective(swinging(seed, n_frames), np.arange(0, n_frames, 8))


def answers(corpus):
    value, gradient = corpus.value_and_gradient(PARAMETERS)
    arrays = [gradient, corpus.rotation_errors_by_joint(PARAMETERS), corpus.errors_by_joint(PARAMETERS)]
    return [value, corpus.value(PARAMETERS), *(array.tolist() for array in arrays)]


def test_it_is_the_mean_over_frames():
    values = [(objective.value(PARAMETERS), objective.animation.n_frames) for objective in clips()]
    mean = sum(value * frames for value, frames in values) / sum(frames for _, frames in values)
    assert Corpus(clips()).value(PARAMETERS) == pytest.approx(mean, rel=1e-12)


def test_frames_that_are_not_scored_do_not_weigh():
    whole, half = clips(), Objective(swinging(), np.arange(0, 33, 8), scored=np.arange(33) < 11)
    corpus = Corpus([next(whole), half])
    assert corpus._shares == pytest.approx([0.75, 0.25])


def test_files_give_the_same_as_memory():
    assert answers(Corpus(clips(), in_memory=2)) == answers(Corpus(clips()))


def test_clips_out_of_a_store_may_be_read_only():
    store = []
    meta = pickle.dumps(next(clips()), protocol=5, buffer_callback=store.append)
    locked = pickle.loads(meta, buffers=[bytes(buffer.raw()) for buffer in store])
    assert answers(Corpus([locked])) == answers(Corpus([next(clips())]))


def test_no_clips():
    with pytest.raises(ValueError, match="at least one clip"):
        Corpus([])


@pytest.mark.slow
def test_joint_by_joint_on_a_corpus():
    corpus = Corpus(clips())
    found = search_tpe(corpus, N_JOINTS, settings=TuneSettings(trials=25))
    assert found.value == corpus.value(found.curve) < corpus.value(CurveParameters.plain("geodesic", N_JOINTS))


@pytest.mark.slow
def test_workers_give_the_same_as_one_process():
    with ray_runtime.running(cpus=2) as workers:
        assert workers == 2
        assert answers(Corpus(clips(), workers)) == answers(Corpus(clips()))


@pytest.mark.slow
def test_two_nodes_give_the_same_as_one_process(monkeypatch):
    import ray
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[3]))
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    try:
        cluster.add_node(num_cpus=1)
        with ray_runtime.running(cluster.address) as workers:
            assert workers == 2
            corpus = Corpus(clips(), workers)
            assert answers(corpus) == answers(Corpus(clips()))
            spread, alone = search_gradient(corpus, N_JOINTS), search_gradient(Corpus(clips()), N_JOINTS)
            assert spread.value == alone.value
            assert (spread.curve.metric.alpha == alone.curve.metric.alpha).all()

            def node(shelf):  # not by reference: the nodes do not know this module
                return ray.get_runtime_context().get_node_id()

            nodes = {ray.get(shelf.__ray_call__.remote(node)) for shelf in corpus._clips.shelves}
            assert len(nodes) == 2
    finally:
        cluster.shutdown()


MEMORY = """
import resource, sys
import numpy as np
from geomstats_anim.learning.clips import Corpus
from geomstats_anim.learning.objective import Objective
from geomstats_anim.parameters import CurveParameters
from swings import swinging

n_clips = int(sys.argv[1])
clips = (Objective(swinging(i, 801, 3), np.arange(0, 801, 8)) for i in range(n_clips))
corpus = Corpus(clips, in_memory=4)
for i in range(3):
    corpus.value_and_gradient(CurveParameters.plain("geodesic", 3))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_the_number_of_clips():
    here = Path(__file__).parent
    path = os.pathsep.join([str(here), str(here.parents[2])])

    def kibibytes(n_clips):
        run = [sys.executable, "-c", MEMORY, str(n_clips)]
        return int(
            subprocess.run(
                run, env={**os.environ, "PYTHONPATH": path}, check=True, capture_output=True, text=True
            ).stdout
        )

    assert kibibytes(60) < kibibytes(6) + 10_000
