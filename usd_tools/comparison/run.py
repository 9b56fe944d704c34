"""All cells of a comparison, one after the other or spread by Ray."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from geomstats_anim.learning.tune import ray_runtime
from usd_tools.comparison.cells import Cell, Outcome, failed, measure
from usd_tools.console.errors import ToolError
from usd_tools.learning.clips import TrainingClip

Done = Callable[[Outcome], None]


def measure_all(
    cells: Sequence[Cell],
    takes: Mapping[str, TrainingClip],
    kind: str,
    address: str | None = None,
    cpus: int | None = None,
    done: Done = lambda outcome: None,
) -> list[Outcome]:
    """Measure cells.

    Parameters
    ----------
    cells : sequence of Cell
    takes : mapping of str to TrainingClip
        By the names of clips.
    kind : str
        Quality that learning minimises.
    address : str
        Of a Ray cluster.
        Optional, default: the environment variable RAY_ADDRESS, else none.
    cpus : int
        Workers; Ray is started for more than one.
        Optional, default: 1.
    done : callable
        Told of each outcome as it comes.

    Returns
    -------
    outcomes : list of Outcome
        In the order of the cells, and the same however many workers there are.

    Raises
    ------
    ToolError
        If Ray is asked for, but is not installed or cannot be joined.
    """
    if not ray_runtime.is_wanted(address, cpus):
        outcomes = []
        for cell in cells:
            outcomes.append(measure(cell, takes[cell.clip], kind))
            done(outcomes[-1])
        return outcomes
    try:
        with ray_runtime.running(address, cpus):
            return _spread(cells, takes, kind, done)
    except (ModuleNotFoundError, ConnectionError) as error:
        raise ToolError(str(error)) from error


def _spread(cells: Sequence[Cell], takes: Mapping[str, TrainingClip], kind: str, done: Done) -> list[Outcome]:
    ray = ray_runtime.require("ray")
    task = ray.remote(measure)
    there = {name: ray.put(take) for name, take in takes.items()}
    waiting = {task.remote(cell, there[cell.clip], kind): cell for cell in cells}
    outcomes: dict[Cell, Outcome] = {}
    while waiting:
        (ready,), _ = ray.wait(list(waiting))
        cell = waiting.pop(ready)
        try:
            outcomes[cell] = ray.get(ready)
        except ray.exceptions.RayError as error:  # a worker has died
            outcomes[cell] = failed(cell, error)
        done(outcomes[cell])
    return [outcomes[cell] for cell in cells]
