"""All trials of a comparison, one after the other or spread by Ray."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from geomstats_anim.learning.tune import ray_runtime
from usd_tools.comparison.trials import ScoringLibrary, Trial, TrialResult, failed, measure
from usd_tools.console.errors import ToolError
from usd_tools.learning.clips import TrainingClip

Done = Callable[[TrialResult], None]


def measure_all(
    trials: Sequence[Trial],
    takes: Mapping[str, TrainingClip],
    kind: str,
    libraries: Mapping[str, ScoringLibrary],
    address: str | None = None,
    cpus: int | None = None,
    done: Done = lambda result: None,
) -> list[TrialResult]:
    """Measure trials.

    Parameters
    ----------
    trials : sequence of Trial
    takes : mapping of str to TrainingClip
        By the names of clips.
    kind : str
        Quality that learning minimises.
    libraries : mapping of str to ScoringLibrary
        For the scheme "learned", by the names of clips.
    address : str
        Of a Ray cluster.
        Optional, default: the environment variable RAY_ADDRESS, else none.
    cpus : int
        Workers; Ray is started for more than one.
        Optional, default: 1.
    done : callable
        Told of each result as it comes.

    Returns
    -------
    results : list of TrialResult
        In the order of the trials, and the same however many workers there are.

    Raises
    ------
    ToolError
        If Ray is asked for, but is not installed or cannot be joined.
    """
    if not ray_runtime.is_wanted(address, cpus):
        results = []
        for trial in trials:
            results.append(measure(trial, takes[trial.clip], kind, libraries.get(trial.clip)))
            done(results[-1])
        return results
    try:
        with ray_runtime.running(address, cpus):
            return _spread(trials, takes, kind, libraries, done)
    except (ModuleNotFoundError, ConnectionError) as error:
        raise ToolError(str(error)) from error


def _spread(
    trials: Sequence[Trial],
    takes: Mapping[str, TrainingClip],
    kind: str,
    libraries: Mapping[str, ScoringLibrary],
    done: Done,
) -> list[TrialResult]:
    ray = ray_runtime.require("ray")
    task = ray.remote(measure)
    motion = {name: ray.put(take) for name, take in takes.items()}
    scoring = {name: ray.put(library) for name, library in libraries.items()}
    waiting = {task.remote(trial, motion[trial.clip], kind, scoring.get(trial.clip)): trial for trial in trials}
    results: dict[Trial, TrialResult] = {}
    while waiting:
        (ready,), _ = ray.wait(list(waiting))
        trial = waiting.pop(ready)
        try:
            results[trial] = ray.get(ready)
        except ray.exceptions.RayError as error:  # a worker has died
            results[trial] = failed(trial, error)
        done(results[trial])
    return [results[trial] for trial in trials]
