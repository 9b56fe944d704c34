"""Characters on pages: the body that comes out of the packed data, in Python and in a browser, is where it was."""

from dataclasses import replace

import numpy as np
import pytest
from chromium import opened
from real_files import real_file
from rigs import make_rig, random_rotations
from unpacking import decoded, skinned, unpacked

from geomstats_anim.markers import joint_matrices
from usd_tools.characters.body import body_of
from usd_tools.characters.placement import placed
from usd_tools.files.stages import open_stage
from usd_tools.player.characters import BONES, SKIN, Character
from usd_tools.player.scripts import read_scripts, script_json
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations


def clip_and_motion(stage):
    clip = read_clip(find_animations(stage)[0])
    names = [name for name, channel in clip.channels.items() if channel.is_animated]
    return clip, next(clip.stretches(names)).keys


@pytest.fixture
def rig(tmp_path):
    return clip_and_motion(make_rig(tmp_path / "in.usda", codes=range(12), rotations=random_rotations(12, 3)))


def expected_points(clip, animation, frame, as_bones=True):
    matrices = joint_matrices(placed(clip, animation))[frame]
    return body_of(clip, animation, as_bones).joined().points(matrices)[0]


@pytest.mark.parametrize("frame", [0, 7])
def test_the_page_skins_as_we_do(rig, frame):
    clip, animation = rig
    character = Character.of(clip, animation, [])
    data = character.as_dict()
    matrices = joint_matrices(unpacked(data, character.motion(animation), animation))
    found = skinned(data["bodies"][BONES], matrices[frame])
    np.testing.assert_allclose(found, expected_points(clip, animation, frame), atol=3e-4)
    faces = decoded(data["bodies"][BONES]["faces"], "<u4")
    assert faces.max() < len(found) and len(faces) % 3 == 0

    (low, high), (_, top) = np.array(data["box"]), np.array(data["standing"])
    every = np.concatenate([expected_points(clip, animation, f) for f in range(12)])
    np.testing.assert_allclose([low, high], [every.min(axis=0), every.max(axis=0)], atol=1e-9)
    assert (top <= high + 1e-12).all() and data["up"] == "z"


def test_scales_and_the_place_in_the_world_are_kept(rig):
    clip, animation = rig
    rng = np.random.default_rng(3)
    scaled = replace(animation, scales=rng.uniform(0.5, 2.0, (12, animation.n_joints, 3)))
    character = Character.of(clip, scaled, [])
    found = joint_matrices(unpacked(character.as_dict(), character.motion(scaled), scaled))
    np.testing.assert_allclose(found, joint_matrices(placed(clip, scaled)), atol=5e-3)


def test_motions_far_from_the_original_are_not_cut_off(rig):
    clip, animation = rig
    far = replace(animation, translations=animation.translations + [40.0, 0.0, 0.0])
    character = Character.of(clip, animation, [far])
    data = character.as_dict()
    for motion in (animation, far):
        found = unpacked(data, character.motion(motion), motion)
        np.testing.assert_allclose(found.translations, motion.translations, atol=1e-3)


def test_a_skin_and_its_colours_are_there():
    clip, animation = clip_and_motion(open_stage(real_file("usd/mayausd_HIK_Export.usda")))
    character = Character.of(clip, animation, [])
    data = character.as_dict()
    assert list(data["bodies"]) == [SKIN, BONES] and data["up"] == "z"
    body = data["bodies"][SKIN]
    matrices = joint_matrices(unpacked(data, character.motion(animation), animation))[50]
    found = skinned(body, matrices)
    np.testing.assert_allclose(found, expected_points(clip, animation, 50, as_bones=False), atol=1e-3)
    assert sum(count for *_, count in body["colors"]) == len(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["usd/mayausd_HIK_Export.usda", "usd/usdwg_CesiumMan.usdz", "clips/pitching.usda"])
def test_the_browser_poses_and_skins_as_we_do(name, tmp_path):
    clip, animation = clip_and_motion(open_stage(real_file(name)))
    character = Character.of(clip, animation, [])
    data = character.as_dict()
    scripts = "".join(f"<script>{script}</script>" for script in read_scripts())
    given = script_json([data, character.motion(animation)])
    (tmp_path / "page.html").write_text(
        f'<!DOCTYPE html><script type="application/json" id="data">{given}</script>{scripts}', encoding="utf-8"
    )
    with opened((tmp_path / "page.html").as_uri()) as (tab, problems):
        found = tab.evaluate(
            "async () => { const [given, motion] = JSON.parse(document.getElementById('data').textContent);"
            "const made = await Character.of(given), rows = await made.motion(motion), at = made.matrices(rows, 30);"
            "return Object.values(made.bodies).map((body) => Array.from(body.places(at))) }"
        )
        assert problems == []
    matrices = joint_matrices(unpacked(data, character.motion(animation), animation))[30]
    for places, body in zip(found, data["bodies"].values(), strict=True):
        np.testing.assert_allclose(np.reshape(places, (-1, 3)), skinned(body, matrices), atol=2e-5)
