"""Points for the player: what is packed comes out again, and a long clip does not make a heavy page."""

import base64
import json
import zlib

import numpy as np
import pytest
from rigs import make_rig, random_rotations

from usd_tools.characters.bones import Bones
from usd_tools.characters.placement import upright
from usd_tools.comparison.options import SchemeChoice
from usd_tools.comparison.report import player_data as player
from usd_tools.comparison.report.scenes import flattened, scenes
from usd_tools.comparison.results import named
from usd_tools.comparison.trials import all_trials, measure
from usd_tools.learning.clips import training_clip
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations


def unpacked(text, n_frames):
    """Do what player.js does."""
    rows = np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype="<i2").reshape(-1, n_frames)
    return np.cumsum(rows, axis=1, dtype="<i2").T.reshape(n_frames, -1, 3)


@pytest.fixture
def compared(tmp_path):
    def make(**rest):
        stage = make_rig(tmp_path / "in.usda", codes=range(16), rotations=random_rotations(16, 3), **rest)
        clip = read_clip(find_animations(stage)[0])
        return named([(tmp_path / "in.usda", clip, training_clip(tmp_path / "in.usda", clip))])[0]

    return make


@pytest.fixture
def scene(compared):
    each = compared()
    wanted = all_trials(["in"], [0.3], [SchemeChoice.parse("linear"), SchemeChoice.parse("slerp")])
    return scenes([each], [measure(trial, each.take, "hyb") for trial in wanted if not trial.unseen])[0]


def test_packing_is_reversible():
    points = np.random.default_rng(0).integers(-32_000, 32_000, (7, 4, 3)).astype(float)
    np.testing.assert_array_equal(unpacked(player.packed(points), 7), points)


def test_points_are_those_of_the_scene(scene):
    data = player.player_data([scene], scene)
    clip = data["clips"][0]
    found = unpacked(clip["truth"], 16) * clip["unit"]
    truth = scene.points()
    middle = 0.5 * (truth.max(axis=(0, 1)) + truth.min(axis=(0, 1)))
    np.testing.assert_allclose(found, truth - middle, atol=clip["unit"])
    assert clip["lines"] == [[0, 1], [1, 2], [2, 3]]
    assert clip["rates"][0]["keys"] == [0, 4, 8, 11, 15]
    assert json.loads(json.dumps(data)) == data


def test_long_motion_is_thinned(scene, monkeypatch):
    monkeypatch.setattr(player, "BUDGET", scene.points().size)
    clip = player.player_data([scene], scene)["clips"][0]
    assert clip["frames"] == list(range(0, 16, 6))
    assert len(unpacked(clip["truth"], 3)) == len(clip["rates"][0]["schemes"][0]["errors"]) == 3


@pytest.mark.parametrize("axis", ["Y", "Z"])
def test_up_is_up(compared, axis):
    from pxr import UsdGeom

    each = compared()
    UsdGeom.SetStageUpAxis(each.clip.source.stage, axis)
    up = {"Y": [0.0, 1.0, 0.0], "Z": [0.0, 0.0, 1.0]}[axis]
    turn = upright(each.clip)
    np.testing.assert_allclose(np.array(up) @ turn, [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(turn), 1.0)


def test_handle_on_the_floor_has_no_bone(compared):
    joints = ["root", "root/hips", "root/hips/left", "root/hips/right"]
    from geomstats_anim import Skeleton

    skeleton = Skeleton(joints, [-1, 0, 1, 1], np.tile([0.0, 1.0, 0.0], (4, 1)), np.tile([0.0, 0.0, 0.0, 1.0], (4, 1)))
    assert Bones.of(skeleton).lines.tolist() == [[1, 2], [1, 3], [2, 4], [3, 5]]


def test_view_shows_the_widest_side():
    points = np.random.default_rng(0).normal(size=(100, 3)) * [0.1, 2.0, 1.0]
    plane = flattened(points)
    np.testing.assert_allclose(np.abs(plane[:, 0]), [0.0, 1.0, 0.0], atol=0.05)
    np.testing.assert_array_equal(plane[:, 1], [0.0, 0.0, 1.0])
