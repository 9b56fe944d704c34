"""Composition: layers, instances, clips, packages; nothing is lost, and nothing else is changed."""

import zipfile

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel
from rigs import ANIMATION, SKELETON, bits, make_rig, random_rotations, read, set_samples

FORMATS = ["out.usda", "out.usdc", "out.usdz", "flat.usda", "flat.usdz"]


def upsample(run, source, out, *options):
    flat = ["--flatten"] if out.name.startswith("flat") else []
    code, _, err = run("upsample", source, "-o", out, "--factor", 2, "--alpha", 3, *flat, *options)
    assert code == 0, err
    return err


@pytest.mark.parametrize("name", FORMATS)
def test_everything_else_stays(tmp_path, run, name):
    stage = make_rig(tmp_path / "in.usda", rate=30)
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(3)
    stage.SetMetadata("customLayerData", {"studio": "X"})
    stage.GetPrimAtPath(ANIMATION).SetDisplayName("walk")
    cube = UsdGeom.Cube.Define(stage, "/Rig/Cube")
    cube.CreateSizeAttr().Set(2.0, 1.0)
    cube.CreateSizeAttr().Set(3.0, 2.0)
    stage.Save()
    upsample(run, tmp_path / "in.usda", tmp_path / name)
    new = Usd.Stage.Open(str(tmp_path / name))
    for key in ("timeCodesPerSecond", "startTimeCode", "endTimeCode", "upAxis", "metersPerUnit", "defaultPrim"):
        assert new.GetMetadata(key) == stage.GetMetadata(key)
    assert not new.GetRootLayer().HasFramesPerSecond()
    data = new.GetRootLayer().customLayerData
    assert data["studio"] == "X"
    assert (data["geomstats_anim"]["tool"], data["geomstats_anim"]["settings"]["factor"]) == ("usd_tools.upsample", 2)
    assert new.GetPrimAtPath("/Rig/Cube").GetAttribute("size").GetTimeSamples() == [1, 2]
    assert new.GetPrimAtPath(ANIMATION).GetDisplayName() == "walk"
    assert new.GetCompositionErrors() == []


def test_all_formats_hold_the_same(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    for name in FORMATS:
        upsample(run, tmp_path / "in.usda", tmp_path / name)
    first = [bits(read(tmp_path / FORMATS[0], channel)[1]) for channel in ("rotations", "translations")]
    for name in FORMATS[1:]:
        assert [bits(read(tmp_path / name, channel)[1]) for channel in ("rotations", "translations")] == first


def test_override_layer_is_small_and_relative(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    (tmp_path / "out").mkdir()
    upsample(run, tmp_path / "in.usda", tmp_path / "out" / "out.usda")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "out" / "out.usda"))
    assert list(layer.subLayerPaths) == ["../in.usda"]
    assert layer.GetPrimAtPath(ANIMATION).specifier == Sdf.SpecifierOver
    assert set(layer.GetPrimAtPath(ANIMATION).attributes.keys()) >= {"rotations", "translations"}
    assert "scales" not in layer.GetPrimAtPath(ANIMATION).attributes
    # Works from another folder, once both are moved.
    (tmp_path / "else").mkdir()
    (tmp_path / "out").rename(tmp_path / "else" / "out")
    (tmp_path / "in.usda").rename(tmp_path / "else" / "in.usda")
    assert len(read(tmp_path / "else" / "out" / "out.usda")[0]) == 7


def test_flattened_is_self_contained(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    upsample(run, tmp_path / "in.usda", tmp_path / "flat.usda")
    (tmp_path / "in.usda").unlink()
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "flat.usda"))
    assert not layer.subLayerPaths and not layer.GetExternalReferences() and not layer.documentation
    assert UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton.Get(Usd.Stage.Open(layer), SKELETON)).GetAnimQuery()


def test_assets_of_a_flattened_file_are_relative(tmp_path, run):
    (tmp_path / "textures").mkdir()
    (tmp_path / "textures" / "skin.png").write_bytes(b"png")
    stage = make_rig(tmp_path / "in.usda")
    stage.GetPrimAtPath("/Rig").CreateAttribute("map", Sdf.ValueTypeNames.Asset).Set("textures/skin.png")
    stage.Save()
    (tmp_path / "sub").mkdir()
    upsample(run, tmp_path / "in.usda", tmp_path / "sub" / "flat.usda")
    flat = Usd.Stage.Open(str(tmp_path / "sub" / "flat.usda"))
    assert flat.GetPrimAtPath("/Rig").GetAttribute("map").Get().path == "../textures/skin.png"
    upsample(run, tmp_path / "in.usda", tmp_path / "out.usdz")
    assert "skin.png" in " ".join(zipfile.ZipFile(tmp_path / "out.usdz").namelist())


def test_usdz_from_usdz_is_one_package(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    upsample(run, tmp_path / "in.usda", tmp_path / "one.usdz")
    upsample(run, tmp_path / "one.usdz", tmp_path / "two.usdz")
    names = zipfile.ZipFile(tmp_path / "two.usdz").namelist()
    assert not any(name.endswith(".usdz") for name in names)
    assert len(read(tmp_path / "two.usdz")[0]) == 13
    zipped = zipfile.ZipFile(tmp_path / "two.usdz")
    assert zipped.testzip() is None
    assert all(info.compress_type == zipfile.ZIP_STORED for info in zipped.infolist())
    upsample(run, tmp_path / "one.usdz", tmp_path / "over.usda")
    assert len(read(tmp_path / "over.usda")[0]) == 13


@pytest.mark.parametrize("usd_format", ["usda", "usdc"])
def test_usd_format(tmp_path, run, usd_format):
    make_rig(tmp_path / "in.usda")
    upsample(run, tmp_path / "in.usda", tmp_path / "out.usd", "--usdFormat", usd_format)
    starts = {"usda": b"#usda 1.0", "usdc": b"PXR-USDC"}
    assert (tmp_path / "out.usd").read_bytes().startswith(starts[usd_format])
    upsample(run, tmp_path / "out.usd", tmp_path / "out.usd", "--in-place")
    assert (tmp_path / "out.usd").read_bytes().startswith(starts[usd_format])
    assert len(read(tmp_path / "out.usd")[0]) == 13


@pytest.mark.parametrize("name", ["in.usda", "in.usdc"])
def test_in_place_is_what_the_flattened_override_is(tmp_path, run, name):
    make_rig(tmp_path / name)
    source = read(tmp_path / name)
    upsample(run, tmp_path / name, tmp_path / "flat.usda")
    upsample(run, tmp_path / name, tmp_path / name, "--in-place")
    codes, values = read(tmp_path / name)
    assert bits(values) == bits(read(tmp_path / "flat.usda")[1])
    assert bits(values[::2]) == bits(source[1])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted({name, "flat.usda"})


def test_through_references_with_offsets(tmp_path, run):
    make_rig(tmp_path / "asset.usda", rate=30)
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    stage.SetTimeCodesPerSecond(24)
    prim = stage.DefinePrim("/Shot/Hero")
    prim.GetReferences().AddReference("./asset.usda", Sdf.Path("/Rig"), Sdf.LayerOffset(1001.0, 0.7))
    stage.Save()
    upsample(run, tmp_path / "shot.usda", tmp_path / "out.usda")
    codes, values = read(tmp_path / "out.usda", prim="/Shot/Hero/Anim")
    expected = 1001.0 + 0.7 * 24 / 30 * np.arange(7) / 2
    np.testing.assert_allclose(codes, expected, rtol=1e-12)
    assert bits(values[::2]) == bits(read(tmp_path / "asset.usda")[1])


@pytest.mark.parametrize("scale", [0.1, 1 / 3, 0.7, 1.7, 24 / 23.976])
def test_offsets_never_blur_samples(tmp_path, run, scale):
    make_rig(tmp_path / "asset.usda", codes=np.arange(50) * 1.001, rotations=random_rotations(50, 3))
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    prim = stage.DefinePrim("/Rig")
    prim.GetReferences().AddReference("./asset.usda", Sdf.Path("/Rig"), Sdf.LayerOffset(0.123, scale))
    stage.Save()
    upsample(run, tmp_path / "shot.usda", tmp_path / "out.usdc")
    assert bits(read(tmp_path / "out.usdc")[1][::2]) == bits(read(tmp_path / "asset.usda")[1])


def test_payloads_variants_and_sublayers(tmp_path, run):
    make_rig(tmp_path / "asset.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "weak.usda"))
    stage.DefinePrim("/Hero").GetPayloads().AddPayload("./asset.usda")
    variants = stage.GetPrimAtPath("/Hero").GetVariantSets().AddVariantSet("take")
    for take in ("one", "two"):
        variants.AddVariant(take)
        variants.SetVariantSelection(take)
        with variants.GetVariantEditContext():
            set_samples(stage, "rotations", (0, 4), random_rotations(2, 3, seed=len(take) + ord(take[0])), "/Hero/Anim")
    stage.Save()
    shot = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    shot.GetRootLayer().subLayerPaths.append("./weak.usda")
    shot.Save()
    upsample(run, tmp_path / "shot.usda", tmp_path / "out.usda")
    codes, values = read(tmp_path / "out.usda", prim="/Hero/Anim")
    # Rotations of the variant have two samples; translations of the payload have four.
    assert codes == [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4]
    assert bits([values[0], values[-1]]) == bits(list(random_rotations(2, 3, seed=3 + ord("t"))))
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert stage.GetPrimAtPath("/Hero").GetVariantSet("take").GetVariantSelection() == "two"


def make_instances(path, arc):
    """Two instances of a rig in the same file (arc "local") or of another one (arc "asset")."""
    stage = Usd.Stage.CreateNew(str(path))
    if arc == "local":
        source = Sdf.Layer.FindOrOpen(str(path.parent / "asset.usda"))
        stage.CreateClassPrim("/_class")
        Sdf.CopySpec(source, "/Rig", stage.GetRootLayer(), "/_class/Rig")
        stage.GetPrimAtPath("/_class/Rig/Skel").GetRelationship("skel:animationSource").SetTargets(["/_class/Rig/Anim"])
    for name in ("A", "B"):
        prim = stage.DefinePrim(f"/World/{name}")
        if arc == "local":
            prim.GetReferences().AddInternalReference("/_class/Rig")
        else:
            prim.GetReferences().AddReference("./asset.usda", "/Rig")
        prim.SetInstanceable(True)
    stage.Save()


@pytest.mark.parametrize("arc", ["local", "asset"])
def test_instances(tmp_path, run, arc):
    make_rig(tmp_path / "asset.usda")
    make_instances(tmp_path / "in.usda", arc)
    err = upsample(run, tmp_path / "in.usda", tmp_path / "out.usda")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    source = read(tmp_path / "asset.usda")[1]
    for name in ("A", "B"):
        skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath(f"/World/{name}/Skel"))
        animation = UsdSkel.Cache().GetSkelQuery(skeleton).GetAnimQuery().GetPrim()
        attribute = animation.GetAttribute("rotations")
        assert bits([np.array(attribute.Get(code)) for code in attribute.GetTimeSamples()[::2]]) == bits(source)
        assert stage.GetPrimAtPath(f"/World/{name}").IsInstance() == (arc == "local")
    assert err.count("is no longer an instance") == (0 if arc == "local" else 2)


@pytest.mark.parametrize("verb", ["upsample", "downsample"])
def test_instances_through_an_offset_keep_their_times(tmp_path, run, verb):
    """What the instances are made of is at other times than they are, so that it cannot be changed for them."""
    make_rig(tmp_path / "asset.usda", codes=range(6), rotations=random_rotations(6, 3))
    make_instances(tmp_path / "in.usda", "local")
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    for name in ("A", "B"):
        references = stage.GetPrimAtPath(f"/World/{name}").GetReferences()
        references.SetReferences([Sdf.Reference("", "/_class/Rig", Sdf.LayerOffset(10.0, 0.5))])
    stage.Save()
    options = ["--factor", 2] if verb == "upsample" else ["--keys", 4]
    assert run(verb, tmp_path / "in.usda", "-o", tmp_path / "out.usda", *options)[0] == 0
    codes, values = read(tmp_path / "out.usda", prim="/World/A/Anim")
    source = {10.0 + 0.5 * k: value for k, value in enumerate(random_rotations(6, 3))}
    kept = [code for code in codes if code in source]
    assert len(kept) == {"upsample": 6, "downsample": 4}[verb]
    assert bits([values[codes.index(code)] for code in kept]) == bits([source[code] for code in kept])
    assert read(tmp_path / "out.usda", prim="/World/B/Anim")[0] == codes


def test_instances_that_take_their_animation_from_outside(tmp_path, run):
    stage = make_rig(tmp_path / "asset.usda", bind=False)
    UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/Rig")).CreateAnimationSourceRel().SetTargets([ANIMATION])
    stage.Save()
    make_instances(tmp_path / "in.usda", "asset")
    assert upsample(run, tmp_path / "in.usda", tmp_path / "out.usda") == ""
    new = Usd.Stage.Open(str(tmp_path / "out.usda"))
    for name in ("A", "B"):
        assert new.GetPrimAtPath(f"/World/{name}").IsInstance()
        query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(new.GetPrimAtPath(f"/World/{name}/Skel"))).GetAnimQuery()
        assert query.GetPrim().GetPath() == "/World/A_Anim"
        assert list(query.GetJointOrder()) == list(new.GetPrimAtPath("/World/A/Anim").GetAttribute("joints").Get())
        assert len(query.ComputeJointLocalTransforms(Usd.TimeCode(0.5))) == 3
    codes, values = read(tmp_path / "out.usda", prim="/World/A_Anim")
    assert bits(values[::2]) == bits(read(tmp_path / "asset.usda")[1])
    assert not new.GetCompositionErrors()


def test_one_animation_drives_two_skeletons(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    Sdf.CopySpec(stage.GetRootLayer(), SKELETON, stage.GetRootLayer(), "/Rig/Twin")
    stage.Save()
    assert upsample(run, tmp_path / "in.usda", tmp_path / "out.usda") == ""
    new = Usd.Stage.Open(str(tmp_path / "out.usda"))
    for path in (SKELETON, "/Rig/Twin"):
        summary = new.GetPrimAtPath(path).GetAttribute("userProperties:geodesicMetricSummary").Get()
        assert summary.startswith("geodesic-spline, 3 joints")
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig/Twin")).AddScaleOp().Set(Gf.Vec3f(2.0))
    stage.Save()
    err = upsample(run, tmp_path / "in.usda", tmp_path / "out2.usda")
    note = f"{ANIMATION} drives skeletons of different sizes; lengths are measured on the largest, /Rig/Twin."
    assert err == f"warning: {note}\n"


def test_inherited_animation_source(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", bind=False)
    UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/Rig")).CreateAnimationSourceRel().SetTargets([ANIMATION])
    stage.Save()
    upsample(run, tmp_path / "in.usda", tmp_path / "out.usda")
    new = Usd.Stage.Open(str(tmp_path / "out.usda"))
    assert new.GetPrimAtPath(SKELETON).HasAttribute("userProperties:geodesicMetric")


def test_value_clips(tmp_path, run):
    for name, start in (("one", 0), ("two", 4)):
        clip = Usd.Stage.CreateNew(str(tmp_path / f"{name}.usda"))
        UsdSkel.Animation.Define(clip, ANIMATION).CreateRotationsAttr()
        set_samples(clip, "rotations", range(start, start + 4), random_rotations(8, 3)[start : start + 4])
        clip.Save()
    stage = make_rig(tmp_path / "in.usda", codes=(), rotations=[], translations=None)
    stage.GetPrimAtPath(ANIMATION).GetAttribute("translations").Set([(0, 1, 0)] * 3)
    manifest = Usd.Stage.CreateNew(str(tmp_path / "manifest.usda"))
    UsdSkel.Animation.Define(manifest, ANIMATION).CreateRotationsAttr()
    manifest.Save()
    clips = Usd.ClipsAPI(stage.GetPrimAtPath(ANIMATION))
    clips.SetClipPrimPath(ANIMATION)
    clips.SetClipAssetPaths(["./one.usda", "./two.usda"])
    clips.SetClipManifestAssetPath("./manifest.usda")
    clips.SetClipActive([(0, 0), (4, 1)])
    clips.SetClipTimes([(0, 0), (8, 8)])
    stage.Save()
    for name in ("out.usda", "flat.usda"):
        err = upsample(run, tmp_path / "in.usda", tmp_path / name)
        clips = "rotations come from value clips; the samples in the output override them."
        assert err == f"warning: {ANIMATION}: {clips}\n"
        codes, values = read(tmp_path / name)
        assert bits([values[codes.index(k)] for k in range(8)]) == bits(list(random_rotations(8, 3)))
        assert len(codes) >= 15


def test_a_half_made_file_is_never_left(tmp_path, run, monkeypatch):
    make_rig(tmp_path / "in.usda")
    (tmp_path / "out.usda").write_text("old")
    monkeypatch.setattr(
        "usd_tools.files.atomic.os.replace", lambda *paths: (_ for _ in ()).throw(OSError(28, "No space left"))
    )
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert (code, err) == (1, f"error: {tmp_path}/out.usda cannot be written: No space left.\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.usda", "out.usda"]
    assert (tmp_path / "out.usda").read_text() == "old"


def test_in_place_follows_links(tmp_path, run):
    make_rig(tmp_path / "real.usda")
    (tmp_path / "link.usda").symlink_to("real.usda")
    upsample(run, tmp_path / "link.usda", tmp_path / "link.usda", "--in-place")
    assert (tmp_path / "link.usda").is_symlink()
    assert len(read(tmp_path / "real.usda")[0]) == 7


def test_in_place_and_flattened(tmp_path, run):
    make_rig(tmp_path / "asset.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    stage.DefinePrim("/Hero").GetReferences().AddReference("./asset.usda", "/Rig")
    stage.Save()
    del stage
    err = upsample(run, tmp_path / "shot.usda", tmp_path / "shot.usda", "--in-place", "--flatten")
    assert err == ""
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "shot.usda"))
    layer.Reload()
    assert not layer.GetExternalReferences()
    assert layer.GetNumTimeSamplesForPath("/Hero/Anim.rotations") == 7
