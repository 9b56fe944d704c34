"""Whole runs in processes of their own: killed and resumed, logged, read by other tools."""

import json
import math
import os
import pickle
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from swings import N_JOINTS, objective_of

from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.learning.tune.tpe import search_tpe_joint

pytestmark = pytest.mark.slow

HERE = Path(__file__).parents[1]

RUN = """
import signal, sys
from swings import N_JOINTS, objective_of
from geomstats_anim.learning.tune.settings import TuneSettings
from geomstats_anim.learning.tune.tpe import search_tpe_joint

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have started us with Ctrl+C ignored
settings = TuneSettings(trials=int(sys.argv[2]), folder=sys.argv[1], resume=len(sys.argv) > 3)
tell = lambda trials, quality: print(trials, flush=True)
found = search_tpe_joint(objective_of(), N_JOINTS, seed=5, settings=settings, progress=tell)
print(found.evaluations, repr(found.value), found.curve.metric.alpha.tolist())
"""


def start(*arguments):
    path = os.pathsep.join([str(HERE), str(HERE.parents[2])])
    return subprocess.Popen(
        [sys.executable, "-c", RUN, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def journal(folder):
    return [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()[1:]]


@pytest.mark.parametrize("seconds", [0, 15])
def test_a_killed_run_goes_on(tmp_path, seconds):
    """Killed before Tune has saved anything, and after."""
    whole, _ = start(tmp_path / "whole", 60 + 4 * seconds).communicate()
    run = start(tmp_path / "cut", 60 + 4 * seconds)
    begin, done = time.monotonic(), 0
    while done < 25 or time.monotonic() - begin < seconds:
        done = int(run.stdout.readline())
    run.send_signal(signal.SIGKILL)
    run.communicate()
    before = journal(tmp_path / "cut")
    assert done <= len(before) <= done + 5
    resumed, errors = start(tmp_path / "cut", 60 + 4 * seconds, "resume").communicate()
    assert errors == ""
    # what was done is done, and nothing else is lost: the search ends as if it had never been killed
    assert journal(tmp_path / "cut")[: len(before)] == before
    assert int(resumed.splitlines()[0]) == len(before) + 1
    assert resumed.splitlines()[-1] == whole.splitlines()[-1]


def test_an_interrupted_run_is_not_taken_for_a_finished_one(tmp_path):
    run = start(tmp_path, 100)
    while int(run.stdout.readline()) < 5:
        pass
    run.send_signal(signal.SIGINT)
    rest, errors = run.communicate()
    assert errors.endswith("KeyboardInterrupt\n")
    assert all(line.isdigit() for line in rest.splitlines())  # progress, and no result
    before = journal(tmp_path)
    resumed, errors = start(tmp_path, 100, "resume").communicate()
    assert errors == ""
    assert int(resumed.splitlines()[0]) == len(before) + 1
    assert len(journal(tmp_path)) == 100


def test_other_tools_read_the_results(tmp_path, monkeypatch):
    from ray.tune import ExperimentAnalysis
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    monkeypatch.setenv("WANDB_MODE", "offline")
    monkeypatch.setenv("WANDB_DIR", str(tmp_path))
    folder = tmp_path / "results"
    settings = TuneSettings(trials=4, folder=folder, wandb="geomstats-anim")
    found = search_tpe_joint(objective_of(), N_JOINTS, settings=settings)
    analysis = ExperimentAnalysis(str(folder), default_metric="quality", default_mode="min")
    assert len(analysis.trials) == 4
    assert analysis.best_result["quality"] == found.value
    assert analysis.best_config["log_alpha_0"] == pytest.approx(math.log(found.curve.metric.alpha[0]), abs=1e-12)
    qualities = []
    for events in folder.glob("*/events.out.tfevents.*"):
        accumulator = EventAccumulator(str(events.parent)).Reload()
        qualities += [event.value for event in accumulator.Scalars("ray/tune/quality")]
    assert len(qualities) == 4
    assert min(qualities) == pytest.approx(found.value, rel=1e-6)
    assert len(list(tmp_path.rglob("*.wandb"))) == 4


class _Bomb:
    """Makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def test_a_resumed_run_unpickles_nothing_of_its_folder(tmp_path):
    folder, harm = tmp_path / "results", tmp_path / "harm"
    search_tpe_joint(objective_of(), N_JOINTS, settings=TuneSettings(trials=4, folder=folder))
    pickled = pickle.dumps(_Bomb(harm))
    states = [path for path in folder.rglob("*") if path.suffix in (".pkl", ".pickle") or "state" in path.name]
    assert states
    for path in states:
        text = path.read_bytes()
        if text.startswith(b"{"):  # in which Tune keeps pickles as hexadecimal digits
            path.write_bytes(text.replace(b"8004", pickled.hex().encode()))
        else:
            path.write_bytes(pickled)
    found = search_tpe_joint(objective_of(), N_JOINTS, settings=TuneSettings(trials=6, folder=folder, resume=True))
    assert found.evaluations == 6 and len(journal(folder)) == 6
    assert not harm.exists()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("{", "is not the journal of a search: This is not JSON: "),
        ("[" * 100_000, "is not the journal of a search: This JSON is nested more than 32 levels deep."),
        ('{"point": {}, "quality": NaN}', "is not the journal of a search: This JSON has the value NaN"),
        ('{"point": {}}', "is not the journal of a search: 'quality'"),
        ("3", "is not the journal of a search: "),
        ('{"point": {}, "quality": 0.1}', "has a trial that this search cannot make; begin the search anew."),
        ('{"point": {"log_alpha_0": 0.0}, "quality": 0.1}', "has a trial that this search cannot make"),
    ],
)
def test_journals_of_strangers(tmp_path, line, words):
    folder = tmp_path / "results"
    search_tpe_joint(objective_of(), N_JOINTS, settings=TuneSettings(trials=2, folder=folder))
    with (folder / "trials.jsonl").open("a") as file:
        file.write(line + "\n")
    with pytest.raises(ValueError, match=re.escape(words)):
        search_tpe_joint(objective_of(), N_JOINTS, settings=TuneSettings(trials=3, folder=folder, resume=True))
