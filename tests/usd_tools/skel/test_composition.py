"""A shot of references, payloads, variants and sublayers: all of it survives, from any folder, in the same bytes."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from composed import differences, errors_of, make_shot
from pxr import Sdf, Usd, UsdGeom, UsdUtils
from rigs import ANIMATION, bits, make_rig, random_rotations, read

from usd_tools import upsample

VERBS = {"upsample": ["--factor", 2, "--alpha", 3], "downsample": ["--keys", 5], "learn": ["--rate", 0.5]}
SOME_SLOW = ["upsample", *(pytest.param(verb, marks=pytest.mark.slow) for verb in ("downsample", "learn"))]
FORMATS = ["out.usda", "out.usdc", "out.usdz", "flat.usda", "flat.usdz"]


def call(run, verb, source, out):
    out.parent.mkdir(exist_ok=True)
    flat = ["--flatten"] if out.name.startswith("flat") else []
    code, _, err = run(verb, source, "-o", out, *VERBS[verb], *flat)
    variant = "/Shot/Hero/Anim is of the variant {take=two} of /Shot/Hero"
    hidden = f"warning: {variant}; the output overrides its other variants.\n"
    kept = (
        "warning: flattening keeps only the selected variants: take of /Shot/Hero at two.\n"
        if flat or verb == "downsample"
        else ""
    )
    assert (code, err) == (0, hidden + kept)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("verb", SOME_SLOW)
def test_everything_else_survives(tmp_path, run, verb, name):
    source, out = make_shot(tmp_path / "show"), tmp_path / "work" / name
    before = {path: path.read_bytes() for path in source.parent.rglob("*") if path.is_file()}
    call(run, verb, source, out)
    assert {path: path.read_bytes() for path in source.parent.rglob("*") if path.is_file()} == before
    found = differences(source, out, written=("rotations", "translations"))
    # flattening is for files that need no others: arcs are gone, assets of a package are in it
    is_flat = name.startswith("flat") or verb == "downsample"
    arcs = {"/Shot/Hero", "/Shot/Hero/Anim", "/Shot/Prop"} if is_flat else set()
    assert set(found) - arcs <= ({"/Shot/Hero.map"} if name.endswith(".usdz") else set())
    assert errors_of(out) <= errors_of(source)
    codes, values = read(source, prim="/Shot/Hero/Anim")
    new_codes, new_values = read(out, prim="/Shot/Hero/Anim")
    common = sorted(set(codes) & set(new_codes))
    assert len(common) == (5 if verb == "downsample" else 8)
    assert bits([new_values[new_codes.index(c)] for c in common]) == bits([values[codes.index(c)] for c in common])
    assert bits(values) == bits(list(random_rotations(8, 3, 8)))  # of the variant that is chosen


@pytest.mark.parametrize("verb", [SOME_SLOW[0], SOME_SLOW[2]])
def test_other_variants_and_arcs_can_still_be_chosen(tmp_path, run, verb):
    source, out = make_shot(tmp_path / "show"), tmp_path / "work" / "out.usda"
    call(run, verb, source, out)
    stage = Usd.Stage.Open(str(out))
    hero = stage.GetPrimAtPath("/Shot/Hero")
    assert hero.GetVariantSets().GetVariantSelection("take") == "two"
    assert hero.GetVariantSet("take").GetVariantNames() == ["one", "two"]
    assert stage.GetPrimAtPath("/Shot/Prop").HasAuthoredPayloads()
    stage.Unload("/Shot/Prop")
    assert not stage.GetPrimAtPath("/Shot/Prop").GetAttribute("size").HasAuthoredValue()
    assert list(Sdf.Layer.FindOrOpen(str(out)).subLayerPaths) == ["../show/shot.usda"]


@pytest.mark.parametrize("verb", SOME_SLOW)
def test_override_works_wherever_both_are_moved(tmp_path, run, verb):
    source, out = make_shot(tmp_path / "a" / "show"), tmp_path / "a" / "out.usdc"
    call(run, verb, source, out)
    expected = read(out, prim="/Shot/Hero/Anim")
    (tmp_path / "a").rename(tmp_path / "b")
    moved = tmp_path / "b" / "out.usdc"
    found = read(moved, prim="/Shot/Hero/Anim")
    assert (found[0], bits(found[1])) == (expected[0], bits(expected[1]))
    assert Usd.Stage.Open(str(moved)).GetCompositionErrors() == []
    assert str(tmp_path).encode() not in moved.read_bytes()


@pytest.mark.parametrize("name", ["flat.usda", "flat.usdz", "out.usdz"])
@pytest.mark.parametrize("verb", SOME_SLOW)
def test_self_contained(tmp_path, run, verb, name):
    source, out = make_shot(tmp_path / "show"), tmp_path / "work" / name
    call(run, verb, source, out)
    # what is flattened names textures where they are; what is packed has them
    shutil.rmtree(source.parent) if name.endswith(".usdz") else source.unlink()
    layers, assets, missing = UsdUtils.ComputeAllDependencies(str(out))
    assert missing == [] and len(assets) == 1
    if name.startswith("flat"):
        assert len(layers) == (1 if name.endswith(".usda") else len(layers))
        assert not Sdf.Layer.FindOrOpen(str(out)).GetExternalReferences()
    assert len(read(out, prim="/Shot/Hero/Anim")[0]) == {"upsample": 15, "downsample": 5, "learn": 8}[verb]


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("verb", SOME_SLOW)
def test_same_input_same_bytes(tmp_path, run, verb, name):
    contents = []
    for folder in ("a", "much/longer"):
        (tmp_path / folder).mkdir(parents=True)
        source, out = make_shot(tmp_path / folder / "show"), tmp_path / folder / "work" / name
        call(run, verb, source, out)
        contents.append(out.read_bytes())
    assert contents[0] == contents[1]


def test_value_clips_that_openusd_stitches(tmp_path, run):
    """Clips as `UsdUtils.StitchClips` makes them of files of a few frames each, as simulations write them."""
    make_rig(tmp_path / "asset.usda", codes=(), rotations=[], translations=None)
    rotations = random_rotations(9, 3)
    names = []
    for k in range(3):
        codes = range(3 * k, 3 * k + 3)
        take = make_rig(tmp_path / f"take.{k + 1}.usda", codes=codes, rotations=rotations[codes], translations=None)
        take.SetStartTimeCode(codes[0])
        take.SetEndTimeCode(codes[-1])
        take.Save()
        names.append(str(tmp_path / f"take.{k + 1}.usda"))
    root = Sdf.Layer.CreateNew(str(tmp_path / "in.usda"))
    assert UsdUtils.StitchClips(root, names, ANIMATION, 0.0, 8.0, False, "default")
    stage = Usd.Stage.Open(root)
    stage.GetPrimAtPath(ANIMATION).GetAttribute("translations").Set([(0, 10, 0)] * 3)
    stage.SetTimeCodesPerSecond(24)
    stage.Save()
    del stage, root
    codes, values = read(tmp_path / "in.usda")
    assert set(codes) >= set(range(9))
    for name in ("out.usda", "flat.usda", "out.usdz"):
        flat = ["--flatten"] if name.startswith("flat") else []
        code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / name, "--factor", 2, *flat)
        assert (code, err) == (
            0,
            f"warning: {ANIMATION}: rotations come from value clips; the samples in the output override them.\n",
        )
        new_codes, new_values = read(tmp_path / name)
        assert len(new_codes) > len(codes)
        place = [new_codes.index(code) for code in range(9)]
        assert bits([new_values[i] for i in place]) == bits(list(rotations))
        assert errors_of(tmp_path / name) <= errors_of(tmp_path / "in.usda")


def with_offset(folder):
    """A shot whose own layer has the animation, over a layer at other times."""
    folder.mkdir()
    stage = make_rig(folder / "shot.usda", codes=range(8), rotations=random_rotations(8, 3))
    weak = Usd.Stage.CreateNew(str(folder / "layout.usda"))
    UsdGeom.Cube.Define(weak, "/Cube").CreateSizeAttr().Set(2.0, 5.0)
    weak.Save()
    stage.GetRootLayer().subLayerPaths.append("./layout.usda")
    stage.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(7.0, 2.0)
    stage.Save()
    return folder / "shot.usda"


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("verb", SOME_SLOW)
def test_offsets_of_sublayers_are_kept_or_refused(tmp_path, run, verb, name):
    """`UsdUtils.ModifyAssetPaths` and the packing of OpenUSD forget them."""
    source, out = with_offset(tmp_path / "show"), tmp_path / "work" / name
    out.parent.mkdir()
    flat = ["--flatten"] if name.startswith("flat") else []
    code, _, err = run(verb, source, "-o", out, *VERBS[verb], *flat)
    if name == "out.usdz" and verb != "downsample":
        assert (code, err) == (
            1,
            "error: out.usdz cannot be packed: OpenUSD drops the time offset of the sublayer ./layout.usda "
            "in shot.usda; add --flatten, or choose a name that does not end in .usdz.\n",
        )
        return
    assert (code, err) == (0, "")
    stage = Usd.Stage.Open(str(out))
    assert stage.GetPrimAtPath("/Cube").GetAttribute("size").GetTimeSamples() == [17.0]


def test_layers_that_are_nowhere(tmp_path, run):
    """A missing reference is warned of once, and what is there goes on."""
    stage = make_rig(tmp_path / "in.usda")
    stage.DefinePrim("/Rig/Lost").GetReferences().AddReference("./nowhere.usda")
    stage.Save()
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert code == 0 and err.count("\n") == 1 and "nowhere.usda" in err
    assert str(Path(tmp_path).resolve()) not in (tmp_path / "out.usda").read_text()
    np.testing.assert_array_equal(read(tmp_path / "out.usda")[0], np.arange(7) / 2)


def test_flattening_tells_what_is_still_needed(tmp_path, run):
    source = make_shot(tmp_path / "show")
    for name, flat, told in (
        ("flat.usda", ["--flatten"], "It also needs skin.png."),
        ("flat.usdz", ["-f"], "It needs no other file."),
    ):
        _, out, _ = run("upsample", source, "-o", tmp_path / name, "--factor", 2, *flat)
        assert out.splitlines()[-1].endswith(f". {told}") and out.count(str(tmp_path / name)) == 1
    _, out, _ = run("upsample", tmp_path / "flat.usdz", "-o", tmp_path / "out.usdc", "--factor", 2, "-f")
    assert out.splitlines()[-1].endswith(". It also needs flat.usdz.")
    shutil.copytree(source.parent, tmp_path / "copy")
    _, out, _ = run("upsample", tmp_path / "copy" / "shot.usda", "--in-place", "--factor", 2, "-f")
    assert out.splitlines()[-1].endswith(". It also needs skin.png.")  # and not what the file needed before


def test_flattening_warns_of_textures_that_are_nowhere(tmp_path, capfd):
    source, out = make_shot(tmp_path / "show"), tmp_path / "flat.usda"
    (tmp_path / "show" / "assets" / "skin.png").unlink()
    assert upsample.main([str(source), "-o", str(out), "--factor", "2", "-f"]) == 0
    lines = capfd.readouterr().err.splitlines()  # with what OpenUSD itself would print
    assert lines[2:] == [f"warning: {out} references files that cannot be found: skin.png."]
    assert all(line.startswith("warning: ") for line in lines)


def test_flattening_names_a_few_variant_sets(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    for i in range(7):
        prim = stage.DefinePrim(f"/Rig/Prop{i}")
        prim.GetVariantSets().AddVariantSet("look").AddVariant("red")
        if i:
            prim.GetVariantSet("look").SetVariantSelection("red")
    stage.Save()
    _, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "-f")
    others = ", ".join(f"look of /Rig/Prop{i} at red" for i in range(1, 5))
    kept = f"look of /Rig/Prop0 at none, {others} and 2 more"
    assert err == f"warning: flattening keeps only the selected variants: {kept}.\n"
