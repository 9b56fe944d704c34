"""Downsample: what is kept is kept bit for bit, what is removed comes back as near as is said, the rest stays."""

import json
import shlex

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdUtils
from real_files import CLIPS, real_file
from rigs import ANIMATION, JOINTS, SKELETON, bits, make_rig, random_rotations, read, set_samples, stored_metric

from usd_tools.console.text import short_names

AMOUNTS = (["--rate", ".3"], ["--keys", "7"], ["--tolerance", "1"])
QUICK = ["--scheme", "slerp"]
"""For what does not depend on a metric."""


@pytest.fixture
def clip(tmp_path):
    """Forty samples of three joints that all move."""
    make_rig(tmp_path / "in.usda", codes=range(40), rotations=random_rotations(40, 3, size=0.8))
    return tmp_path / "in.usda"


@pytest.fixture
def there_and_back(tmp_path, run):
    """Downsample and upsample a file; give the sparse file, the restored one, and the report."""

    def call(source, *arguments, out="out.usda"):
        sparse, back, report = tmp_path / out, tmp_path / "back.usda", tmp_path / "report.json"
        code, _, err = run("downsample", source, "-o", sparse, "--report", report, *arguments)
        assert code == 0, err
        code, _, err = run("upsample", sparse, "-o", back, "--times", "source")
        assert code == 0, err
        return sparse, back, json.loads(report.read_text())

    return call


def bone_ends(path, codes, ends):
    """Return the places of bone ends, in centimetres, as OpenUSD places the joints, shape=[F, B, 3]."""
    stage = Usd.Stage.Open(str(path))
    cache = UsdSkel.Cache()
    skeleton = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
    query = cache.GetSkelQuery(UsdSkel.Skeleton(skeleton))
    to_world = UsdGeom.Imageable(skeleton).ComputeLocalToWorldTransform(0)
    unit = 100.0 * UsdGeom.GetStageMetersPerUnit(stage)
    places = []
    for code in codes:
        transforms = query.ComputeJointSkelTransforms(float(code))
        places.append(
            [(matrix * to_world).Transform(Gf.Vec3d(*end)) for matrix, end in zip(transforms, ends, strict=True)]
        )
    return unit * np.array(places)


RIG_ENDS = [[0.0, 10.0, 0.0], [0.0, 10.0, 0.0], [0.0, 10.0, 0.0]]


@pytest.mark.parametrize("amount", AMOUNTS)
@pytest.mark.parametrize("select", ["optimal", "uniform"])
def test_there_and_back(clip, there_and_back, amount, select):
    sparse, back, report = there_and_back(clip, *amount, "--select", select)
    animation = report["animations"][0]
    for name in ("rotations", "translations"):
        codes, values = read(clip, name)
        kept_codes, kept = read(sparse, name)
        back_codes, restored = read(back, name)
        assert kept_codes == animation["kept_time_codes"] and kept_codes[0] == 0 and kept_codes[-1] == 39
        assert bits(kept) == bits([values[int(code)] for code in kept_codes])
        assert back_codes == codes
        assert bits([restored[int(code)] for code in kept_codes]) == bits(kept)
    if "--tolerance" not in amount:
        assert len(kept_codes) == (7 if "--keys" in amount else 12)
    errors = np.linalg.norm(bone_ends(clip, codes, RIG_ENDS) - bone_ends(back, codes, RIG_ENDS), axis=-1)
    assert errors.max() == pytest.approx(animation["rebuilt"]["centimetres"]["largest"], abs=1e-3)
    assert errors.mean() == pytest.approx(animation["rebuilt"]["centimetres"]["mean"], abs=1e-3)
    played = np.linalg.norm(bone_ends(clip, codes, RIG_ENDS) - bone_ends(sparse, codes, RIG_ENDS), axis=-1)
    assert played.max() == pytest.approx(animation["played"]["centimetres"]["largest"], abs=1e-3)
    if "--tolerance" in amount:
        assert errors.max() <= 1.0


@pytest.mark.slow
def test_chosen_samples_are_better_than_every_third(clip, there_and_back):
    chosen, spaced = (
        there_and_back(clip, "--rate", ".3", "--select", select)[2]["animations"][0]["rebuilt"]["q_hyb"]
        for select in ("optimal", "uniform")
    )
    assert chosen < spaced


def test_tighter_tolerances_keep_more(clip, there_and_back):
    kept = [
        there_and_back(clip, "--tolerance", cm, *QUICK)[2]["animations"][0]["kept_samples"] for cm in (0.1, 1, 5, 100)
    ]
    assert kept == sorted(kept, reverse=True) and kept[-1] < kept[0]


@pytest.mark.parametrize("scheme", ["slerp", "linear", "geodesic", "rotation-spline"])
def test_the_scheme_travels_along(clip, there_and_back, scheme):
    sparse, _, _ = there_and_back(clip, "--tolerance", "1", "--scheme", scheme)
    assert stored_metric(sparse).scheme == scheme


def test_result_does_not_need_its_source(tmp_path, clip, run):
    (tmp_path / "far").mkdir()
    assert run("downsample", clip, "-o", tmp_path / "far" / "out.usdc", "--rate", ".3", *QUICK)[0] == 0
    before = read(clip)[1]
    clip.unlink()
    assert run("upsample", tmp_path / "far" / "out.usdc", "-o", tmp_path / "back.usda", "--times", "source")[0] == 0
    assert bits(read(tmp_path / "back.usda")[1][:1]) == bits(before[:1])


def test_constant_channels_become_defaults(tmp_path, there_and_back):
    make_rig(
        tmp_path / "in.usda",
        codes=range(20),
        rotations=random_rotations(20, 3),
        translations=np.full((20, 3, 3), 10.0, dtype=np.float32),
        scales=np.ones((20, 3, 3), dtype=np.float16),
    )
    sparse, back, report = there_and_back(tmp_path / "in.usda", "--rate", ".3", *QUICK)
    for name in ("translations", "scales"):
        assert read(sparse, name)[0] == [] and read(back, name)[0] == []
        stage = Usd.Stage.Open(str(back))
        prim = stage.GetPrimAtPath(ANIMATION)
        assert np.array_equal(np.array(prim.GetAttribute(name).Get()), np.full((3, 3), 10.0 if name[0] == "t" else 1.0))
    assert report["animations"][0]["constant"] == ["translations", "scales"]


def test_what_never_moves_says_how_long(tmp_path, there_and_back):
    make_rig(
        tmp_path / "in.usda",
        codes=range(20),
        rotations=np.repeat(random_rotations(1, 3), 20, axis=0),
        translations=np.full((20, 3, 3), 10.0, dtype=np.float32),
    )
    for amount in AMOUNTS:
        sparse, back, report = there_and_back(tmp_path / "in.usda", *amount)
        assert read(sparse)[0] == [0.0, 19.0] and read(back)[0] == list(range(20))
        assert report["animations"][0]["rebuilt"]["centimetres"]["largest"] == 0.0


def test_two_samples_and_one_joint(tmp_path, there_and_back):
    make_rig(tmp_path / "two.usda", codes=(0, 7))
    for amount in (["--rate", ".5"], ["--keys", "2"], ["--tolerance", "1"]):
        assert read(there_and_back(tmp_path / "two.usda", *amount)[1])[0] == [0.0, 7.0]
    make_rig(tmp_path / "one.usda", codes=range(30), joints=["hips"], rotations=random_rotations(30, 1))
    assert there_and_back(tmp_path / "one.usda", "--tolerance", "1")[2]["animations"][0]["kept_samples"] < 30


def test_value_blocks_and_steps_stay(tmp_path, there_and_back):
    poses, moves = list(random_rotations(40, 3)), list(np.full((40, 3, 3), 10.0, dtype=np.float32))
    for frame, move in enumerate(moves):
        move[0, 0] = frame
    poses[12] = moves[12] = None
    codes = [*map(float, range(25)), 24.0 + 1e-4, *map(float, range(26, 40))]
    make_rig(tmp_path / "in.usda", codes=codes, rotations=poses, translations=moves)
    sparse, back, _ = there_and_back(tmp_path / "in.usda", "--rate", ".2", *QUICK)
    kept, values = read(sparse)
    assert {0.0, 11.0, 12.0, 13.0, 24.0, 24.0 + 1e-4, 39.0} <= set(kept) and len(kept) < 20
    assert values[kept.index(12.0)] is None
    assert read(back)[0] == codes
    assert [value is None for value in read(back)[1]] == [value is None for value in poses]


def test_channels_with_samples_at_different_times(tmp_path, there_and_back):
    stage = make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3), translations=None)
    moves = np.linspace(0.0, 30.0, 3 * 9, dtype=np.float32).reshape(3, 3, 3)
    UsdSkel.Animation(stage.GetPrimAtPath(ANIMATION)).CreateTranslationsAttr()
    set_samples(stage, "translations", (0, 9.5, 19), moves)
    stage.GetRootLayer().Save()
    sparse, back, report = there_and_back(tmp_path / "in.usda", "--tolerance", ".5", *QUICK)
    assert read(sparse)[0] == read(sparse, "translations")[0]
    assert read(back)[0] == sorted([*map(float, range(20)), 9.5])
    assert "different times" in " ".join(report["warnings"])
    assert report["animations"][0]["rebuilt"]["centimetres"]["largest"] <= 0.5


def test_scales_that_change_are_kept_whole(tmp_path, there_and_back):
    """Beside weights that need all their samples."""
    scales = np.ones((20, 3, 3), dtype=np.float16)
    scales[:, 0, 0] = np.linspace(1.0, 2.0, 20)
    stage = make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3), scales=scales)
    animation = UsdSkel.Animation(stage.GetPrimAtPath(ANIMATION))
    animation.CreateBlendShapesAttr(["smile"])
    animation.CreateBlendShapeWeightsAttr()
    set_samples(stage, "blendShapeWeights", range(20), np.random.default_rng(0).random((20, 1, 1), dtype=np.float32))
    stage.GetRootLayer().Save()
    words = ["--rate", ".3", "--weights-tolerance", "1e-6"]
    sparse, back, report = there_and_back(tmp_path / "in.usda", *words, *QUICK)
    for name in ("scales", "blendShapeWeights"):
        assert bits(read(sparse, name)[1]) == bits(read(tmp_path / "in.usda", name)[1]) == bits(read(back, name)[1])
    assert len(read(sparse)[0]) == 6
    assert report["animations"][0]["kept_whole"] == ["scales"]
    (kept_whole,) = (warning for warning in report["warnings"] if "kept whole" in warning)
    assert "scales" in kept_whole and "blendShapeWeights" not in kept_whole


def test_what_is_to_stay_stays(clip, there_and_back):
    for amount in AMOUNTS:
        sparse, _, _ = there_and_back(clip, *amount, "--keep", "5,6", *QUICK)
        assert {5.0, 6.0} <= set(read(sparse)[0])


def test_exactly_the_samples_that_are_named_stay(clip, there_and_back):
    sparse, back, report = there_and_back(clip, "--keep-only", "11,4,20")
    codes = read(clip)[0]
    assert read(sparse)[0] == [codes[0], 4.0, 11.0, 20.0, codes[-1]]
    assert report["settings"]["keep_only"] == "11,4,20"
    # a metric is learned for them: no worse than slerp, which viewers show
    assert report["animations"][0]["rebuilt"]["q_hyb"] <= report["animations"][0]["played"]["q_hyb"]


def test_several_animations_and_one_of_them(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    other = UsdSkel.Animation.Define(stage, "/Rig/Library")
    other.CreateJointsAttr(JOINTS)
    set_samples(stage, "rotations", range(30), random_rotations(30, 3, seed=1), "/Rig/Library")
    stage.GetRootLayer().Save()
    assert run("downsample", tmp_path / "in.usda", "-o", tmp_path / "all.usda", "--keys", "5", *QUICK)[0] == 0
    assert [len(read(tmp_path / "all.usda", prim=prim)[0]) for prim in (ANIMATION, "/Rig/Library")] == [5, 5]
    arguments = [*QUICK, "--keys", "5", "--prim", "/Rig/Library"]
    assert run("downsample", tmp_path / "in.usda", "-o", tmp_path / "one.usda", *arguments)[0] == 0
    assert [len(read(tmp_path / "one.usda", prim=prim)[0]) for prim in (ANIMATION, "/Rig/Library")] == [20, 5]


def test_composition_survives_where_the_samples_are_in_the_file_itself(tmp_path, run):
    (tmp_path / "parts").mkdir()
    prop = Usd.Stage.CreateNew(str(tmp_path / "parts" / "prop.usda"))
    prop.SetDefaultPrim(prop.DefinePrim("/Prop", "Xform"))
    prop.GetRootLayer().Save()
    stage = make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    prim = stage.DefinePrim("/Rig/Prop")
    prim.GetReferences().AddReference("./parts/prop.usda")
    variants = stage.GetPrimAtPath("/Rig").GetVariantSets().AddVariantSet("look")
    for name in ("red", "blue"):
        variants.AddVariant(name)
    variants.SetVariantSelection("red")
    stage.GetRootLayer().Save()
    (tmp_path / "far").mkdir()
    out = tmp_path / "far" / "out.usda"
    assert run("downsample", tmp_path / "in.usda", "-o", out, "--rate", ".3", *QUICK)[0] == 0
    written = Usd.Stage.Open(str(out))
    assert written.GetPrimAtPath("/Rig/Prop").GetTypeName() == "Xform"
    assert written.GetPrimAtPath("/Rig").GetVariantSets().GetVariantSet("look").GetVariantNames() == ["blue", "red"]
    assert written.GetCompositionErrors() == []
    assert len(written.GetUsedLayers(includeClipLayers=False)) == 3  # its session layer, itself and the prop


def test_samples_in_other_files_are_flattened(tmp_path, clip, run):
    over = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    over.GetRootLayer().subLayerPaths = ["./in.usda"]
    over.SetTimeCodesPerSecond(24.0)
    over.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(100.0)
    over.GetRootLayer().Save()
    assert run("downsample", tmp_path / "shot.usda", "-o", tmp_path / "out.usda", "--keys", "6", *QUICK)[0] == 0
    assert Sdf.Layer.FindOrOpen(str(tmp_path / "out.usda")).subLayerPaths == []
    codes = read(tmp_path / "out.usda")[0]
    assert len(codes) == 6 and (codes[0], codes[-1]) == (100.0, 139.0)
    code, _, err = run("downsample", tmp_path / "shot.usda", "--in-place", "--keys", "6", *QUICK)
    assert code == 1 and "the samples are in files that" in err


def test_moved_in_time_it_still_comes_back(tmp_path, clip, run):
    assert run("downsample", clip, "-o", tmp_path / "sparse.usda", "--keys", "6", *QUICK)[0] == 0
    shot = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    shot.SetTimeCodesPerSecond(24.0)
    shot.GetRootLayer().subLayerPaths = ["./sparse.usda"]
    shot.GetRootLayer().subLayerOffsets[0] = Sdf.LayerOffset(100.0, 2.0)
    shot.GetRootLayer().Save()
    assert run("upsample", tmp_path / "shot.usda", "-o", tmp_path / "back.usda", "--times", "source")[0] == 0
    assert read(tmp_path / "back.usda")[0] == [100.0 + 2.0 * code for code in range(40)]


def test_in_place(clip, run):
    before = read(clip)[1]
    size, report = clip.stat().st_size, clip.parent / "report.json"
    code, out, _ = run("downsample", clip, "--in-place", "--keys", "6", "--report", report, *QUICK)
    assert code == 0 and f"{size} -> {clip.stat().st_size} bytes). It needs no other file" in out
    assert json.loads(report.read_text())["file_bytes_before"] == size > clip.stat().st_size
    codes, values = read(clip)
    assert len(codes) == 6 and bits(values) == bits([before[int(code)] for code in codes])


def test_files_in_a_package_that_are_still_needed_are_told(tmp_path, clip, run):
    (tmp_path / "skin.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    stage = Usd.Stage.Open(str(clip))
    material = stage.DefinePrim("/Rig/Material")
    material.CreateAttribute("inputs:file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath("./skin.png"))
    stage.Save()
    assert UsdUtils.CreateNewUsdzPackage(str(clip), str(tmp_path / "in.usdz"))
    out = run("downsample", tmp_path / "in.usdz", "-o", tmp_path / "out.usdc", "--keys", "6", *QUICK)[1]
    assert "It also needs in.usdz" in out


@pytest.mark.parametrize("extension", ["usda", "usdc", "usdz"])
def test_same_input_same_bytes(tmp_path, clip, run, extension):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        assert run("downsample", clip, "-o", tmp_path / name / f"out.{extension}", "--tolerance", "1", *QUICK)[0] == 0
    assert (tmp_path / "a" / f"out.{extension}").read_bytes() == (tmp_path / "b" / f"out.{extension}").read_bytes()


def test_scaled_ancestors_and_units(tmp_path, there_and_back):
    stage = make_rig(tmp_path / "in.usda", codes=range(30), rotations=random_rotations(30, 3, size=0.8))
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddScaleOp().Set(Gf.Vec3f(0.1))
    stage.GetRootLayer().Save()
    _, back, report = there_and_back(tmp_path / "in.usda", "--tolerance", ".05", *QUICK)
    errors = np.linalg.norm(
        bone_ends(tmp_path / "in.usda", range(30), RIG_ENDS) - bone_ends(back, range(30), RIG_ENDS), axis=-1
    )
    assert errors.max() <= 0.05
    assert errors.max() == pytest.approx(report["animations"][0]["rebuilt"]["centimetres"]["largest"], abs=1e-4)


def test_a_hand_full_of_fingers(tmp_path, there_and_back):
    fingers = [f"hand/f{i}{'/b' * depth}" for i in range(5) for depth in range(4)]
    joints = ["hand", *fingers]
    make_rig(tmp_path / "in.usda", codes=range(30), joints=joints, rotations=random_rotations(30, 21, size=0.02))
    report = there_and_back(tmp_path / "in.usda", "--tolerance", "2", *QUICK)[2]["animations"][0]
    assert [joint["joint"] for joint in report["joints"]] == joints
    assert report["kept_samples"] < 30


def test_report_and_picture(tmp_path, clip, run):
    picture = tmp_path / "kept.png"
    code, out, _ = run("downsample", clip, "-o", tmp_path / "out.usdc", "--tolerance", "1", "--picture", picture, "-v")
    assert code == 0
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000
    for words in ("samples kept, 3 joints", "rebuilt by upsample --times source", "played by a viewer", "arm",
                  "equally spaced samples:", "Wrote "):  # fmt: skip
        assert words in out


def test_small_rotation_errors_are_no_warning(tmp_path, clip, run):
    _, out, err = run("downsample", clip, "-o", tmp_path / "out.usda", "--tolerance", "1", *QUICK)
    assert err == "" and "Largest rotation error, rebuilt: " in out


def test_joints_of_one_name_are_told_apart(tmp_path, run):
    joints = ["root", "root/L", "root/L/tip", "root/R", "root/R/tip"]
    make_rig(tmp_path / "in.usda", codes=range(20), joints=joints, rotations=random_rotations(20, 5))
    out = run("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--keys", "6", "-v", *QUICK)[1]
    names = [line.split("│")[1].strip() for line in out.splitlines() if line.startswith("│")]
    assert set(names[2:]) == {"root", "L", "L/tip", "R", "R/tip"}


def test_joints_that_the_animation_leaves_out(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(20), anim_joints=JOINTS[:2], rotations=random_rotations(20, 2))
    out = run("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--keys", "6", "-v", *QUICK)[1]
    assert "│ arm " in out and "Largest rotation error, rebuilt: " in out


def test_short_names():
    joints = ["tip", "a/tip", "b/a/tip", "b", "c/b/d"]
    assert list(short_names(joints).values()) == ["tip", "a/tip", "b/a/tip", "b", "d"]


def test_schemes_without_a_metric_speak_of_none(tmp_path, clip, there_and_back, run):
    out = run("downsample", clip, "-o", tmp_path / "out.usda", "--keys", "6", "--scheme", "squad")[1]
    assert out.splitlines()[0].endswith("as NumPy, scheme included")
    assert out.splitlines()[1] == "  squad, 3 joints"
    sparse, _, report = there_and_back(clip, "--keys", "6", "--scheme", "squad")
    assert report["animations"][0]["metric_summary"] == "squad, 3 joints"
    stage = Usd.Stage.Open(str(sparse))
    summary = stage.GetPrimAtPath(SKELETON).GetAttribute("userProperties:geodesicMetricSummary")
    assert summary.Get() == "squad, 3 joints"


def test_one_joint_is_one(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(30), joints=["hips"], rotations=random_rotations(30, 1))
    out = run("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--keys", "4", *QUICK)[1]
    assert "samples kept, 1 joint; " in out and "Worst joint, rebuilt" in out and "1 joints" not in out


def test_the_way_back_can_be_pasted(tmp_path, clip, run):
    there = tmp_path / "out dir" / "wälk's small.usda"
    there.parent.mkdir()
    out = run("downsample", clip, "-o", there, "--keys", "6", *QUICK)[1]
    command = out.partition("Restore all samples with:\n")[2].splitlines()[0]
    assert shlex.split(command)[:4] == ["python", "-m", "usd_tools.upsample", str(there)]


def test_text_that_grew_is_told(tmp_path, run):
    """A file of two samples can only grow: it gets a metric."""
    make_rig(tmp_path / "in.usda", codes=(0, 1))
    out = run("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--keys", "2", *QUICK)[1]
    larger = "is larger than in.usda because it is text; use an --out that ends in .usdc."
    assert out.splitlines()[-1] == f"{tmp_path}/out.usda {larger}"
    out = run("downsample", tmp_path / "in.usda", "--in-place", "--keys", "2", *QUICK)[1]
    assert "in.usda is larger than before because it is text" in out


def test_report_counts_bytes(clip, there_and_back):
    sparse, _, report = there_and_back(clip, "--rate", ".2", *QUICK, out="out.usdc")
    animation = report["animations"][0]
    assert report["file_bytes_after"] == sparse.stat().st_size
    assert animation["bytes_usdc_after"] < animation["bytes_usdc_before"]
    assert animation["bytes_numpy_before"] > 40 * 3 * 7 * 4
    uniform = animation["uniform_slerp"]
    assert uniform["samples"] >= animation["kept_samples"] and uniform["bytes_usdc"] > 0


def test_the_metric_knows_what_it_brings_each_joint(clip, there_and_back, inspected):
    sparse, _, report = there_and_back(clip, "--rate", ".2")
    animation = report["animations"][0]
    degrees = {joint["joint"]: joint["degrees"]["mean"] for joint in animation["joints"]}
    told = inspected(sparse)["animations"][0]["metric"]["by_joint"]
    assert {one["joint"] for one in told} == set(degrees)
    for one in told:
        assert one["slerp_error"] - one["gain"] == pytest.approx(degrees[one["joint"]], abs=2e-4)
    played = np.mean([one["slerp_error"] for one in told])
    assert played == pytest.approx(animation["played"]["degrees"]["mean"], abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", CLIPS)
def test_real_clips(name, there_and_back):
    path = real_file(name)
    sparse, _, report = there_and_back(path, "--tolerance", "3", out="out.usdc")
    animation = report["animations"][0]
    assert animation["rebuilt"]["centimetres"]["largest"] <= 3.0
    assert animation["kept_samples"] <= 0.6 * animation["uniform_slerp"]["samples"]
    assert sparse.stat().st_size < path.stat().st_size


def test_summary_is_on_the_skeleton(tmp_path, clip, run):
    assert run("downsample", clip, "-o", tmp_path / "sparse.usda", "--keys", "6")[0] == 0
    stage = Usd.Stage.Open(str(tmp_path / "sparse.usda"))
    summary = stage.GetPrimAtPath(SKELETON).GetAttribute("userProperties:geodesicMetricSummary").Get()
    assert summary.startswith("geodesic-spline, 3 joints")
