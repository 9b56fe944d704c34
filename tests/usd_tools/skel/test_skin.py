"""Skin moves as UsdSkel moves it: on every file there is, and where meshes name their own joints."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt
from real_files import SHARED, real_file
from rigs import JOINTS, SKELETON, make_rig, random_rotations
from test_lengths import FILES, with_missing_authored

from geomstats_anim.markers import joint_matrices
from usd_tools.console.errors import ToolError
from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.skin import skin_markers

METHOD = "primvars:skel:skinningMethod"


def skinned_by_usd(clip, codes):
    """Points of all meshes in the skeleton's space, shape=[F, P, 3], units of the file."""
    skeleton = clip.source.skeletons[0]
    cache, root = UsdSkel.Cache(), UsdSkel.Root.Find(skeleton)
    cache.Populate(root, Usd.TraverseInstanceProxies())
    query = cache.GetSkelQuery(UsdSkel.Skeleton(skeleton))
    frames = []
    for code in map(Usd.TimeCode, codes):
        meshes = [np.zeros((0, 3))]
        for binding in cache.ComputeSkelBindings(root, Usd.TraverseInstanceProxies()):
            for target in binding.GetSkinningTargets() if binding.GetSkeleton().GetPrim() == skeleton else ():
                if not target.HasJointInfluences():
                    continue
                points = UsdGeom.PointBased(target.GetPrim()).GetPointsAttr().Get(Usd.TimeCode.EarliestTime())
                if points and target.ComputeSkinnedPoints(query.ComputeSkinningTransforms(code), points, code):
                    meshes.append(np.array(points))
        frames.append(np.concatenate(meshes))
    return np.array(frames)


def assert_skin_is_usds(clip):
    animation = animation_of(clip)
    animation = animation.at_frames(np.unique(np.linspace(0, animation.n_frames - 1, 5).astype(int)))
    codes = animation.times * clip.codes_per_second
    expected = skinned_by_usd(clip, codes) * clip.world_scale
    markers = skin_markers(clip)
    if animation.world is not None:
        expected = np.einsum("fij,fpj->fpi", animation.world[..., :3], expected) + animation.world[:, None, :, 3]
    places = markers.places(joint_matrices(animation))
    np.testing.assert_allclose(places, expected, rtol=1e-4, atol=1e-4 * max(1e-3, np.abs(expected).max(initial=0.0)))
    return markers.n_markers


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
            methods = [prim.GetAttribute(METHOD).Get() for prim in stage.Traverse() if prim.HasAttribute(METHOD)]
            is_linear = set(methods) <= {"classicLinear"}
            if clip.is_animated and clip.source.skeletons and UsdSkel.Root.Find(source.skeletons[0]) and is_linear:
                n_compared += bool(assert_skin_is_usds(with_missing_authored(stage, clip)))
    assert n_compared > 8


def make_skinned(path, joints=None):
    """A rig and a mesh of two points, in a frame of its own; `joints` that it names itself."""
    stage = make_rig(path, codes=range(4), rotations=random_rotations(4, 3))
    mesh = UsdGeom.Mesh.Define(stage, "/Rig/Skin")
    mesh.CreatePointsAttr([(1, 2, 3), (-4, 5, 6)])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([SKELETON])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1, 1, 2] if joints is None else [1, 0, 0, 1])
    binding.CreateJointWeightsPrimvar(False, 2).Set([0.25, 0.75, 0.5, 0.5])
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d().SetTranslate((10, 0, 0)))
    if joints is not None:
        binding.CreateJointsAttr(Vt.TokenArray(joints))
    return stage


@pytest.mark.parametrize("joints", [None, [JOINTS[2], JOINTS[0]]])
def test_joints_of_a_mesh(tmp_path, joints):
    stage = make_skinned(tmp_path / "in.usda", joints)
    clip = read_clip(find_animations(stage)[0])
    assert assert_skin_is_usds(clip) == 2
    owners = [clip.skeleton.joints[owner] for owner in skin_markers(clip).owners]
    assert owners == ([JOINTS[1], JOINTS[1]] if joints is None else [JOINTS[2], JOINTS[2]])


def test_without_skin(tmp_path, refuse):
    stage = make_rig(tmp_path / "in.usda", codes=range(4), rotations=random_rotations(4, 3))
    assert skin_markers(read_clip(find_animations(stage)[0])).n_markers == 0
    sentence = refuse(
        "downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--tolerance", 1, "--measure", "skin"
    )
    assert sentence == "/Rig/Anim moves no skinned mesh, so --measure skin cannot be used; use --measure shell."
