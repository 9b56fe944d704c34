"""Ray, started or joined only for as long as it is needed, and quietly."""

from __future__ import annotations

import importlib
import logging
import os
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

_REACHABLE_IN = 5.0
"""Seconds that a cluster has to answer; Ray itself would try for minutes."""


def require(module: str, extra: str = "tune") -> ModuleType:
    """Import a module of an optional extra.

    Parameters
    ----------
    module : str
    extra : str
        Optional, default: "tune".

    Returns
    -------
    module : module

    Raises
    ------
    ModuleNotFoundError
        If it is not installed, in a sentence that names the extra.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0]
        raise ModuleNotFoundError(
            f"This needs {package}, which is not installed; run: pip install 'geomstats-anim[{extra}]'", name=package
        ) from error


def is_wanted(address: str | None = None, cpus: int | None = None) -> bool:
    """Return whether a cluster is named or several processors are asked for."""
    return bool(address or os.environ.get("RAY_ADDRESS")) or (cpus or 1) > 1


@contextmanager
def running(address: str | None = None, cpus: int | None = None) -> Iterator[int]:
    """Have Ray running: the one that runs already, the cluster at an address, or a local instance of our own.

    Parameters
    ----------
    address : str
        Of a cluster: HOST:PORT, ray://HOST:PORT, or "auto" for one on this machine.
        Optional, default: the environment variable RAY_ADDRESS, and without it a local instance.
    cpus : int
        Workers.
        Optional, default: all processors of the cluster; 1 for a local instance, so that results repeat.

    Yields
    ------
    workers : int

    Raises
    ------
    ConnectionError
        If no cluster answers at the address.
    """
    if cpus is not None and cpus < 1:
        raise ValueError(f"There must be at least one worker, but cpus is {cpus}.")
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    ray = require("ray")
    if ray.is_initialized():
        yield cpus or _processors(ray)
        return
    address = address or os.environ.get("RAY_ADDRESS")
    quiet = {"log_to_driver": False, "logging_level": logging.ERROR}
    if address and address != "local":
        check_reachable(address)
        try:
            ray.init(address=address, **quiet)
        except Exception as error:  # Ray has no common class for the many ways in which joining fails
            reason = str(error).strip().partition("\n")[0].rstrip(".")
            raise ConnectionError(f"The Ray cluster at {address} cannot be joined: {reason}.") from error
    else:
        with _importable():
            ray.init(address="local", num_cpus=cpus or 1, include_dashboard=False, **quiet)
    try:
        yield cpus or _processors(ray)
    finally:
        ray.shutdown()


def map_tasks(work: Callable[[Any], Any], items: Sequence[Any], done: Callable[[int], None]) -> list[Any]:
    """Do work for each item on the workers of Ray, which is running.

    Parameters
    ----------
    work : callable
    items : sequence
    done : callable
        Called with the number of items that are done.

    Returns
    -------
    results : list
        In the order of the items.

    Raises
    ------
    ConnectionError
        If a worker dies.
    """
    ray = require("ray")
    task, shared = ray.remote(_apply), ray.put(work)
    waiting = {task.remote(shared, item): i for i, item in enumerate(items)}
    results: list[Any] = [None] * len(items)
    while waiting:
        (ready,), _ = ray.wait(list(waiting))
        try:
            results[waiting.pop(ready)] = ray.get(ready)
        except ray.exceptions.RayError as error:
            reason = str(error).strip().rpartition("\n")[2].rstrip(".")
            raise ConnectionError(f"A worker of Ray has failed: {reason}.") from error
        done(len(items) - len(waiting))
    return results


def _apply(work: Callable[[Any], Any], item: Any) -> Any:
    return work(item)


def _processors(ray: ModuleType) -> int:
    return max(1, int(ray.cluster_resources().get("CPU", 1)))


def one_place_each(workers: int) -> list[dict[str, Any]]:
    """Return the node of each of several actors, for Ray: as many per node as it has processors, then again.

    Ray's own "SPREAD" goes by the processors that an actor takes; those that take none may all end up on one node.

    Parameters
    ----------
    workers : int

    Returns
    -------
    options : list of dict, length [workers]
        For `options` of an actor's class.
    """
    nodes = [node for node in require("ray").nodes() if node["Alive"]]
    places = [node["NodeID"] for node in nodes for _ in range(int(node["Resources"].get("CPU", 0)))]
    affinity = require("ray.util.scheduling_strategies").NodeAffinitySchedulingStrategy
    return [
        {"scheduling_strategy": affinity(places[i % len(places)], soft=False)} if places else {} for i in range(workers)
    ]


@contextmanager
def _importable() -> Iterator[None]:
    """Let the workers that are started find this package where we found it, installed or not."""
    before = os.environ.get("PYTHONPATH")
    root = str(Path(__file__).parents[3])
    os.environ["PYTHONPATH"] = root if before is None else os.pathsep.join([root, before])
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before


def check_reachable(address: str) -> None:
    """Raise ConnectionError, in a sentence, if nothing answers at the address of a cluster."""
    if address == "auto":
        return
    host, _, port = address.rpartition("://")[2].rpartition(":")
    if not host or not port.isdigit():
        raise ConnectionError(f'The address of a Ray cluster is HOST:PORT, ray://HOST:PORT or "auto", not {address!r}.')
    try:
        socket.create_connection((host, int(port)), timeout=_REACHABLE_IN).close()
    except OSError as error:
        raise ConnectionError(
            f"There is no Ray cluster at {address} ({error.strerror or error}); start one with: ray start --head"
        ) from error
