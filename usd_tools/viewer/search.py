"""Learning from the page: a search in a thread of its own, with progress, which the user may end."""

from __future__ import annotations

import threading
from collections.abc import Callable

from usd_tools.console.errors import ToolError
from usd_tools.editing.edits import Edit
from usd_tools.editing.session import EditSession
from usd_tools.viewer.inbox import Inbox


class _Ended(Exception):
    """The user ended the search."""


class Search:
    """Search for the metric of a session's present keys; the session changes only when the result is applied.

    Parameters
    ----------
    session : EditSession
    purpose : str
        See `EditSession.learned`.
    inbox : Inbox
        Told of what follows.
    on_progress : callable
        Called with a text, and with None at the end.
    on_end : callable
        Called with the edit, or with None and why there is none: "" where the user ended the search.
    """

    def __init__(
        self,
        session: EditSession,
        purpose: str,
        inbox: Inbox,
        on_progress: Callable[[str | None], None],
        on_end: Callable[[Edit | None, str], None],
    ) -> None:
        self._session, self._purpose, self._inbox = session, purpose, inbox
        self._on_progress, self._on_end = on_progress, on_end
        self._is_ended = threading.Event()

    def start(self) -> None:
        """Begin."""
        self._on_progress("Learning")
        threading.Thread(target=self._run, daemon=True).start()

    def end(self) -> None:
        """End without a result."""
        self._is_ended.set()

    def _run(self) -> None:
        edit, sentence = None, ""
        try:
            edit = self._session.learned(self._advance, purpose=self._purpose)
        except _Ended:
            pass
        except ToolError as error:
            sentence = str(error)
        self._inbox.post(lambda: self._on_progress(None), "progress")
        self._inbox.post(lambda: self._on_end(edit, sentence))

    def _advance(self, done: float, total: float | None, text: str) -> None:
        if self._is_ended.is_set():
            raise _Ended
        self._inbox.post(lambda: self._on_progress(text), "progress")
