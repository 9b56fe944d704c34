"""The page in browsers: it plays, a slider bends motion, a click chooses a joint, Save writes, and two see the same."""

import threading
from contextlib import contextmanager

import numpy as np
import pytest
from chromium import opened
from real_files import real_file
from rigs import make_rig, random_rotations

from usd_tools import inspect
from usd_tools.editing.history import autosave_path
from usd_tools.editing.session import EditSession
from usd_tools.viewer.page import LivePage
from usd_tools.viewer.scene import OURS
from usd_tools.viewer.server import serving

pytest.importorskip("viser")


@contextmanager
def served(path, out):
    """Serve the page of a file; give the server, the page and its session, which only the page changes."""
    session = EditSession.open(path)
    with serving("127.0.0.1", 0) as server:
        page = LivePage(server, session, out, out.parent / "presets")
        thread = threading.Thread(target=page.run)
        thread.start()
        try:
            yield server, page, session
        finally:
            page.stop()
            thread.join()


def until(tab, condition, seconds=20.0):
    for _ in range(int(10 * seconds)):
        if condition():
            return
        tab.wait_for_timeout(100)
    raise AssertionError("it did not happen")


def on_screen(camera, place, width, height):
    """Project a place in the world to pixels of a view."""
    ahead = (camera.look_at - camera.position) / np.linalg.norm(camera.look_at - camera.position)
    right = np.cross(ahead, camera.up_direction)
    right /= np.linalg.norm(right)
    seen = place - camera.position
    scale = 0.5 * height / np.tan(0.5 * camera.fov) / (seen @ ahead)
    return 0.5 * width + scale * (seen @ right), 0.5 * height - scale * (seen @ np.cross(right, ahead))


def picture(tab, box):
    """Take a picture of the view; rendering by software may need seconds for a frame."""
    return tab.screenshot(clip=box, timeout=90_000)


def thumb(tab, label):
    row = tab.locator(f'//label[.="{label}"]/ancestor::div[contains(@class,"Flex-root")][1]')
    box = row.get_by_role("slider").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@pytest.mark.slow
def test_a_clip_is_edited_with_the_mouse(tmp_path):
    out = tmp_path / "out.usda"
    with served(real_file("clips/punching.usda"), out) as (server, page, session):
        with opened(f"http://127.0.0.1:{server.get_port()}") as (tab, problems):
            until(tab, lambda: server.get_clients())
            (client,) = server.get_clients().values()
            box = tab.locator("canvas").last.bounding_box()
            tab.wait_for_timeout(1500)
            box["height"] -= 220  # above the time line

            assert len(page.chosen) == session.skeleton.n_joints
            place = session.poses(OURS, page.frame)[2, :, 3] + page.view.scene.offset(OURS)
            tab.mouse.click(*on_screen(client.camera, place, box["width"], box["height"] + 220))
            until(tab, lambda: len(page.chosen) == 1)

            # a joint that moves, whose motion alpha changes
            page.choose_pattern("*arm*")
            until(tab, lambda: len(page.chosen) > 1)
            before, motion = picture(tab, box), session.poses(OURS).copy()
            x, y = thumb(tab, "alpha")
            tab.mouse.move(x, y)
            tab.mouse.down()
            tab.mouse.move(x + 45, y, steps=5)
            tab.mouse.up()
            until(tab, lambda: getattr(session.edits[-1], "alpha", None) and session.edits[-1].alpha > 2.0)
            assert np.abs(session.poses(OURS) - motion).max() > 1e-4

            # the box beside the slider shows and takes the value, not its logarithm
            alpha = tab.get_by_label("alpha =", exact=True)
            until(tab, lambda: float(alpha.input_value()) == round(session.edits[-1].alpha, 4))
            alpha.fill("0.5")
            until(tab, lambda: session.edits[-1].alpha == 0.5)
            assert autosave_path(out).exists()

            tab.get_by_role("button", name="Play").click()
            until(tab, lambda: page.frame > 3)
            tab.get_by_role("button", name="Pause").click()
            until(tab, lambda: picture(tab, box) != before)

            tab.get_by_role("button", name="Save", exact=True).click()
            until(tab, lambda: out.exists() and not autosave_path(out).exists())
            assert problems == []
    assert inspect.main([str(out)]) == 0


@pytest.mark.slow
def test_two_browsers_see_the_same_session(tmp_path):
    make_rig(tmp_path / "in.usda", codes=range(41), rotations=random_rotations(41, 3, size=1.2))
    with served(tmp_path / "in.usda", tmp_path / "out.usda") as (server, page, session):
        address = f"http://127.0.0.1:{server.get_port()}"
        with opened(address, 640, 400) as (one, problems):  # small, for two are rendered by software
            other = one.context.browser.new_page(viewport={"width": 640, "height": 400})
            for tab in (one, other):
                tab.set_default_timeout(120_000)
            other.on("pageerror", lambda error: problems.append(str(error)))
            other.goto(address)
            until(one, lambda: len(server.get_clients()) == 2)
            boxes = [tab.get_by_label("alpha =", exact=True) for tab in (one, other)]

            one.bring_to_front()
            boxes[0].fill("4")
            until(other, lambda: getattr(session.edits[-1], "alpha", None) == 4.0)
            until(other, lambda: [box.input_value() for box in boxes] == ["4", "4"])
            other.bring_to_front()
            other.get_by_role("button", name="undo").click()
            until(one, lambda: [box.input_value() for box in boxes] == ["1", "1"])
            other.get_by_role("button", name="Play").click()
            one.get_by_role("button", name="Pause").wait_for()
            page.choose_pattern("*arm*")
            for tab in (one, other):
                tab.get_by_text("chosen joint").wait_for()
            one.close()
            other.get_by_role("button", name="Pause").click()
            until(other, lambda: not page.clock.is_playing)
            assert problems == []
