"""The server: it is quiet, it is found where it was asked to be, and pages of strangers cannot use it."""

import socket
import urllib.request
from importlib.metadata import version

import pytest

from usd_tools.console.errors import ToolError
from usd_tools.viewer.server import serving

pytest.importorskip("viser")


def connect(port, origin):
    from websockets.sync.client import connect

    with connect(f"ws://127.0.0.1:{port}", origin=origin, subprotocols=[f"viser-v{version('viser')}"]):
        pass


def test_serves_its_page_and_nothing_to_strangers(capfd):
    from websockets.exceptions import InvalidStatus

    with serving("127.0.0.1", 0) as server:
        port = server.get_port()
        assert b"<html" in urllib.request.urlopen(f"http://127.0.0.1:{port}").read().lower()
        connect(port, f"http://localhost:{port}")
        for stranger in (
            "http://example.com",
            "http://localhost.example.com:80",
            f"http://127.0.0.1.example.com:{port}",
        ):
            with pytest.raises(InvalidStatus, match="403"):
                connect(port, stranger)
    assert capfd.readouterr().out == ""


def test_a_port_that_is_taken_is_refused():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ToolError, match=f"port {port} of 127.0.0.1 cannot be bound"), serving("127.0.0.1", port):
            pass
