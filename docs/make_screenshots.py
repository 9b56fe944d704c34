"""Take the pictures of the page of `live`: python docs/make_screenshots.py. The pictures are kept in git.

They need the extra live, and Playwright with Debian's chromium, as the tests do.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

from usd_tools.editing.session import EditSession
from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.motions import MOTIONS
from usd_tools.example_clips.stage import make_stage
from usd_tools.viewer.controls import OVERLAID
from usd_tools.viewer.page import LivePage
from usd_tools.viewer.server import serving

_IMAGES = Path(__file__).resolve().parent / "images"
_FLAGS = "--headless --no-sandbox --enable-unsafe-swiftshader --use-gl=angle --use-angle=swiftshader".split()
_PATIENCE = 120_000  # milliseconds: rendering by software takes seconds for a frame


@contextmanager
def _served(path: Path) -> Iterator[tuple[LivePage, str]]:
    with serving("127.0.0.1", 0) as server:
        page = LivePage(server, EditSession.open(path), path.with_name("out.usda"), path.with_name("presets"))
        thread = threading.Thread(target=page.run)
        thread.start()
        try:
            yield page, f"http://127.0.0.1:{server.get_port()}"
        finally:
            page.stop()
            thread.join()


def _bend(page: LivePage, tab: Any) -> None:
    """Bend an arm, side by side with the original and slerp."""
    page.seek(81)
    page.choose_pattern("*RightHand")
    tab.wait_for_timeout(2000)


def _compare(page: LivePage, tab: Any) -> None:
    """Lay all three over each other, with the error of the hand over time."""
    page.controls.layout.value = OVERLAID
    page.change_view()
    page.seek(86)
    page.choose_pattern("*RightHand")
    tab.get_by_text("Error, cm").click()
    tab.wait_for_timeout(2000)


def _take(clip: Path, name: str, prepare: Callable[[LivePage, Any], None]) -> None:
    with _served(clip) as (page, address), sync_playwright() as playwright:
        chromium = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, headless=False, args=_FLAGS)
        tab = browser.new_page(viewport={"width": 1200, "height": 760})
        tab.goto(address)
        tab.get_by_role("button", name="Play").wait_for(timeout=_PATIENCE)
        tab.wait_for_timeout(4000)
        tab.evaluate("document.querySelectorAll('.mantine-Notification-closeButton').forEach((each) => each.click())")
        prepare(page, tab)
        tab.wait_for_timeout(25_000)
        picture = Image.open(io.BytesIO(tab.screenshot(timeout=_PATIENCE))).convert("RGB")
        browser.close()
    picture.save(_IMAGES / f"{name}.webp", quality=80, method=6)
    print(_IMAGES / f"{name}.webp")


def main() -> int:
    """Take both pictures, of the example pitch."""
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "pitching.usda"
        stage = make_stage(MOTIONS["pitching"](), build_skin())
        stage.GetRootLayer().Export(str(clip))
        _take(clip, "live", _bend)
        _take(clip, "live_overlaid", _compare)
    return 0


if __name__ == "__main__":
    sys.exit(main())
