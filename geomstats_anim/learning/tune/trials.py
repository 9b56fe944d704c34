"""One TPE search over all parameters as an experiment of Ray Tune; import this only where Ray and HyperOpt are needed.

A finished trial goes to a journal in the results folder at once. A run that is resumed is a new experiment, which takes
the trials of the journal without evaluating them again: only those in flight are lost. Tune's own saved state is never
read, for it is pickled, and a folder from a stranger must not run code.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from ray import tune
from ray.tune.search import ConcurrencyLimiter
from ray.tune.search.hyperopt import HyperOptSearch

from geomstats_anim.learning.learnable import Learnable
from geomstats_anim.learning.tune.journal import JOURNAL, METRIC, Journal, point_key
from geomstats_anim.learning.tune.loggers import file_loggers, wandb_logger
from geomstats_anim.learning.tune.ray_runtime import running
from geomstats_anim.learning.tune.settings import WINDOW, TuneSettings
from geomstats_anim.learning.tune.tpe import STARTUP, Convergence, Point, Space, as_document, point_of
from geomstats_anim.names import TRIALS

MODE = "min"

_followers: dict[Path, Callable[[int, float], None]] = {}
"""Listeners to the progress of the journals; Tune pickles its callbacks, and a resumed run has a new follower."""

_interrupted = threading.Event()
"""Set by Ctrl+C."""


def run(
    objective: Learnable,
    space: Space,
    seed: int,
    settings: TuneSettings,
    progress: Callable[[int, float], None],
) -> tuple[Point, float, int]:
    """Run an experiment, or go on with one.

    Parameters
    ----------
    objective : Learnable
    space : Space
    seed : int
    settings : TuneSettings
    progress : callable

    Returns
    -------
    best : dict
        Point of the space.
    value : float
    trials : int
    """
    keep = settings.folder is not None
    with nullcontext(settings.folder) if keep else tempfile.TemporaryDirectory(prefix="geomstats_anim-") as name:
        journal = Journal(Path(str(name)).absolute() / JOURNAL)
        journal.begin(space, seed, settings.resume)
        _followers[journal.path] = progress
        try:
            with running(settings.address, settings.cpus) as workers, _quiet(), _interruptible():
                results = _tuner(objective, space, seed, settings, journal, workers).fit()
        finally:
            del _followers[journal.path]
        journal.read()
        if results.errors:
            reason = str(results.errors[0]).strip().splitlines()[-1]
            raise RuntimeError(f"A trial of the search failed twice, on the workers of Ray: {reason}")
    best = min(journal.values, key=journal.values.__getitem__)
    return json.loads(best), journal.values[best], len(journal.values)


def _tuner(
    objective: Learnable, space: Space, seed: int, settings: TuneSettings, journal: Journal, workers: int
) -> tune.Tuner:
    folder = journal.path.parent
    # one copy in the object store serves all trials
    trainable = tune.with_parameters(_evaluate, objective=objective, space=space, known=dict(journal.values))
    trainable = tune.with_resources(trainable, {"cpu": 1})
    recorder = _Recorder(journal, settings)
    callbacks = [recorder, *file_loggers()]
    if settings.wandb:
        callbacks.append(wandb_logger(settings.wandb))
    return tune.Tuner(
        trainable,
        tune_config=tune.TuneConfig(
            search_alg=ConcurrencyLimiter(_JournalledSearch(space, seed, journal), max_concurrent=workers),
            num_samples=settings.trials or TRIALS,
            reuse_actors=True,  # a process for each trial would take longer than the trial
            trial_dirname_creator=_trial_id,
        ),
        run_config=tune.RunConfig(
            name=folder.name,
            storage_path=str(folder.parent),
            stop=recorder,
            callbacks=callbacks,
            failure_config=tune.FailureConfig(max_failures=1),
            verbose=0,
        ),
    )


def _evaluate(config: Point, objective: Learnable, space: Space, known: Mapping[str, float]) -> None:
    value = known.get(point_key(config))
    tune.report({METRIC: objective.value(space.parameters(config)) if value is None else value})


def _trial_id(trial: Any) -> str:
    return str(trial.trial_id)


class _Interruption(Exception):
    """Ctrl+C, as an error that Tune cleans up after; it does not after KeyboardInterrupt."""


class _Recorder(tune.Callback, tune.Stopper):
    """Enters finished trials into the journal, and ends the search once it has converged."""

    def __init__(self, journal: Journal, settings: TuneSettings) -> None:
        self._journal, self._settings = journal, settings
        self._convergence = Convergence(WINDOW if settings.window is None else settings.window, settings.threshold)
        self._stop = any([self._convergence.reached(value) for value in journal.values.values()])

    def on_trial_complete(self, iteration: int, trials: list[Any], trial: Any, **info: Any) -> None:
        value = trial.last_result.get(METRIC)
        if value is None or not self._journal.add(trial.config, value):
            return
        self._stop |= self._convergence.reached(value)
        follower = _followers.get(self._journal.path)
        if follower:
            follower(len(self._journal.values), min(self._journal.values.values()))

    def on_step_end(self, iteration: int, trials: list[Any], **info: Any) -> None:
        if _interrupted.is_set():
            raise _Interruption  # Tune closes all logs then, and its state stays that of a search to be resumed

    def on_trial_error(self, iteration: int, trials: list[Any], trial: Any, **info: Any) -> None:
        self._stop = True  # others would fail too

    def __call__(self, trial_id: str, result: dict[str, Any]) -> bool:
        return False  # a trial ends by itself

    def stop_all(self) -> bool:
        return self._stop

    def __reduce__(self) -> tuple[Any, ...]:
        """Begin anew from the journal."""
        return _Recorder, (self._journal, self._settings)


class _JournalledSearch(HyperOptSearch):
    """HyperOpt, which is first told what the journal knows and it does not; identity comes before everything."""

    def __init__(self, space: Space, seed: int, journal: Journal) -> None:
        super().__init__(
            space.expression(),
            metric=METRIC,
            mode=MODE,
            points_to_evaluate=[space.identity],
            n_initial_points=STARTUP,
            random_state_seed=seed,
        )
        self._journal = journal
        self._forgotten: list[Point] | None = None

    def suggest(self, trial_id: str) -> dict[str, Any] | None:
        if self._forgotten is None:
            known = {point_key(point_of(document)) for document in self._hpopt_trials.trials}
            self._forgotten = [json.loads(key) for key in self._journal.values if key not in known]
        if self._points_to_evaluate or not self._forgotten:
            return super().suggest(trial_id)
        point = self._forgotten.pop(0)
        self.rstate.randint(2**31 - 1)  # as if suggested, so that the search goes on as it would have
        document = as_document(point, self._hpopt_trials, self.domain)
        self._hpopt_trials.insert_trial_docs([document])
        self._hpopt_trials.refresh()
        self._live_trial_mapping[trial_id] = (document["tid"], document)
        return point


@contextmanager
def _interruptible() -> Iterator[None]:
    """Let Ctrl+C end a search in an orderly way; pressed again, it interrupts at once."""
    usual = signal.default_int_handler
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) is not usual:
        yield
        return

    def stop(number: int, frame: Any) -> None:
        _interrupted.set()
        signal.signal(signal.SIGINT, usual)

    _interrupted.clear()
    signal.signal(signal.SIGINT, stop)
    try:
        yield
    except _Interruption:
        raise KeyboardInterrupt from None
    finally:
        signal.signal(signal.SIGINT, usual)
        _interrupted.clear()


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Tune from printing, since what we print ourselves says enough, and from taking Ctrl+C for the end."""
    # Tune would hand over what it has as if that were all, and never give the signal back: see `_interruptible`.
    wanted = {"RAY_AIR_NEW_OUTPUT": "0", "TUNE_DISABLE_SIGINT_HANDLER": "1"}
    before, logger = {name: os.environ.get(name) for name in wanted}, logging.getLogger("ray")
    os.environ.update(wanted)
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
