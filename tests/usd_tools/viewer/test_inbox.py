"""The inbox: everything that is asked for is done once, in order, but of a dragged slider only the newest."""

import threading
import time

from usd_tools.viewer.inbox import Inbox


def done(inbox, seconds=0.0):
    return [action() for action in inbox.wait(seconds)]


def test_keeps_the_order():
    inbox = Inbox()
    for i in range(5):
        inbox.post(lambda i=i: i)
    assert done(inbox) == [0, 1, 2, 3, 4] and done(inbox) == []


def test_the_newest_of_a_key_takes_the_place_of_the_oldest():
    inbox = Inbox()
    inbox.post(lambda: "drag 1", "slider")
    inbox.post(lambda: "click")
    inbox.post(lambda: "drag 2", "slider")
    assert done(inbox) == ["drag 2", "click"]


def test_waits_for_another_thread():
    inbox = Inbox()
    threading.Timer(0.05, inbox.post, [lambda: "late"]).start()
    start = time.monotonic()
    assert done(inbox, 10.0) == ["late"] and time.monotonic() - start < 5.0
