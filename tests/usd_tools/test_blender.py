"""What Blender shows is what we read and write: BVH by its own importer, and USD there and back."""

import json
from dataclasses import replace

import numpy as np
import pytest
from blender import blender
from bvh_files import CHAIN, write_bvh
from pxr import Usd
from real_files import SHARED
from rigs import JOINTS, make_rig, some_metric
from scipy.spatial.transform import Rotation

from geomstats_anim import rotations as quat
from usd_tools.bvh.reader import read_bvh
from usd_tools.metrics.attributes import NAMESPACE, read_metric
from usd_tools.metrics.strings import METRIC_JSON, SUMMARY
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.joint_names import read_names
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.stored_metric import stored_metric

pytestmark = pytest.mark.slow
BVH = sorted((SHARED / "bvh").glob("*.bvh"))
needs_data = pytest.mark.skipif(not BVH, reason=f"the real files are not there: {SHARED / 'bvh'}")


def quaternions(matrices):
    """Quaternions (F, B, 4) of matrices (F, B, 3, 3)."""
    return Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_quat().reshape(*matrices.shape[:2], 4)


def check_bvh(path, out):
    """We read a file as Blender does."""
    theirs, ours = blender("read_bvh.py", path, out), read_bvh(path)
    assert theirs["names"].tolist() == list(ours.names)
    assert theirs["parents"].tolist() == ours.parents.tolist()
    assert quat.distance(quaternions(theirs["rotations"]), ours.rotations).max() < 1e-5
    np.testing.assert_allclose(theirs["translations"], ours.translations, atol=1e-6 * np.abs(ours.translations).max())
    assert theirs["rate"] == pytest.approx(ours.rate, rel=2e-4)


@needs_data
@pytest.mark.parametrize("path", BVH, ids=[path.stem for path in BVH])
def test_real_bvh(tmp_path, path):
    check_bvh(path, tmp_path / "out.npz")


def test_bvh_with_positions_everywhere(tmp_path):
    write_bvh(tmp_path / "in.bvh", n_frames=20, text=CHAIN)
    check_bvh(tmp_path / "in.bvh", tmp_path / "out.npz")


def in_blender(tmp_path, path):
    """Return what Blender shows of a USD file at its samples, and what the file says."""
    stage = Usd.Stage.Open(str(path))
    (source,) = find_animations(stage)
    clip = read_clip(source)
    np.save(tmp_path / "frames.npy", clip.codes)
    return blender("read_usd.py", path, tmp_path / "shown.npz", tmp_path / "frames.npy"), clip


def check_shown(shown, clip):
    """Bones, rotations at all samples, times of the keys."""
    assert shown["names"].tolist() == [joint.split("/")[-1] for joint in clip.skeleton.joints]
    assert shown["parents"].tolist() == clip.skeleton.parents.tolist()
    assert quat.distance(quaternions(shown["rotations"]), animation_of(clip).rotations).max() < 1e-4
    np.testing.assert_allclose(shown["keys"], clip.codes, atol=1e-3)
    assert shown["scene"].tolist() == [np.floor(clip.codes[0]), np.ceil(clip.codes[-1])]


def check_metric_shown(shown, skeleton):
    """The metric and its summary are properties of the armature."""
    properties = json.loads(str(shown["properties"]))
    for name, attribute in ((NAMESPACE, METRIC_JSON), (f"{NAMESPACE}Summary", SUMMARY)):
        assert properties[name] == skeleton.GetAttribute(attribute).Get()


def turned_since_first(rotations, parents):
    """Return how each joint has turned in the world since the first frame, whatever its own axes are, (F, B, 3, 3)."""
    world = rotations.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            world[:, joint] = world[:, parent] @ rotations[:, joint]
    return world @ world[:1].transpose(0, 1, 3, 2)


@pytest.fixture(params=["made", pytest.param("animateddrawings_jumping_jacks", marks=needs_data)])
def bvh(request, tmp_path):
    """A BVH file, made here or real."""
    if request.param == "made":
        write_bvh(tmp_path / "made.bvh", n_frames=12, text=CHAIN)
        return tmp_path / "made.bvh"
    return SHARED / "bvh" / f"{request.param}.bvh"


def test_from_bvh_into_blender(tmp_path, run, bvh):
    assert run("from_bvh", bvh, "-o", tmp_path / "in.usda")[0] == 0
    shown, clip = in_blender(tmp_path, tmp_path / "in.usda")
    check_shown(shown, clip)


@pytest.mark.parametrize("retime", [[], ["--retime"]], ids=["same rate", "retimed"])
def test_bvh_to_blender_to_usd_to_upsample_to_blender(tmp_path, run, bvh, retime):
    frames, rate = len(read_bvh(bvh).rotations), read_bvh(bvh).rate
    exported = blender("bvh_to_usd.py", bvh, tmp_path / "exported.usda")
    assert run("learn", exported, "-o", tmp_path / "learned.usda", "--rate", 0.5)[0] == 0
    up = ["--fps", 4 * Usd.Stage.Open(str(exported)).GetTimeCodesPerSecond()]
    code, _, err = run("upsample", tmp_path / "learned.usda", "-o", tmp_path / "out.usda", *up, *retime)
    assert code == 0 and all(
        "a file cannot store which way a turn beyond 180 degrees went" in line for line in err.splitlines()
    ), err
    shown, clip = in_blender(tmp_path, tmp_path / "out.usda")
    check_shown(shown, clip)
    assert len(clip.codes) == 4 * (frames - 1) + 1
    # The user sets the scene to the file's rate, as upsample says; then the motion has its speed.
    seconds = np.ptp(shown["keys"]) / clip.codes_per_second
    assert seconds == pytest.approx((frames - 1) / rate, rel=2e-4)
    theirs = turned_since_first(shown["rotations"][::4], shown["parents"])
    ours = turned_since_first(quat.to_matrix(read_bvh(bvh).rotations), shown["parents"])
    upright = Rotation.from_euler("x", 90, degrees=True).as_matrix()  # Y is up in BVH, Z in Blender
    ours = upright @ ours @ upright.T
    assert quat.distance(quaternions(theirs), quaternions(ours)).max() < 1e-4
    (skeleton,) = clip.source.skeletons
    check_metric_shown(shown, skeleton)


def test_downsampled_to_blender_and_back(tmp_path, run, bvh):
    for verb in (
        ["from_bvh", bvh, "-o", tmp_path / "in.usda"],
        ["downsample", tmp_path / "in.usda", "-o", tmp_path / "sparse.usda", "--rate", 0.3],
        ["upsample", tmp_path / "sparse.usda", "-o", tmp_path / "back.usda", "--times", "source"],
    ):
        assert run(*verb)[0] == 0
    for name in ("sparse.usda", "back.usda"):
        shown, clip = in_blender(tmp_path, tmp_path / name)
        check_shown(shown, clip)
        (skeleton,) = clip.source.skeletons
        check_metric_shown(shown, skeleton)


@pytest.mark.parametrize("renamed", [False, True], ids=["same names", "renamed"])
def test_the_metric_is_found_after_a_round_trip(tmp_path, run, renamed):
    joints = ["hips", "hips/group/spine", "hips/group/spine/arm"] if renamed else JOINTS
    stage = make_rig(tmp_path / "in.usda", joints=joints)
    stage.SetStartTimeCode(0.0)
    stage.SetEndTimeCode(3.0)
    stage.Save()
    learned = some_metric(axes=True, joints=joints)
    (tmp_path / "metric.json").write_text(learned.to_json())
    styled = ["--factor", 2, "--metric", tmp_path / "metric.json"]
    assert run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", *styled)[0] == 0
    back = blender("round_trip.py", tmp_path / "out.usda", tmp_path / "back.usda")
    stage = Usd.Stage.Open(str(back))
    (source,) = find_animations(stage)
    assert read_metric(source.prim) is None
    names = read_names(source.prim, "joints")
    assert (list(names) == joints) != renamed
    assert stored_metric(source).to_json() == replace(learned, joints=names).to_json()
    code, out, err = run("upsample", back, "-o", tmp_path / "again.usda", "--factor", 2, "--metric", "stored")
    assert (code, err, "geodesic, stored metric" in out) == (0, "", True)
