"""BVH that is written: round trips, and what other rigs look like."""

import json

import numpy as np
import pytest
from bvh_files import write_bvh
from pxr import Gf, Usd, UsdGeom
from real_files import needs_shared, real_file
from rigs import ANIMATION, make_rig, random_rotations

from geomstats_anim import rotations as quat
from geomstats_anim.kinematics import world_pose
from usd_tools.bvh.reader import read_bvh
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.skeleton import world_matrices


def there_and_back(run, source, folder, *options):
    """Convert a BVH file to USD and back; give both as they are read."""
    assert run("from_bvh", source, "-o", folder / "there.usdc", *options)[0] == 0
    assert run("to_bvh", folder / "there.usdc", "-o", folder / "back.bvh")[0] == 0
    return read_bvh(source), read_bvh(folder / "back.bvh")


def check_same(first, second):
    assert second.channels == first.channels
    assert [name.split() for name in second.names] == [[name] for name in first.names]
    assert second.parents.tolist() == first.parents.tolist() and second.rate == pytest.approx(first.rate, rel=1e-9)
    assert quat.distance(second.rotations, first.rotations).max() < 1e-6
    size = np.abs(first.translations).max()
    np.testing.assert_allclose(second.translations, first.translations, atol=2e-7 * size)
    np.testing.assert_allclose(second.offsets, first.offsets, atol=2e-7 * size)


@pytest.mark.parametrize("options", [(), ("--scale", 0.056444), ("--fps", 29.97)])
def test_a_file_comes_back_with_its_channels(tmp_path, run, options):
    write_bvh(tmp_path / "in.bvh", n_frames=40)
    first, second = there_and_back(run, tmp_path / "in.bvh", tmp_path, *options)
    if "--fps" in options:
        first = read_bvh(tmp_path / "in.bvh", 30000 / 1001)
    check_same(first, second)


@needs_shared
@pytest.mark.parametrize("name", ["02_08.bvh", "131_03_bvh11.bvh", "animateddrawings_dab.bvh"])
def test_real_files_come_back_with_their_channels(tmp_path, run, name):
    first, second = there_and_back(run, real_file(f"bvh/{name}"), tmp_path)
    check_same(first, second)
    table = np.loadtxt((tmp_path / "back.bvh").read_text().partition("Frame Time:")[2].splitlines()[1:])
    is_angle = np.array([channel.endswith("rotation") for own in second.channels for channel in own])
    assert np.abs(np.diff(table[:, is_angle], axis=0)).max() < 180.0


def world_of(path):
    """Return the places of joints in the world, metres, shape=[F, 3] each, by the last names of joints."""
    stage = Usd.Stage.Open(str(path))
    clip = read_clip(find_animations(stage)[0])
    animation = animation_of(clip)
    pose = world_pose(animation)
    matrices = world_matrices(clip.source.rig[0], animation.times * clip.codes_per_second)
    sizes = np.cbrt(np.linalg.det(matrices[:, :3, :3]))[:, None, None]
    units = UsdGeom.GetStageMetersPerUnit(stage)
    points = pose.origins @ (matrices[:, :3, :3] / sizes) + matrices[:, 3:, :3] * units
    names = [joint.rsplit("/", 1)[-1] for joint in clip.skeleton.joints]
    return dict(zip(names, points.swapaxes(0, 1), strict=True))


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_rests_that_are_turned_and_characters_that_are_moved_come_to_the_same_places(tmp_path, run, up):
    stage = make_rig(tmp_path / "in.usda", range(12), random_rotations(12, 3), rate=30)
    rng = np.random.default_rng(3)
    rests = []
    for move in rng.uniform(-9.0, 9.0, (3, 3)).tolist():
        turn = Gf.Rotation(Gf.Vec3d(*rng.normal(size=3).tolist()), float(rng.uniform(20.0, 90.0)))
        rests.append(Gf.Matrix4d(turn, Gf.Vec3d(*move)))
    stage.GetPrimAtPath("/Rig/Skel").GetAttribute("restTransforms").Set(rests)
    move = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig"))
    translate, turn = move.AddTranslateOp(), move.AddRotateZOp()
    move.AddScaleOp().Set(Gf.Vec3f(2.0))
    for code in range(12):
        translate.Set(Gf.Vec3d(5 * code, 1, -code), code)
        turn.Set(7.0 * code, code)
    stage.Save()
    code, out, _ = run("to_bvh", tmp_path / "in.usda", "-o", tmp_path / "out.bvh", "--up", up, "--scale", 0.01)
    assert code == 0 and "one unit is 0.01 metres" in out
    run("from_bvh", tmp_path / "out.bvh", "-o", tmp_path / "back.usda", "--up", up)
    before, after = world_of(tmp_path / "in.usda"), world_of(tmp_path / "back.usda")
    assert set(before) == set(after) == {"hips", "spine", "arm"}
    for name, points in before.items():
        if up == "Y":  # the stage's z points up
            points = np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)
        np.testing.assert_allclose(after[name], points, atol=1e-6)


def test_what_bvh_cannot_hold_is_refused_or_named(tmp_path, run, refuse):
    out = tmp_path / "out.bvh"
    make_rig(tmp_path / "uneven.usda", (0, 1, 2, 4), random_rotations(4, 3))
    assert refuse("to_bvh", tmp_path / "uneven.usda", "-o", out) == (
        f"{ANIMATION} is not evenly sampled, as BVH needs it; run usd_tools.resample --fps 24 first."
    )
    assert refuse("to_bvh", tmp_path / "uneven.usda", "-o", tmp_path / "x.usda").endswith("must end in .bvh.")
    stage = make_rig(tmp_path / "flat.usda")
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddScaleOp().Set(Gf.Vec3f(1, 1, -1))
    stage.Save()
    assert "mirrored, sheared or scaled unevenly" in refuse("to_bvh", tmp_path / "flat.usda", "-o", out)
    make_rig(tmp_path / "big.usda", scales=np.full((4, 3, 3), 2, dtype=np.float16))
    code, _, err = run("to_bvh", tmp_path / "big.usda", "-o", out)
    assert code == 0 and err == (
        f"warning: {ANIMATION} scales joints, which BVH cannot hold; the scales are left out.\n"
    )


def test_folders_and_reports(tmp_path, run):
    (tmp_path / "in").mkdir()
    make_rig(tmp_path / "in/a.usda")
    make_rig(tmp_path / "in/b.usdc")
    code, out, _ = run("to_bvh", tmp_path / "in", "-o", tmp_path / "out", "--report", tmp_path / "report.json")
    assert code == 0 and out.splitlines()[0] == "a.usda: 3 joints, 4 frames"
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["a.bvh", "b.bvh"]
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["files"][1]["report"]["rate"] == 24.0
