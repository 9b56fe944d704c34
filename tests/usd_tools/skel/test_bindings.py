"""Which animation drives which skeleton: inherited, overridden, blocked, inactive; instances, variants, libraries."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel
from rigs import ANIMATION, JOINTS, SKELETON, bits, make_rig, random_rotations, read, set_samples

from usd_tools.skel.find import chosen_variants

VERBS = {"upsample": ["--factor", 2], "downsample": ["--keys", 5], "learn": ["--rate", 0.5]}
SOME_SLOW = ["upsample", *(pytest.param(verb, marks=pytest.mark.slow) for verb in ("downsample", "learn"))]


def add_animation(stage, path, seed, n_samples=8):
    UsdSkel.Animation.Define(stage, path).CreateJointsAttr(JOINTS)
    set_samples(stage, "rotations", range(n_samples), random_rotations(n_samples, 3, seed), path)
    for name, value in (("translations", [(0, 10, 0)] * 3), ("scales", [(1, 1, 1)] * 3)):
        stage.GetPrimAtPath(path).GetAttribute(name).Set(value)


def bind(prim, targets):
    UsdSkel.BindingAPI.Apply(prim).CreateAnimationSourceRel().SetTargets(targets)


@pytest.fixture
def bound(tmp_path):
    """As in OpenUSD's own test of bindings, but with motion in every animation."""
    stage = make_rig(tmp_path / "in.usda", codes=range(8), rotations=random_rotations(8, 3), bind=False)
    root = stage.GetRootLayer()
    bind(stage.GetPrimAtPath("/Rig"), [ANIMATION])
    for seed, path in enumerate(("/Rig/Other", "/Rig/Asleep", "/Library/Wave"), 1):
        add_animation(stage, path, seed)
    stage.GetPrimAtPath("/Rig/Asleep").SetActive(False)
    for name in ("Override", "Block", "BoundToAsleep"):
        Sdf.CopySpec(root, SKELETON, root, f"/Rig/{name}")
    bind(stage.GetPrimAtPath("/Rig/Override"), ["/Rig/Other"])
    bind(stage.GetPrimAtPath("/Rig/Block"), [])
    bind(stage.GetPrimAtPath("/Rig/BoundToAsleep"), ["/Rig/Asleep"])
    Sdf.CopySpec(root, SKELETON, root, "/Unbound")
    stage.Save()
    return tmp_path / "in.usda"


def drives(path):
    """Animation of every skeleton, as OpenUSD resolves it."""
    stage = Usd.Stage.Open(str(path))
    cache, found = UsdSkel.Cache(), {}
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdSkel.Skeleton):
            query = cache.GetSkelQuery(UsdSkel.Skeleton(prim)).GetAnimQuery()
            found[str(prim.GetPath())] = str(query.GetPrim().GetPath()) if query else None
    return found


def test_inspect_tells_what_usd_resolves(bound, inspected):
    told = inspected(bound)
    expected = {
        SKELETON: ANIMATION,
        "/Rig/Override": "/Rig/Other",
        "/Rig/Block": None,
        "/Rig/BoundToAsleep": None,
        "/Unbound": None,
    }
    assert {skeleton["prim"]: skeleton["animation"] for skeleton in told["skeletons"]} == expected == drives(bound)
    assert [(each["prim"], each["skeletons"]) for each in told["animations"]] == [
        (ANIMATION, [SKELETON]),
        ("/Rig/Other", ["/Rig/Override"]),
        ("/Library/Wave", []),
    ]
    assert told["warnings"] == [
        "/Rig/BoundToAsleep has skel:animationSource /Rig/Asleep, but its target is not an animation on this stage."
    ]


@pytest.mark.parametrize("verb", SOME_SLOW)
@pytest.mark.parametrize("flat", [[], ["--flatten"]])
def test_every_animation_once_and_bindings_stay(tmp_path, bound, run, verb, flat):
    code, text, err = run(verb, bound, "-o", tmp_path / "out.usda", *VERBS[verb], *flat)
    assert (code, err) == (0, "")
    assert drives(tmp_path / "out.usda") == drives(bound)
    for path in (ANIMATION, "/Rig/Other", "/Library/Wave"):
        assert path in text
        codes, values = read(bound, prim=path)
        new_codes, new_values = read(tmp_path / "out.usda", prim=path)
        assert len(new_codes) == {"upsample": 15, "downsample": 5, "learn": 8}[verb]
        common = sorted(set(codes) & set(new_codes))
        assert len(common) == min(len(codes), len(new_codes))
        assert bits([new_values[new_codes.index(c)] for c in common]) == bits([values[codes.index(c)] for c in common])
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    summaries = {
        path for path in drives(bound) if stage.GetPrimAtPath(path).HasAttribute("userProperties:geodesicMetric")
    }
    assert summaries == {SKELETON, "/Rig/Override"}
    layer = Sdf.Layer.FindOrOpen(str(bound))
    assert layer.GetNumTimeSamplesForPath("/Rig/Asleep.rotations") == 8


@pytest.mark.parametrize("verb", SOME_SLOW)
def test_library_without_a_skeleton(tmp_path, run, verb):
    stage = Usd.Stage.CreateNew(str(tmp_path / "in.usda"))
    for seed, name in enumerate(("Walk", "Run")):
        add_animation(stage, f"/Library/{name}", seed)
    stage.Save()
    code, _, err = run(verb, tmp_path / "in.usda", "-o", tmp_path / "out.usda", *VERBS[verb], "--prim", "/Library/Run")
    assert (code, err) == (0, "")
    counts = [len(read(tmp_path / "out.usda", prim=f"/Library/{name}")[0]) for name in ("Walk", "Run")]
    assert counts == [8, {"upsample": 15, "downsample": 5, "learn": 8}[verb]]


@pytest.mark.parametrize("verb", SOME_SLOW)
def test_sparse_joints_in_an_order_of_their_own(tmp_path, run, verb):
    joints = [JOINTS[2], JOINTS[0]]
    make_rig(tmp_path / "in.usda", codes=range(8), rotations=random_rotations(8, 2), anim_joints=joints)
    code, _, err = run(verb, tmp_path / "in.usda", "-o", tmp_path / "out.usda", *VERBS[verb])
    assert (code, err) == (0, "")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton.Get(stage, SKELETON))
    assert list(query.GetAnimQuery().GetJointOrder()) == joints
    assert query.GetMapper().IsSparse() and not query.GetMapper().IsIdentity()
    shown = np.array(query.ComputeJointLocalTransforms(Usd.TimeCode(0)))
    np.testing.assert_allclose(shown[1], np.array(query.ComputeJointLocalTransforms(Usd.TimeCode(0), True))[1])
    assert set(joints) <= set(stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:joints").Get())


def test_variants_that_samples_come_from(tmp_path):
    """Chosen in the file itself, or where a reference of a variant leads; also of an instance."""
    make_rig(tmp_path / "walk.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    hero = stage.DefinePrim("/Hero")
    takes = hero.GetVariantSets().AddVariantSet("take")
    takes.AddVariant("walk")
    takes.SetVariantSelection("walk")
    with takes.GetVariantEditContext():
        hero.GetReferences().AddReference("./walk.usda")
    stage.DefinePrim("/Twin").GetReferences().AddInternalReference("/Hero")
    stage.GetPrimAtPath("/Twin").SetInstanceable(True)
    assert chosen_variants(stage.GetPrimAtPath("/Hero/Anim")) == ["{take=walk} of /Hero"]
    assert chosen_variants(stage.GetPrimAtPath("/Twin/Anim")) == ["{take=walk} of /Hero"]
    assert chosen_variants(make_rig(tmp_path / "plain.usda").GetPrimAtPath(ANIMATION)) == []
