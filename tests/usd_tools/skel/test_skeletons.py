"""Skeletons as they are written: children before parents, and several that one animation drives."""

import pytest
from pxr import Gf, UsdGeom, UsdSkel
from rigs import SKELETON, make_rig, random_rotations

from usd_tools.files.stages import open_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations


def clip_of(path):
    (source,) = find_animations(open_stage(path))
    return read_clip(source)


@pytest.mark.parametrize("joints", [["a", "a/b/c", "a/b"], ["a/b", "a/b/c", "a"], ["a/b/c", "a", "a/b"]])
def test_children_may_stand_before_their_parents(tmp_path, joints):
    make_rig(tmp_path / "in.usda", joints=joints, rotations=random_rotations(4, 3))
    clip = clip_of(tmp_path / "in.usda")
    skeleton = clip.skeleton
    names = [*skeleton.joints, None]
    parents = {joint: names[parent] for joint, parent in zip(skeleton.joints, skeleton.parents, strict=True)}
    assert parents == {"a": None, "a/b": "a", "a/b/c": "a/b"}
    assert [skeleton.joints[column] for column in clip.columns] == joints == list(clip.joints)


def test_all_skeletons_of_an_animation_stay_the_largest_first(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    for name, size in (("Aaa", 0.5), ("Large", 3.0), ("Zzz", 2.0)):
        prim = UsdSkel.Skeleton.Define(stage, f"/Rig/{name}").GetPrim()
        prim.GetReferences().AddInternalReference(SKELETON)
        UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(size))
    stage.GetRootLayer().Save()
    clip = clip_of(tmp_path / "in.usda")
    paths = [str(prim.GetPath()) for prim in clip.source.skeletons]
    assert paths[0] == "/Rig/Large" and sorted(paths) == [f"/Rig/{name}" for name in ("Aaa", "Large", "Skel", "Zzz")]
    assert clip.world_scale == pytest.approx(0.03)
