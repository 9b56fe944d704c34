"""Answer requests from a pipe, one after the other, until it ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

import numpy as np

from geomstats_anim import __version__
from usd_tools.console.errors import ToolError
from usd_tools.console.progress import ProgressCallback
from usd_tools.serving.messages import read_message, write_message

Answer = tuple[dict[str, Any], dict[str, np.ndarray]]

_EVERY = 0.2
"""Seconds between reports of progress."""


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer requests, each with any number of headers that say progress, and one that says done or error.

    Parameters
    ----------
    requests, answers : binary file
        See `messages`.
    """
    last = time.monotonic()

    def report(done: float, total: float | None, text: str) -> None:
        nonlocal last
        if time.monotonic() - last >= _EVERY:
            last = time.monotonic()
            write_message(answers, {"progress": text}, {})

    while True:
        try:
            message = read_message(requests)
        except ValueError as error:
            # what follows cannot be found
            write_message(answers, {"error": str(error)}, {})
            return
        if message is None:
            return
        header, arrays = answer(*message, report)
        write_message(answers, header, arrays)


def answer(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray], progress: ProgressCallback) -> Answer:
    """Answer a request; one that does not fit with a sentence.

    Parameters
    ----------
    header : mapping
        request, one of hello, in-betweens, learn, and what that needs.
    arrays : mapping of str to array-like
    progress : callable

    Returns
    -------
    header : dict
        done is True, or error is a sentence.
    arrays : dict of str to array-like
    """
    try:
        work = _WORK.get(str(header.get("request")))
        if work is None:
            raise ToolError(f"There is no request {str(header.get('request'))[:80]!r} in {__version__}.")
        results, numbers = work(header, arrays, progress)
    except (ToolError, ValueError) as error:
        return {"error": str(error)}, {}
    except (ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError, TypeError) as error:
        return {"error": f"The request cannot be understood: {type(error).__name__} {error}"}, {}
    return {"done": True, **results}, numbers


def _hello(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray], progress: ProgressCallback) -> Answer:
    return {"version": __version__}, {}


def _in_betweens(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray], progress: ProgressCallback) -> Answer:
    from usd_tools.serving.in_betweens import in_betweens

    return in_betweens(header, arrays)


def _learned(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray], progress: ProgressCallback) -> Answer:
    from usd_tools.serving.learning import learned

    return learned(header, arrays, progress)


_WORK: dict[str, Callable[..., Answer]] = {"hello": _hello, "in-betweens": _in_betweens, "learn": _learned}
