"""Lengths are those of the world: every matrix against UsdSkel's own, on every file there is."""

from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdSkel
from real_files import SHARED, real_file
from rigs import ANIMATION, SKELETON, make_rig, random_rotations

from geomstats_anim.markers import joint_matrices
from usd_tools.console.errors import ToolError
from usd_tools.files.stages import open_stage
from usd_tools.skel.channels import CHANNELS
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

FILES = sorted(
    str(path.relative_to(SHARED))
    for path in SHARED.glob("**/*")
    if path.suffix in (".usd", ".usda", ".usdc", ".usdz") and "FAIL" not in path.name
)
MOST_FRAMES = 12


def in_usd(clip, codes):
    """Matrices of all joints in the world as UsdSkel computes them, for rows, in units of the file."""
    skeleton = UsdSkel.Skeleton(clip.source.skeletons[0])
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    order = [list(query.GetJointOrder()).index(joint) for joint in clip.skeleton.joints]
    found = []
    for code in codes:
        joints = np.array(query.ComputeJointSkelTransforms(Usd.TimeCode(code)))
        found.append(joints[order] @ np.array(skeleton.ComputeLocalToWorldTransform(Usd.TimeCode(code))))
    return np.array(found)


def assert_world_is_usds(clip):
    """Compare places of joints, and lengths along their axes, with UsdSkel's, centimetres."""
    animation = animation_of(clip)
    frames = np.unique(np.linspace(0, animation.n_frames - 1, MOST_FRAMES).astype(int))
    animation = animation.at_frames(frames)
    codes = animation.times * clip.codes_per_second
    expected = in_usd(clip, codes) * UsdGeom.GetStageMetersPerUnit(clip.source.stage)
    ours = joint_matrices(animation)
    size = max(1e-3, np.abs(expected[..., 3, :3]).max())
    # where the skeleton stands does not matter to lengths: compare between joints, and from joints to points near them
    points = np.concatenate([np.zeros((1, 3)), np.eye(3)]) * clip.world_scale
    in_file = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    places = np.einsum("fbij,pj->fbpi", ours[..., :3], points) + ours[..., None, :, 3]
    wanted = np.einsum("fbji,pj->fbpi", expected[..., :3, :3], in_file) + expected[..., None, 3, :3]
    places, wanted = (each.reshape(len(codes), -1, 3) for each in (places, wanted))
    for centre in range(0, places.shape[1], 4):
        lengths = [np.linalg.norm(each - each[:, centre, None], axis=-1) for each in (places, wanted)]
        np.testing.assert_allclose(*lengths, rtol=2e-5, atol=2e-5 * size)


def with_missing_authored(stage, clip):
    """The same stage, with what the clip adds to it authored: else UsdSkel shows the rest pose."""
    if clip.missing:
        stage.SetEditTarget(stage.GetSessionLayer())
        for name, values in clip.missing.items():
            kind = CHANNELS[name]
            clip.source.prim.GetAttribute(name).Set(kind.to_usd(values.astype(kind.dtype)))
    return clip


@pytest.mark.skipif(not FILES, reason=f"the real files are not there: {SHARED}")
def test_every_file():
    n_compared = 0
    for name in FILES:
        stage = open_stage(real_file(name))
        for source in find_animations(stage):
            try:
                clip = read_clip(source)
            except ToolError:  # broken on purpose
                continue
            joints = (source.skeletons and UsdSkel.Skeleton(source.skeletons[0]).GetJointsAttr().Get()) or []
            if (
                clip.is_animated
                and clip.joints
                and set(clip.joints) <= set(joints)
                and not clip.source.prim.IsInstanceProxy()
            ):
                assert_world_is_usds(with_missing_authored(stage, clip))
                n_compared += 1
    assert n_compared > 20


TWIST = [[0.0, 2.0, 0.0], [-1.0, 0.0, 0.5], [0.0, 0.0, -3.0]]


@pytest.mark.parametrize(
    "parent", ["nothing", "rigid", "uniform", "stretched", "mirrored", "animated", "zero at first"]
)
@pytest.mark.parametrize("scales", ["ones", "animated", None])
def test_ancestors_and_joints_of_every_kind(tmp_path, parent, scales):
    values = scales
    if scales == "animated":
        values = np.random.default_rng(0).uniform(-2.0, 3.0, (5, 3, 3)).astype(np.float16)
    stage = make_rig(tmp_path / "in.usda", codes=range(5), rotations=random_rotations(5, 3), scales=values)
    rest = [Gf.Matrix4d(scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale + 1, 0, 1, 2, 3, 1) for scale in (1, 2, 3)]
    UsdSkel.Skeleton.Get(stage, SKELETON).GetRestTransformsAttr().Set(rest)
    xform = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTransformOp()
    matrix = np.eye(4)
    linear = {
        "nothing": np.eye(3),
        "rigid": [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        "uniform": 7.0 * np.eye(3),
        "stretched": np.diag([1.0, 1.0, 10.0]),
        "mirrored": np.diag([-1.0, 1.0, 1.0]),
    }
    matrix[:3, :3] = linear.get(parent, TWIST)
    if parent in ("animated", "zero at first"):
        for code in range(5):
            growing = np.diag([1.0, 1.0, 1.0, 1.0])
            growing[:3, :3] = matrix[:3, :3] * (code if parent == "zero at first" else code + 0.5)
            xform.Set(Gf.Matrix4d(growing), code)
    else:
        xform.Set(Gf.Matrix4d(matrix))
    clip = read_clip(find_animations(stage)[0])
    is_rigid = parent in ("nothing", "rigid", "uniform", "mirrored")
    assert (animation_of(clip).world is None) == is_rigid
    assert_world_is_usds(with_missing_authored(stage, clip))


def test_missing_scales_are_those_of_the_rest_pose(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=range(5), rotations=random_rotations(5, 3), scales=None)
    rest = [Gf.Matrix4d(2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 0, 10, 0, 1)] * 3
    UsdSkel.Skeleton.Get(stage, SKELETON).GetRestTransformsAttr().Set(rest)
    stage.Save()
    assert run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)[0] == 0
    out = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert np.array(UsdSkel.Animation.Get(out, ANIMATION).GetScalesAttr().Get()).tolist() == [[2, 3, 4]] * 3


def test_a_rest_pose_of_rotations_has_no_scale(tmp_path):
    stage = make_rig(tmp_path / "in.usda", codes=range(3), rotations=random_rotations(3, 3), scales=None)
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 3), 50.0))
    UsdSkel.Skeleton.Get(stage, SKELETON).GetRestTransformsAttr().Set([turn] * 3)
    clip = read_clip(find_animations(stage)[0])
    assert (clip.rest_scales == 1.0).all() and animation_of(clip).scales is None
    assert replace(clip, rest_scales=2.0 * clip.rest_scales).keys(("rotations",), slice(0, 2)).scales is not None
