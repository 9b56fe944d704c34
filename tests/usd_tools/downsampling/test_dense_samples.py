"""The samples that sparse ones replace do not stay anywhere in OUT."""

import numpy as np
import pytest
from pxr import Sdf, Usd
from real_files import real_file
from rigs import ANIMATION, bits, make_rig, random_rotations, read

CODES = range(20)


def sampled(path, name="rotations"):
    """Number of samples of every attribute of a name in a layer."""
    layer = Sdf.Layer.FindOrOpen(str(path))
    found = {}

    def visit(spec_path):
        if spec_path.IsPropertyPath() and spec_path.name == name:
            count = layer.GetNumTimeSamplesForPath(spec_path)
            if count:
                found[str(spec_path)] = count

    layer.Traverse("/", visit)
    return found


def moved_below(path, arc, target="/_class_Anim"):
    """A rig whose animation takes all that it has from another prim of the layer."""
    stage = make_rig(path, codes=CODES, rotations=random_rotations(20, 3))
    layer = stage.GetRootLayer()
    Sdf.CopySpec(layer, ANIMATION, layer, target)
    if target.startswith("/_class"):
        layer.GetPrimAtPath(target).specifier = Sdf.SpecifierClass
    else:
        layer.GetPrimAtPath(target).specifier = Sdf.SpecifierOver
    spec = layer.GetPrimAtPath(ANIMATION)
    for attribute in list(spec.attributes):
        spec.RemoveProperty(attribute)
    prim = stage.GetPrimAtPath(ANIMATION)
    {
        "inherits": lambda: prim.GetInherits().AddInherit(target),
        "specializes": lambda: prim.GetSpecializes().AddSpecialize(target),
        "references": lambda: prim.GetReferences().AddInternalReference(target),
    }[arc]()
    layer.Save()
    return stage


@pytest.mark.parametrize("flat", [[], ["--flatten"]])
@pytest.mark.parametrize(
    ("arc", "target"),
    [("inherits", "/_class_Anim"), ("specializes", "/_class_Anim"), ("references", "/Hidden")],
)
def test_what_is_inherited_or_referenced(tmp_path, run, arc, target, flat):
    moved_below(tmp_path / "in.usda", arc, target)
    before = read(tmp_path / "in.usda")
    out = tmp_path / "out.usda"
    code, _, err = run("downsample", tmp_path / "in.usda", "-o", out, "--rate", ".3", *flat)
    assert code == 0, err
    assert sampled(out) == {f"{ANIMATION}.rotations": 6}
    assert sampled(out, "translations") == {f"{ANIMATION}.translations": 6}
    codes, values = read(out)
    assert bits(values) == bits([before[1][before[0].index(code)] for code in codes])


def test_what_another_animation_uses_stays(tmp_path, run):
    stage = moved_below(tmp_path / "in.usda", "inherits")
    layer = stage.GetRootLayer()
    Sdf.CopySpec(layer, ANIMATION, layer, "/Rig/Other")
    layer.Save()
    words = ["--rate", ".3", "-o", tmp_path / "out.usda"]
    assert run("downsample", tmp_path / "in.usda", *words, "--prim", ANIMATION)[0] == 0
    assert sampled(tmp_path / "out.usda") == {f"{ANIMATION}.rotations": 6, "/_class_Anim.rotations": 20}
    assert len(read(tmp_path / "out.usda", prim="/Rig/Other")[0]) == 20
    assert run("downsample", tmp_path / "in.usda", *words)[0] == 0
    assert sampled(tmp_path / "out.usda") == {f"{ANIMATION}.rotations": 6, "/Rig/Other.rotations": 6}


def varied(path):
    """A rig whose animation is in two variants; run is selected."""
    stage = make_rig(path, codes=CODES, rotations=random_rotations(20, 3))
    layer = stage.GetRootLayer()
    sets = stage.GetPrimAtPath("/Rig").GetVariantSets().AddVariantSet("take")
    for name in ("walk", "run"):
        sets.AddVariant(name)
    sets.SetVariantSelection("run")
    for name in ("walk", "run"):
        Sdf.CopySpec(layer, ANIMATION, layer, f"/Rig{{take={name}}}Anim")
    del layer.GetPrimAtPath("/Rig").nameChildren["Anim"]
    layer.Save()
    return stage


def test_inside_the_selected_variant(tmp_path, run):
    varied(tmp_path / "in.usda")
    code, _, err = run("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--rate", ".3")
    assert (code, err) == (0, "")
    assert sampled(tmp_path / "out.usda") == {
        "/Rig{take=run}Anim.rotations": 6,
        "/Rig{take=walk}Anim.rotations": 20,
    }
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    stage.SetEditTarget(stage.GetSessionLayer())
    stage.GetPrimAtPath("/Rig").GetVariantSet("take").SetVariantSelection("walk")
    attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute("rotations")
    assert attribute.GetTimeSamples() == list(map(float, CODES))
    assert not stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:joints")
    assert run("upsample", tmp_path / "out.usda", "-o", tmp_path / "back.usda", "--times", "source")[0] == 0
    np.testing.assert_array_equal(read(tmp_path / "back.usda")[0], CODES)


def test_samples_in_a_variant_and_outside_are_refused(tmp_path, refuse):
    stage = varied(tmp_path / "in.usda")
    layer = stage.GetRootLayer()
    over = Sdf.CreatePrimInLayer(layer, ANIMATION)
    Sdf.CopySpec(layer, "/Rig{take=run}Anim.translations", layer, f"{ANIMATION}.translations")
    assert over
    layer.Save()
    sentence = refuse("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--rate", ".3")
    assert sentence == (
        "/Rig/Anim: its samples are in /Rig/Anim, /Rig{take=run}Anim, so they cannot be replaced without changing "
        "other variants; add --flatten."
    )


def test_a_strangers_class(tmp_path, run):
    source = real_file("strangers/inherits_class.usda")
    assert run("downsample", source, "-o", tmp_path / "out.usda", "--tolerance", "1")[0] == 0
    kept = sampled(tmp_path / "out.usda")
    assert set(kept) == {"/Root/Anim.rotations"} and kept["/Root/Anim.rotations"] < 24
