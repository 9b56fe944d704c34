"""Files of strangers whose lengths are not those of a simple rig; distances are measured through UsdSkel alone."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel
from real_files import needs_shared, real_file

from usd_tools.skel.channels import CHANNELS

pytestmark = needs_shared

REST_MISSING = ("rest_scale_no_scales",)
WITHOUT_API = ("no_binding_api",)


def shown(path, is_bound=True, missing=()):
    """Skeleton of a stage, as viewers show it once what the file lacks is authored."""
    stage = Usd.Stage.Open(str(path))
    stage.SetEditTarget(stage.GetSessionLayer())
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
    if not is_bound:
        UsdSkel.BindingAPI.Apply(prim)
    skeleton = UsdSkel.Skeleton(prim)
    animation = UsdSkel.Cache().GetSkelQuery(skeleton).GetAnimQuery().GetPrim()
    if missing and not animation.GetAttribute("scales").HasAuthoredValue():
        rest = np.array(skeleton.GetRestTransformsAttr().Get())[:, :3, :3]
        kind = CHANNELS["scales"]
        animation.GetAttribute("scales").Set(kind.to_usd(np.linalg.norm(rest, axis=-1).astype(np.float16)))
    return stage, skeleton, UsdSkel.Animation(animation)


def places(stage, skeleton, codes):
    """Joints in the world, shape=[F, B, 3], centimetres."""
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    found = []
    for code in map(Usd.TimeCode, codes):
        joints = np.array(query.ComputeJointSkelTransforms(code)) @ np.array(
            skeleton.ComputeLocalToWorldTransform(code)
        )
        found.append(100.0 * UsdGeom.GetStageMetersPerUnit(stage) * joints[:, 3, :3])
    return np.array(found)


@pytest.mark.parametrize(
    ("name", "n_samples"),
    [
        ("joint_scale_100", 24),
        ("parent_scale_nonuniform", 24),
        ("parent_scale_pop_in", 24),
        ("rest_scale_no_scales", 24),
        ("no_binding_api", 24),
        ("channel_spans", 8),
    ],
)
@pytest.mark.parametrize("options", [["--tolerance", 1], ["--tolerance", 1, "--scheme", "slerp"]])
def test_a_tolerance_holds_for_every_joint(tmp_path, run, name, n_samples, options):
    source, sparse, back = real_file(f"strangers/{name}.usda"), tmp_path / "sparse.usda", tmp_path / "back.usda"
    code, _, err = run("downsample", source, "-o", sparse, *options)
    assert code == 0
    assert run("upsample", sparse, "-o", back, "--times", "source")[0] == 0
    how = {"is_bound": name not in WITHOUT_API, "missing": name in REST_MISSING}
    stage, skeleton, animation = shown(source, **how)
    codes = animation.GetRotationsAttr().GetTimeSamples()
    assert len(codes) == n_samples
    stage_sparse, _, animation_sparse = shown(sparse, **how)
    kept = animation_sparse.GetRotationsAttr().GetTimeSamples()
    assert stage_sparse
    assert set(kept) <= set(codes) and (len(kept) < n_samples or "slerp" in options)
    stage_back, skeleton_back, _ = shown(back, **how)
    distances = np.linalg.norm(places(stage_back, skeleton_back, codes) - places(stage, skeleton, codes), axis=-1)
    assert distances.max() <= 1.0 and (distances.max() > 0.1 or len(kept) == n_samples)
    assert ("SkelBindingAPI is not applied" in err) == (name in WITHOUT_API)


def test_samples_that_tell_nothing_become_a_default(tmp_path, run):
    source = real_file("strangers/channel_spans.usda")
    assert run("downsample", source, "-o", tmp_path / "out.usda", "--rate", 0.5)[0] == 0
    stage, _, animation = shown(tmp_path / "out.usda")
    assert stage and animation.GetTranslationsAttr().GetTimeSamples() == []
    assert np.array(animation.GetTranslationsAttr().Get()).tolist() == [[0, 100, 0], [0, 30, 0], [0, 25, 0]]
    kept = animation.GetRotationsAttr().GetTimeSamples()
    assert len(kept) == 4 and {5.0, 12.0} <= set(kept)


def test_missing_scales_come_from_the_rest_pose(tmp_path, run):
    source = real_file("strangers/rest_scale_no_scales.usda")
    assert run("upsample", source, "-o", tmp_path / "out.usda", "--factor", 2)[0] == 0
    stage, skeleton, animation = shown(tmp_path / "out.usda")
    assert np.array(animation.GetScalesAttr().Get()).tolist() == [[2, 2, 2], [1, 1, 1], [1, 1, 1]]
    hand = places(stage, skeleton, [5.0])[0, -1]
    np.testing.assert_allclose(hand, [29.2, 180.3, 51.8], atol=0.1)


@pytest.mark.parametrize("verb", ["upsample", "learn", "downsample", "inspect"])
def test_every_verb_says_that_viewers_ignore_a_binding(tmp_path, run, verb):
    options = {"upsample": ["--factor", 2], "learn": [], "downsample": ["--rate", 0.3], "inspect": []}[verb]
    out = [] if verb == "inspect" else ["-o", tmp_path / "out.usda"]
    code, _, err = run(verb, real_file("strangers/no_binding_api.usda"), *out, *options)
    assert code == 0
    assert err.count("SkelBindingAPI is not applied, so USD ignores it") == 1


def test_a_tolerance_needs_a_skeleton(tmp_path, run, refuse):
    stage = Usd.Stage.Open(str(real_file("strangers/no_binding_api.usda")))
    animation = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation))
    library = Usd.Stage.CreateNew(str(tmp_path / "library.usda"))
    copy = UsdSkel.Animation.Define(library, "/Anim").GetPrim()
    for attribute in animation.GetAuthoredAttributes():
        for code in attribute.GetTimeSamples() or [Usd.TimeCode.Default()]:
            copy.GetAttribute(attribute.GetName()).Set(attribute.Get(code), code)
    library.Save()
    sentence = refuse("downsample", tmp_path / "library.usda", "-o", tmp_path / "out.usda", "--tolerance", 1)
    assert sentence.startswith("/Anim has no skeleton, so --tolerance cannot be measured; ")
    assert run("downsample", tmp_path / "library.usda", "-o", tmp_path / "out.usda", "--rate", 0.5)[0] == 0
