"""Run a verb's function on several files: here, in processes, or by Ray; a file that fails does not stop the others."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from usd_tools.batch.options import BatchOptions
from usd_tools.batch.result import FAILED, SKIPPED, WRITTEN, FileResult, Result
from usd_tools.batch.tasks import FileTask
from usd_tools.console.errors import ToolError
from usd_tools.console.progress import Progress, ProgressCallback

Verb = Callable[..., Result]
"""The function of a verb that works on a file: source, output, options, progress and warn, all by position."""


def run_tasks(
    verb: Verb,
    tasks: Sequence[FileTask],
    options: Any,
    how: BatchOptions,
    done: Callable[[FileResult], None] = lambda result: None,
    progress: ProgressCallback | None = None,
) -> tuple[FileResult, ...]:
    """Run a verb on files.

    Parameters
    ----------
    verb : callable
        A function of a module, so that other processes find it.
    tasks : sequence of FileTask
    options : Options
        Of the verb.
    how : BatchOptions
    done : callable
        Told of each result as it comes.
        Optional, default: nobody is told.
    progress : ProgressCallback
        Optional, default: nobody is told.

    Returns
    -------
    results : tuple of FileResult
        In the order of the tasks.

    Raises
    ------
    ToolError
        If Ray is asked for, but is not installed or cannot be joined.
    """
    bar = Progress(progress, len(tasks), "Working")
    results: dict[FileTask, FileResult] = {}

    def take(task: FileTask, result: FileResult) -> None:
        results[task] = result
        done(result)
        bar.advance(1.0, task.name)

    waiting = []
    for task in tasks:
        if how.skip_existing and task.out is not None and task.out.exists():
            take(task, FileResult(task.name, _name(task), SKIPPED, "the output is there"))
        else:
            waiting.append(task)
    made = _make_folders(waiting)
    try:
        for task, result in _results(verb, waiting, options, how):
            take(task, result)
    finally:
        for folder in reversed(made):
            with suppress(OSError):  # what holds something stays
                folder.rmdir()
    return tuple(results[task] for task in tasks)


def _results(
    verb: Verb, tasks: Sequence[FileTask], options: Any, how: BatchOptions
) -> Iterator[tuple[FileTask, FileResult]]:
    """Yield the result of each task as it comes."""
    from geomstats_anim.learning.tune import ray_runtime

    if how.jobs is None and ray_runtime.is_wanted(how.address, how.cpus):
        yield from _by_ray(verb, tasks, options, how)
    elif min(how.jobs or 1, len(tasks)) > 1:
        yield from _by_processes(verb, tasks, options, min(how.jobs or 1, len(tasks)))
    else:
        for task in tasks:
            yield task, work(verb, task, options)


def work(verb: Verb, task: FileTask, options: Any) -> FileResult:
    """Run a verb on one file; whatever goes wrong is in the result."""
    try:
        result = verb(task.source, task.out, options, None, None)
    except ToolError as error:
        return _failed(task, str(error))
    except OSError as error:
        return _failed(task, f"{error.filename or task.source}: {error.strerror or error}.")
    except Exception as error:  # a mistake of ours, which must not cost the other files
        return _failed(task, f"{type(error).__name__}: {error}")
    return FileResult(task.name, _name(task), WRITTEN, result.brief, result.warnings, result.as_dict())


def _failed(task: FileTask, sentence: str) -> FileResult:
    return FileResult(task.name, _name(task), FAILED, sentence)


def _name(task: FileTask) -> str | None:
    """Name the output as seen from the output folder: where the source is in its own."""
    return None if task.out is None else Path(task.name).with_name(task.out.name).as_posix()


def _make_folders(tasks: Sequence[FileTask]) -> list[Path]:
    """Make the folders of all outputs; return those that were not there, outer ones first."""
    folders = {folder for task in tasks if task.out is not None for folder in (task.out.parent, *task.out.parents)}
    made = sorted(folder for folder in folders if not folder.exists())
    for folder in made:
        try:
            folder.mkdir()
        except OSError as error:
            raise ToolError(f"--out: the folder {folder} cannot be made: {error.strerror}.") from error
    return made


def _by_processes(
    verb: Verb, tasks: Sequence[FileTask], options: Any, jobs: int
) -> Iterator[tuple[FileTask, FileResult]]:
    # Neither OpenUSD nor the threads of our kernels survive a fork.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, context, initializer=_leave_interrupts_to_the_parent) as pool:
        futures = {pool.submit(work, verb, task, options): task for task in tasks}
        try:
            for future in as_completed(futures):
                yield futures[future], _outcome(future, futures[future])
        finally:
            pool.shutdown(cancel_futures=True)


def _outcome(future: Future[FileResult], task: FileTask) -> FileResult:
    try:
        return future.result()
    except Exception as error:  # the process has died, and all that wait for one with it
        reason = str(error).partition(".")[0]
        return _failed(task, f"{reason}; run it again with --skip-existing and fewer --jobs.")


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _by_ray(
    verb: Verb, tasks: Sequence[FileTask], options: Any, how: BatchOptions
) -> Iterator[tuple[FileTask, FileResult]]:
    from geomstats_anim.learning.tune import ray_runtime

    try:
        with ray_runtime.running(how.address, how.cpus):
            ray = ray_runtime.require("ray")
            remote = ray.remote(work)
            waiting = {remote.remote(verb, _from_root(task), options): task for task in tasks}
            while waiting:
                (ready,), _ = ray.wait(list(waiting))
                task = waiting.pop(ready)
                try:
                    result = ray.get(ready)
                except ray.exceptions.RayError as error:  # a worker has died
                    result = _failed(task, f"Ray: {str(error).strip().partition(chr(10))[0]}")
                yield task, replace(result, brief=_as_named(result.brief, task))
    except (ModuleNotFoundError, ConnectionError) as error:
        raise ToolError(str(error)) from error


def _from_root(task: FileTask) -> FileTask:
    """Name files by their whole paths, for workers are in other folders."""
    out = None if task.out is None else Path(os.path.abspath(task.out))
    return replace(task, source=Path(os.path.abspath(task.source)), out=out)


def _as_named(text: str, task: FileTask) -> str:
    return text.replace(os.path.abspath(task.source), str(task.source))
