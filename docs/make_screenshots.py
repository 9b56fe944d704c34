"""Take the pictures of the page of `live`: python docs/make_screenshots.py [FILE ... -o FOLDER].

Without files it takes the two that are kept in git, of the example pitch. With files it takes one of each, into FOLDER,
to be looked at: with Y up and Z up, without a skin, with many joints. It needs the extra live, and Playwright with
Debian's chromium, as the tests do.
"""

from __future__ import annotations

import argparse
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
_FLAGS = "--headless --no-sandbox --disable-gpu --enable-unsafe-swiftshader".split()
_PATIENCE, _DRAWN = 120_000, 15_000  # milliseconds: rendering by software takes seconds for a frame


@contextmanager
def _served(path: Path, folder: Path) -> Iterator[tuple[LivePage, str]]:
    with serving("127.0.0.1", 0) as server:
        page = LivePage(server, EditSession.open(path), folder / "out.usda", folder / "presets")
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


def _look(page: LivePage, tab: Any) -> None:
    """Show the middle of the clip, and the path of the last joint."""
    page.seek(len(page.session.times) // 2)
    page.choose_joint(page.controls.joint.options[-1])
    tab.wait_for_timeout(2000)


def _take(clip: Path, picture: Path, prepare: Callable[[LivePage, Any], None]) -> None:
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        chromium = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, headless=False, args=_FLAGS)
        with _served(clip, Path(folder)) as (page, address):
            tab = browser.new_page(viewport={"width": 1200, "height": 760})
            tab.goto(address)
            tab.get_by_role("button", name="Play").wait_for(timeout=_PATIENCE)
            tab.wait_for_timeout(4000)
            tab.evaluate(
                "document.querySelectorAll('.mantine-Notification-closeButton').forEach((each) => each.click())"
            )
            prepare(page, tab)
            tab.wait_for_timeout(_DRAWN)
            image = Image.open(io.BytesIO(tab.screenshot(timeout=_PATIENCE))).convert("RGB")
        browser.close()
    image.save(picture, quality=80, method=6)
    print(picture)


def main() -> int:
    """Take both pictures of the example pitch, or one of each file."""
    parse = argparse.ArgumentParser(description="Take pictures of the page of live.")
    parse.add_argument("files", metavar="FILE", type=Path, nargs="*")
    parse.add_argument("-o", "--out", metavar="FOLDER", type=Path, default=_IMAGES)
    args = parse.parse_args()
    if args.files and args.out == _IMAGES:
        parse.error("name a folder for the pictures with -o")
    args.out.mkdir(parents=True, exist_ok=True)
    for path in args.files:
        _take(path, args.out / f"{path.stem}.webp", _look)
    if not args.files:
        with tempfile.TemporaryDirectory() as folder:
            clip = Path(folder) / "pitching.usda"
            stage = make_stage(MOTIONS["pitching"](), build_skin())
            stage.GetRootLayer().Export(str(clip))
            _take(clip, args.out / "live.webp", _bend)
            _take(clip, args.out / "live_overlaid.webp", _compare)
    return 0


if __name__ == "__main__":
    sys.exit(main())
