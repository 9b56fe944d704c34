"""The example clips: sound USD, plausible and smooth motions."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import make_clips
import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel, UsdValidation
from scipy.spatial.transform import Rotation

from usd_tools.example_clips.biped import INDEX
from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.posing import GRAVITY, RATE

NAMES = ["pitching", "rolling", "punching", "jumping", "sitting"]
PLANTED = ["pitching", "punching", "jumping", "sitting"]
BALL_HEIGHT = 0.03


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The clips, written by the script as a user runs it, from a directory of no importance."""
    folder = tmp_path_factory.mktemp("clips")
    run = subprocess.run(
        [sys.executable, make_clips.__file__, "-o", str(folder)],
        cwd=folder.parent,
        capture_output=True,
        text=True,
        check=True,
    )
    assert [Path(line) for line in run.stdout.splitlines()] == [folder / f"{name}.usda" for name in NAMES]
    return folder


@pytest.fixture(scope="module")
def clips(folder):
    """Return what USD makes of the clips: the samples, and the joints in the world."""

    def read(name):
        stage = Usd.Stage.Open(str(folder / f"{name}.usda"))
        skeleton = UsdSkel.Skeleton.Get(stage, "/World/Biped/Skeleton")
        query = UsdSkel.Cache().GetSkelQuery(skeleton)
        times = query.GetAnimQuery().GetJointTransformTimeSamples()
        animation = UsdSkel.Animation.Get(stage, "/World/Biped/Animation")
        joints = np.array([query.ComputeJointSkelTransforms(time) for time in times])
        rotations = np.array([np.array(animation.GetRotationsAttr().Get(time)) for time in times], dtype=float)
        return SimpleNamespace(
            stage=stage,
            skeleton=skeleton,
            animation=animation,
            times=times,
            rotations=rotations,
            positions=joints[:, :, 3, :3],
            steps=_steps(rotations),
        )

    return {name: read(name) for name in NAMES}


@pytest.fixture(scope="module")
def baked(folder):
    """The skin's points as USD's own skinning moves them, every third sample."""
    points = {}
    for name in NAMES:
        stage = Usd.Stage.Open(Usd.Stage.Open(str(folder / f"{name}.usda")).Flatten())
        assert UsdSkel.BakeSkinning(Usd.PrimRange(stage.GetPseudoRoot()))
        attribute = UsdGeom.Mesh.Get(stage, "/World/Biped/Skin").GetPointsAttr()
        points[name] = np.array([attribute.Get(time) for time in attribute.GetTimeSamples()[::3]])
    return points


def _steps(rotations):
    """Rotation vectors (F - 1, B, 3) from each sample to the next, in the joint's own frame."""
    first, second = (Rotation.from_quat(quats.reshape(-1, 4)) for quats in (rotations[:-1], rotations[1:]))
    return (first.inv() * second).as_rotvec().reshape(len(rotations) - 1, -1, 3)


def _runs(mask):
    """Split a mask into the runs where it holds, as arrays of indices."""
    runs = np.split(np.arange(len(mask)), np.flatnonzero(np.diff(mask.astype(int))) + 1)
    return [run for run in runs if mask[run[0]]]


@pytest.mark.parametrize("name", NAMES)
def test_stage(clips, name):
    clip = clips[name]
    stage, count = clip.stage, len(clip.times)
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == RATE == 30
    assert 120 <= count <= 180
    assert clip.times == list(range(count))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, count - 1)
    assert len(clip.skeleton.GetJointsAttr().Get()) == 24
    assert clip.animation.GetJointsAttr().Get() == clip.skeleton.GetJointsAttr().Get()
    assert clip.animation.GetTranslationsAttr().GetTimeSamples() == clip.times
    assert clip.animation.GetRotationsAttr().GetTimeSamples() == clip.times
    assert len(clip.animation.GetScalesAttr().Get()) == 24


@pytest.mark.parametrize("name", NAMES)
def test_valid(clips, name):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(clips[name].stage)
    assert [error.GetMessage() for error in errors] == []


@pytest.mark.slow
def test_same_bytes_every_time(folder, tmp_path, capsys):
    assert make_clips.main(["-o", str(tmp_path), "--clips", "jumping", "rolling"]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "jumping.usda"), str(tmp_path / "rolling.usda")]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["jumping.usda", "rolling.usda"]
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes()


def test_unwritable_folder_is_one_sentence(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert make_clips.main(["-o", str(tmp_path / "file"), "--clips", "jumping"]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ") and captured.err.count("\n") == 1


@pytest.mark.parametrize("name", NAMES)
def test_smooth(clips, name):
    clip = clips[name]
    np.testing.assert_allclose(np.linalg.norm(clip.rotations, axis=-1), 1.0, atol=2e-5)
    assert np.all(np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=-1) > 0.0)
    assert np.degrees(np.linalg.norm(clip.steps, axis=-1).max()) < 60.0
    assert np.degrees(np.linalg.norm(np.diff(clip.steps, axis=0), axis=-1).max()) < 30.0
    speeds = np.diff(clip.positions[:, 0], axis=0) * RATE
    assert np.linalg.norm(np.diff(speeds, axis=0) * RATE, axis=-1).max() < 40.0


@pytest.mark.parametrize("name", NAMES)
def test_joints_turn_about_several_axes(clips, name):
    spreads = {}
    for joint in ("Hips", "Chest", "Head", "LeftUpperArm", "RightUpperArm", "LeftThigh", "RightThigh", "LeftHand"):
        singular = np.linalg.svd(clips[name].steps[:, INDEX[joint]], compute_uv=False)
        spreads[joint] = singular[1] / singular[0]
    assert min(spreads.values()) > 0.15, spreads
    assert np.median(list(spreads.values())) > 0.3, spreads


def test_rolling_turns_all_the_way_round(clips):
    turns = Rotation.from_quat(clips["rolling"].rotations[:, 0])
    bends = turns[:-1].apply(clips["rolling"].steps[:, 0])[:, 0]  # about x, the axis that rolls forwards
    assert bends.sum() == pytest.approx(4.0 * np.pi, rel=0.05)  # wobbling takes a little away
    travelled = clips["rolling"].positions[-1, 0, 2] - clips["rolling"].positions[0, 0, 2]
    assert 2.0 < travelled < 6.0


def test_jumping_falls_freely(clips):
    hips = clips["jumping"].positions[:, 0]
    balls = clips["jumping"].positions[:, [INDEX["LeftToes"], INDEX["RightToes"]], 1]
    (flight,) = _runs(balls.min(axis=1) > BALL_HEIGHT + 0.02)
    assert 0.4 < len(flight) / RATE < 0.7
    fits = np.polyfit(flight / RATE, hips[flight], 2)
    assert -2.0 * fits[0, 1] == pytest.approx(GRAVITY, rel=0.03)
    np.testing.assert_allclose(fits[0, [0, 2]], 0.0, atol=0.05)
    assert np.ptp(hips[:, 1]) > 0.6


@pytest.mark.parametrize("name", PLANTED)
def test_planted_feet_stay(clips, name):
    supported = np.zeros(len(clips[name].times), dtype=bool)
    for toes in (INDEX["LeftToes"], INDEX["RightToes"]):
        ball = clips[name].positions[:, toes]
        for run in _runs(ball[:, 1] < BALL_HEIGHT + 5e-4):
            supported[run] = True
            assert np.ptp(ball[run][:, [0, 2]], axis=0).max() < 0.01
    assert supported.mean() > (0.3 if name == "sitting" else 0.8)


@pytest.mark.parametrize("name", NAMES)
def test_on_the_ground(clips, baked, name):
    assert len(baked[name]) == len(clips[name].times[::3])
    skin = build_skin()
    feet = np.isin(skin.joints[:, 0], [INDEX[side + part] for side in ("Left", "Right") for part in ("Foot", "Toes")])
    assert baked[name][:, feet, 1].min() > -0.01
    lowest = baked[name][..., 1].min(axis=1)
    assert lowest.min() > -0.02
    if name not in ("jumping", "sitting"):
        assert lowest.max() < 0.04


@pytest.mark.parametrize("name", NAMES)
def test_extent_holds_the_skin(clips, baked, name):
    low, high = np.array(UsdSkel.Root.Get(clips[name].stage, "/World/Biped").GetExtentAttr().Get())
    assert np.all(baked[name] > low - 1e-3) and np.all(baked[name] < high + 1e-3)


def test_skin_is_closed_and_weighted(clips):
    stage = clips["pitching"].stage
    mesh = UsdGeom.Mesh.Get(stage, "/World/Biped/Skin")
    quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
    directed = np.concatenate([quads[:, [side, (side + 1) % 4]] for side in range(4)])
    assert len(np.unique(directed, axis=0)) == len(directed)  # every edge once each way: closed and oriented
    assert {tuple(edge) for edge in directed} == {tuple(edge) for edge in directed[:, ::-1]}
    points = np.array(mesh.GetPointsAttr().Get())
    corners = points[quads]
    volume = np.einsum("qi,qi->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    volume += np.einsum("qi,qi->", corners[:, 0], np.cross(corners[:, 2], corners[:, 3])) / 6.0
    assert 0.04 < volume < 0.1  # cubic metres, positive: facing outwards
    assert np.ptp(points[:, 1]) == pytest.approx(1.75, abs=0.03)

    query = UsdSkel.Cache()
    query.Populate(UsdSkel.Root.Get(stage, "/World/Biped"), Usd.PrimDefaultPredicate)
    skinning = query.GetSkinningQuery(mesh.GetPrim())
    joints, weights = (np.array(values) for values in skinning.ComputeVaryingJointInfluences(len(points)))
    influences = skinning.GetNumInfluencesPerComponent()
    assert joints.min() >= 0 and joints.max() < 24
    assert weights.min() >= 0.0
    np.testing.assert_allclose(weights.reshape(-1, influences).sum(axis=1), 1.0, atol=1e-6)
