"""The page without a browser: what its controls ask for is done to the session, and shown by them."""

import json

import numpy as np
import pytest
from rigs import JOINTS, make_rig, random_rotations

from geomstats_anim import interpolate
from usd_tools import inspect
from usd_tools.console.errors import ToolError
from usd_tools.editing.history import autosave_path
from usd_tools.editing.session import EditSession
from usd_tools.viewer.controls import ALL_SAMPLES, CHOSEN, EVERY_NTH
from usd_tools.viewer.page import LivePage
from usd_tools.viewer.scene import OURS, SLERP
from usd_tools.viewer.server import serving
from usd_tools.viewer.view import figure

pytest.importorskip("viser")


@pytest.fixture(scope="module")
def server():
    with serving("127.0.0.1", 0) as server:
        yield server


@pytest.fixture
def page(server, tmp_path):
    server.scene.reset()
    server.gui.reset()
    make_rig(tmp_path / "in.usda", codes=range(41), rotations=random_rotations(41, 3, size=1.2))
    page = LivePage(server, EditSession.open(tmp_path / "in.usda"), tmp_path / "out.usda", tmp_path / "presets")
    page.warnings = []
    page.notify = lambda title, text, color=None: page.warnings.append(text)
    return page


def test_a_dense_clip_begins_with_every_tenth_key(page):
    assert page.session.keys.tolist() == [0, 10, 20, 30, 40]


def test_a_dragged_slider_is_one_step_of_undo(page):
    page.choose_pattern("*arm*")
    page.work()
    before = page.session.poses(OURS).copy()
    for alpha in (2.0, 4.0, 8.0):
        page.drag("alpha", alpha)
        page.work()
    assert not page.session.is_thorough and len(page.session.edits) == 1
    page.drag("beta", 0.5)
    page.work()
    page.step("undo")
    page.work()
    assert page.session.edits[-1].alpha == 8.0 and len(page.session.edits) == 2
    assert page.controls.alpha.slider.value == 3.0 and page.controls.beta.slider.value == 0.0
    assert page.controls.alpha.box.value == 8.0 and page.controls.beta.box.value == 1.0
    page.step("undo")
    page.work()
    np.testing.assert_array_equal(page.session.poses(OURS), before)


def test_after_release_motion_is_that_of_interpolate(page):
    page.drag("alpha", 6.0)
    page.work()
    page.choose_pattern("*")
    page.work()
    session = page.session
    keys = session.motion("original").at_frames(np.isin(session.codes, session.keys))
    expected = interpolate(keys, session.times, session.metric.scheme, session.metric)
    np.testing.assert_allclose(session.motion(OURS).rotations, expected.rotations, atol=1e-12)


def test_wrong_requests_are_sentences(page):
    page.choose_pattern("*tail*")
    page.store_preset("../secret")
    page.store_preset("slerp")
    page.mirror()
    page.work()
    assert len(page.warnings) == 4 and "No joint matches '*tail*'" in page.warnings[0]
    assert page.chosen == [0, 1, 2]


def test_keys_presets_and_schemes(page):
    page.use_keys(CHOSEN, 7)
    page.work()
    assert len(page.session.keys) == 7
    page.use_keys(ALL_SAMPLES, 1)
    page.work()
    assert len(page.session.keys) == 41
    page.use_keys(EVERY_NTH, 20)
    page.pin(True)
    page.use_scheme("geodesic")
    page.drag("alpha", 3.0)
    page.store_preset("mine")
    page.work()
    assert page.session.metric.scheme == page.controls.scheme.value == "geodesic"
    page.use_preset("slerp")
    page.work()
    assert (page.session.metric.parameters.alpha == 1.0).all()
    page.use_preset("mine")
    page.work()
    assert (page.session.metric.parameters.alpha == 3.0).all() and page.warnings == []


def test_learning_is_an_edit(page):
    page.learn("reconstruct")
    for _ in range(300):
        page.work(0.1)
        if len(page.session.edits) == 2:
            break
    errors = {name: page.session.errors(name).centimetres.mean() for name in (OURS, SLERP)}
    assert errors[OURS] < errors[SLERP]


def test_edits_are_kept_and_taken_up(page, server, tmp_path):
    page.drag("alpha", 5.0)
    page.work()
    page.choose_pattern("*")
    page.work()
    stored = autosave_path(tmp_path / "out.usda")
    assert json.loads(stored.read_text())["format"] == "geomstatsAnimSession"
    again = LivePage(server, EditSession.open(tmp_path / "in.usda"), tmp_path / "out.usda", tmp_path / "presets")
    again.take_up()
    again.work()
    np.testing.assert_array_equal(again.session.poses(OURS), page.session.poses(OURS))


@pytest.mark.parametrize("content", ["metric", "keys", "dense"])
def test_save_writes_what_other_verbs_read(page, tmp_path, content):
    page.drag("alpha", 5.0)
    page.save(content)
    page.work()
    assert page.warnings == [] and inspect.main([str(tmp_path / "out.usda")]) == 0
    assert not autosave_path(tmp_path / "out.usda").exists()
    assert "out.usda" in page.controls.saved.content


def test_names_from_files_are_text(server, tmp_path):
    joint = "<img src=x onerror=alert(1)>"
    from usd_tools.viewer.controls import _html

    assert "<img" not in _html([(OURS, joint)])
    make_rig(tmp_path / "<b>in.usda", codes=range(6), joints=["a", "a/b"], rotations=random_rotations(6, 2))
    server.gui.reset()
    page = LivePage(server, EditSession.open(tmp_path / "<b>in.usda"), tmp_path / "<b>out.usda", tmp_path / "presets")
    page.save("metric")
    page.work()
    assert "<b>" not in page.controls.saved.content and "&lt;b&gt;out.usda" in page.controls.saved.content


def test_playing_pushes_a_message_per_part(page):
    page.toggle()
    page.work()
    assert page.clock.is_playing
    sent = []
    plain = page.server.scene._websock_interface.queue_message
    page.server.scene._websock_interface.queue_message = lambda message: (sent.append(message), plain(message))
    try:
        page.clock.seek(1.0, 0.0)
        page.tick()
    finally:
        page.server.scene._websock_interface.queue_message = plain
    assert sum("vertices" in getattr(message, "updates", {}) for message in sent) == 3
    assert len(sent) <= 7  # and where the world is, the frame, the time, a chart


def test_a_click_chooses_the_joint_that_is_met(page):
    matrices = page.session.poses(OURS, 0)
    middle = 0.5 * (matrices[1, :, 3] + matrices[2, :, 3])
    side = np.cross(matrices[2, :, 3] - matrices[1, :, 3], [0.1, 0.7, 0.7])
    page.clicked(OURS, middle + side, -side / np.linalg.norm(side))
    page.work()
    assert [JOINTS[i] for i in page.chosen] == ["hips/spine"]
    page.clicked(OURS, middle + side, side / np.linalg.norm(side))
    page.work()
    assert len(page.chosen) == 1


def test_a_clip_that_does_not_move_is_refused(tmp_path):
    make_rig(tmp_path / "still.usda", codes=[0])
    with pytest.raises(ToolError):
        EditSession.open(tmp_path / "still.usda")


def test_errors_have_three_digits_for_characters_of_any_size():
    figures = [figure(value) for value in (0.0, 0.0012345, 0.35, 35.402, 246.3, 12345.6)]
    assert figures == ["0", "0.00123", "0.35", "35.4", "246", "12346"]
