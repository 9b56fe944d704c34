"""Debian's chromium, without a window, for pages."""

import shutil
from contextlib import contextmanager
from urllib.parse import urlparse

import pytest

CHROMIUM = shutil.which("chromium")
FLAGS = "--headless --no-sandbox --no-first-run --disable-background-networking".split()
SOFTWARE = "--disable-gpu --enable-unsafe-swiftshader".split()
"""WebGL without a graphics card."""


@contextmanager
def opened(address, width=1280, height=800):
    """Open a page; give its tab, and a list that fills with errors and with requests to anything but its server."""
    sync_api = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("there is no chromium: apt-get install chromium")
    problems, own = [], urlparse(address).netloc
    with sync_api.sync_playwright() as playwright:
        # its own --headless would be another browser, which Debian does not have
        browser = playwright.chromium.launch(executable_path=CHROMIUM, headless=False, args=[*FLAGS, *SOFTWARE])
        tab = browser.new_page(viewport={"width": width, "height": height})
        tab.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: problems.append(str(error)))
        tab.on("request", lambda request: _judge(request.url, own, problems))
        tab.on("websocket", lambda socket: _judge(socket.url, own, problems))
        tab.goto(address)
        try:
            yield tab, problems
        finally:
            browser.close()


def _judge(url, own, problems):
    if not url.startswith(("data:", "blob:")) and urlparse(url).netloc != own:
        problems.append(f"asked for {url}")
