"""Loggers of Ray Tune that also end with a search the logs of trials in flight; import this only where Ray is needed.

Tune tells its loggers of a trial that has ended, but not of one that a converged or failed search leaves behind.
"""

from __future__ import annotations

from typing import Any

from ray import tune
from ray.tune.logger import CSVLoggerCallback, JsonLoggerCallback, LoggerCallback, TBXLoggerCallback

from geomstats_anim.learning.tune.ray_runtime import require


def file_loggers() -> list[tune.Callback]:
    """Make those for `ray.tune.ExperimentAnalysis` and TensorBoard; Tune adds its own where it finds none."""
    return [_CsvLogger(), _JsonLogger(), _TensorBoardLogger()]


def wandb_logger(project: str) -> tune.Callback:
    """Make the one for Weights & Biases.

    Raises
    ------
    ModuleNotFoundError
        If it is not installed, in a sentence that names the extra.
    """
    require("wandb", "wandb")
    from ray.air.integrations.wandb import WandbLoggerCallback

    class _WandbLogger(WandbLoggerCallback):
        def on_experiment_end(self, trials: list[Any], **info: Any) -> None:
            for trial in self._trial_queues:  # it would wait half an hour for each to end
                self._signal_logging_actor_stop(trial)
            super().on_experiment_end(trials, **info)

    return _WandbLogger(project=project)


class _Closing(LoggerCallback):
    def on_experiment_end(self, trials: list[Any], **info: Any) -> None:
        super().on_experiment_end(trials, **info)
        for trial in trials:
            self.log_trial_end(trial)


class _CsvLogger(_Closing, CSVLoggerCallback):
    pass


class _JsonLogger(_Closing, JsonLoggerCallback):
    pass


class _TensorBoardLogger(_Closing, TBXLoggerCallback):
    pass
