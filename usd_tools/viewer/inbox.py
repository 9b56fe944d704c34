"""Work for the page's one thread: what browsers ask for, in order, and of a dragged slider only the newest."""

from __future__ import annotations

import threading
from collections.abc import Callable

Action = Callable[[], None]


class Inbox:
    """Actions that other threads ask one thread to do, so that nothing needs a lock."""

    def __init__(self) -> None:
        self._actions: dict[object, Action] = {}
        self._arrived = threading.Condition()

    def post(self, action: Action, key: str | None = None) -> None:
        """Ask for an action; one with the same key that has not begun is dropped, its place taken."""
        with self._arrived:
            self._actions[object() if key is None else key] = action
            self._arrived.notify()

    def wait(self, seconds: float) -> list[Action]:
        """Return what was asked for, after waiting some seconds at most for something."""
        with self._arrived:
            if not self._actions:
                self._arrived.wait(seconds)
            actions = list(self._actions.values())
            self._actions.clear()
        return actions
