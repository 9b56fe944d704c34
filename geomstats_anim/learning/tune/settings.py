"""Settings of the TPE searches, importable without Ray, HyperOpt and compiled code."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

WINDOW, JOINT_WINDOW = 250, 40
"""Trials without improvement that end the search over all joints at once, and that of a joint."""


@dataclass(frozen=True)
class TuneSettings:
    """Settings of a TPE search.

    Parameters
    ----------
    trials : int
        Most evaluations: of the objective for "tpe-joint", of each joint for "tpe".
        Optional, default: None, 1000 for "tpe-joint" and 100 for "tpe".
    window : int
        Stop when the last so many trials have brought no improvement; 0 never does.
        Optional, default: None, 250 for "tpe-joint" and 40 for "tpe".
    threshold : float
        Least improvement that counts, as a share of the value.
        Optional, default: 1e-3.
    folder : Path
        Where "tpe-joint" leaves its results, for TensorBoard and `ray.tune.ExperimentAnalysis`.
        Optional, default: None, a temporary folder that is removed.
    resume : bool
        Go on with the run in `folder` that was interrupted.
        Optional, default: False.
    address : str
        Of a Ray cluster; see `ray_runtime.running`.
        Optional, default: None, a local instance.
    cpus : int
        Workers of Ray.
        Optional, default: None; 1 on a local instance, so that the same seed gives the same result.
    wandb : str
        Project of Weights & Biases to log to; needs the extra `wandb`.
        Optional, default: None.
    """

    trials: int | None = None
    window: int | None = None
    threshold: float = 1e-3
    folder: Path | None = None
    resume: bool = False
    address: str | None = None
    cpus: int | None = None
    wandb: str | None = None

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.trials is not None and self.trials < 1:
            raise ValueError(f"There must be at least one trial, but trials is {self.trials}.")
        if self.window is not None and self.window < 0:
            raise ValueError(f"window must be at least 0, but it is {self.window}.")
        if not self.threshold >= 0.0:
            raise ValueError(f"threshold must be at least 0, but it is {self.threshold}.")
        if self.resume and self.folder is None:
            raise ValueError("To resume a search, name its folder.")
