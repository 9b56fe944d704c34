"""Motion for the player: what is packed comes out again, and a long clip does not make a heavy page."""

import json

import numpy as np
import pytest
from rigs import make_rig, random_rotations
from unpacking import unpacked

from geomstats_anim.markers import joint_matrices
from usd_tools.characters.bones import Bones
from usd_tools.characters.placement import placed, upright
from usd_tools.comparison.options import SchemeChoice
from usd_tools.comparison.report import player_data as player
from usd_tools.comparison.report.scenes import flattened, joined, scenes
from usd_tools.comparison.results import named
from usd_tools.comparison.trials import all_trials, measure
from usd_tools.learning.clips import training_clip
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations


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


def test_motions_are_those_of_the_scene(scene):
    data = player.player_data([scene], scene)
    clip = data["clips"][0]
    rate = clip["rates"][0]
    motions = {None: clip["truth"], **{each["word"]: each["motion"] for each in rate["schemes"]}}
    for word, motion in motions.items():
        found = joint_matrices(unpacked(clip["character"], motion, scene.original))
        animation = scene.original if word is None else joined(scene.rebuilt[word].stretches)
        expected = joint_matrices(placed(scene.compared.clip, animation))
        np.testing.assert_allclose(found, expected, atol=5e-4)
    assert list(clip["character"]["bodies"]) == ["bones"]
    assert scene.bones.lines.tolist() == [[0, 1], [1, 2], [2, 3]]
    assert rate["keys"] == [0, 4, 8, 11, 15]
    assert json.loads(json.dumps(data)) == data


def test_long_motion_is_thinned(scene, monkeypatch):
    monkeypatch.setattr(player, "BUDGET", 7 * scene.original.rotations[..., 0].size)
    clip = player.player_data([scene], scene)["clips"][0]
    assert clip["frames"] == list(range(0, 16, 6))
    assert len(clip["character"]["times"]) == len(clip["rates"][0]["schemes"][0]["errors"]) == 3
    found = unpacked(clip["character"], clip["truth"], scene.original.at_frames(slice(0, 16, 6)))
    np.testing.assert_allclose(found.rotations, scene.original.rotations[::6], atol=1e-4)


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
