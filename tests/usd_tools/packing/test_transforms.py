"""Transforms that move a character as a whole are packed with its joints, and read as if they had all samples."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom
from rigs import ANIMATION, SKELETON, make_rig, random_rotations, read

from geomstats_anim.markers import Markers, distances_between, joint_matrices
from usd_tools.pack import PackOptions, pack_stage
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.packed import PACKED, packed_bytes
from usd_tools.skel.resampling import animation_of
from usd_tools.unpack import unpack_stage

N = 24
CODES = list(range(N))
TOLERANCE = 0.5
TRANSLATE, ORIENT, MATRIX = "/Rig.xformOp:translate", "/Rig.xformOp:orient", f"{SKELETON}.xformOp:transform"


def clip_of(path):
    return read_clip(find_animations(Usd.Stage.Open(str(path)))[0])


def placed(clip, animation):
    placements = clip.placements(animation.times * clip.codes_per_second)
    return joint_matrices(type(animation)(**{**vars(animation), "world": placements}))


def largest_error(path, source):
    """In centimetres, of joints, bone ends and shell, moved by all that is above them."""
    ours, truth = clip_of(path), clip_of(source)
    motion = animation_of(truth)
    matrices = placed(ours, animation_of(ours)), placed(truth, motion)
    return 100.0 * distances_between(*matrices, Markers.of_shell(motion)).max()


def values(path, attribute):
    """Return the time codes of an op, and its numbers; None is a value block."""
    stage = Usd.Stage.Open(str(path))
    found = stage.GetAttributeAtPath(attribute)
    codes = found.GetTimeSamples()
    return codes, [found.Get(code) for code in codes]


@pytest.fixture
def source(tmp_path):
    """A character that is moved, turned and scaled by three prims' worth of ops; one has a value block."""
    path = tmp_path / "in.usda"
    stage = make_rig(path, codes=CODES, rotations=random_rotations(N, 3))
    root, skeleton = (UsdGeom.Xformable(stage.GetPrimAtPath(each)) for each in ("/Rig", SKELETON))
    translate, orient, matrix = root.AddTranslateOp(), root.AddOrientOp(), skeleton.AddTransformOp()
    for k in CODES:
        translate.Set(Gf.Vec3d(2.0 * k, 5.0 * np.sin(k / 5.0), 7.0), k)
        orient.Set(Gf.Quatf(Gf.Rotation((0, 0, 1), 9.0 * k).GetQuat()) * (-1.0 if k % 2 else 1.0), k)
        turned = Gf.Matrix4d().SetScale(0.5 + 0.01 * k) * Gf.Matrix4d().SetRotate(Gf.Rotation((0, 1, 0), 3.0 * k))
        matrix.Set(turned.SetTranslateOnly((0.0, 0.3 * k, 0.0)), k)
    stage.GetRootLayer().Save()
    return path


@pytest.mark.parametrize("preview", [0, 4])
def test_ops_are_packed_within_the_tolerance_and_unpacked(source, tmp_path, run, preview):
    packed, back = tmp_path / "packed.usda", tmp_path / "back.usda"
    words = ["--tolerance", TOLERANCE, "--preview", preview, "--effort", "fast"]
    code, text, err = run("pack", source, "-o", packed, *words)
    assert (code, err) == (0, "") and TRANSLATE in text
    assert 0.3 * TOLERANCE < largest_error(packed, source) <= TOLERANCE
    assert run("unpack", packed, "-o", back)[0] == 0
    # the shell is 3 cm in the units of the first sample, which is packed too
    assert largest_error(back, source) <= 1.01 * TOLERANCE
    for path in (TRANSLATE, ORIENT, MATRIX):
        before, few, after = (values(file, path) for file in (source, packed, back))
        assert after[0] == before[0] == CODES and len(few[0]) == (preview or 2)
        kept = dict(zip(*before, strict=True))
        assert few[1] == ([kept[code] for code in few[0]] if preview else [kept[0]] * 2)
    for matrix in values(back, MATRIX)[1]:  # which are still a scale, a turn and a move
        linear = np.array(matrix)[:3, :3]
        np.testing.assert_allclose(linear @ linear.T, np.linalg.det(linear) ** (2 / 3) * np.eye(3), atol=1e-12)


def test_value_blocks_uneven_times_and_times_of_their_own_survive(tmp_path, run):
    path, back = tmp_path / "in.usda", tmp_path / "back.usda"
    codes = np.sort(np.random.default_rng(1).choice(np.arange(0, 60, 0.25), N, replace=False)).tolist()
    stage = make_rig(path, codes=codes, rotations=random_rotations(N, 3))
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for k in range(0, N, 2):
        op.GetAttr().Set(Sdf.ValueBlock() if k == 10 else Gf.Vec3d(k, 0.0, 0.0), codes[k])
    stage.GetRootLayer().Save()
    for preview in (0, 5):
        assert (
            run(
                "pack",
                path,
                "-o",
                tmp_path / "packed.usda",
                "--tolerance",
                0.2,
                "--preview",
                preview,
                "--effort",
                "fast",
            )[0]
            == 0
        )
        run("unpack", tmp_path / "packed.usda", "-o", back)
        found, moved = values(back, TRANSLATE)
        assert set(codes[::2]) <= set(found) <= set(codes) and read(back)[0] == codes
        for code, value in zip(found, moved, strict=True):
            if code in codes[::2] and code != codes[10]:
                assert abs(value[0] - codes.index(code)) <= 0.2
        assert moved[found.index(codes[10])] is None
        assert codes[11] not in found  # within the block, nothing is shown


def test_verbs_that_leave_transforms_write_all_of_their_samples(source, tmp_path, run):
    packed, out = tmp_path / "packed.usda", tmp_path / "out.usda"
    run("pack", source, "-o", packed, "--tolerance", TOLERANCE, "--effort", "fast")
    for words in (
        ["upsample", "--factor", 2, "--no-xforms"],
        ["downsample", "--keys", 8],
        ["pack", "--tolerance", 1, "--no-xforms"],
    ):
        verb, *options = words
        assert run(verb, packed, "-o", out, *options)[0] == 0
        codes, moved = values(out, TRANSLATE)
        assert codes == CODES
        np.testing.assert_allclose(np.array(moved)[:, 0], 2.0 * np.arange(N), atol=TOLERANCE)
    run("upsample", packed, "-o", out, "--factor", 2)
    codes, moved = values(out, TRANSLATE)
    assert codes == np.arange(0, N - 0.5, 0.5).tolist()
    np.testing.assert_allclose(np.array(moved)[:, 0], 2.0 * np.array(codes), atol=TOLERANCE)


def test_samples_of_a_stronger_layer_count(source, tmp_path, run):
    run("pack", source, "-o", tmp_path / "packed.usda", "--tolerance", TOLERANCE, "--effort", "fast")
    layer = Sdf.Layer.CreateNew(str(tmp_path / "stranger.usda"))
    layer.subLayerPaths = ["./packed.usda"]
    stage = Usd.Stage.Open(layer)
    attribute = stage.GetAttributeAtPath(TRANSLATE)
    attribute.Set(Gf.Vec3d(0.0), 0.0)
    attribute.Set(Gf.Vec3d(1.0), 9.0)
    assert set(read_clip(find_animations(stage)[0]).source.xforms) == {ORIENT, MATRIX}


def test_packed_characters_are_referenced_elsewhere_and_instanced(source, tmp_path, run):
    run("pack", source, "-o", tmp_path / "packed.usda", "--tolerance", TOLERANCE, "--effort", "fast")
    stage = Usd.Stage.CreateNew(str(tmp_path / "crowd.usda"))
    for name in ("A", "B"):
        prim = stage.DefinePrim(f"/Crowd/{name}/Char")
        prim.GetReferences().AddReference("./packed.usda")
        prim.GetParent().SetInstanceable(True)
    stage.GetRootLayer().Save()
    clip = read_clip(find_animations(stage)[0])
    single = clip_of(tmp_path / "packed.usda")
    np.testing.assert_allclose(clip.placements(clip.codes), single.placements(single.codes), atol=1e-12)
    assert run("unpack", tmp_path / "crowd.usda", "-o", tmp_path / "back.usda")[0] == 0
    for name in ("A", "B"):
        codes, moved = values(tmp_path / "back.usda", f"/Crowd/{name}/Char.xformOp:translate")
        assert codes == CODES and moved[-1] != moved[0]


def test_ops_that_cannot_be_packed_keep_their_samples_and_are_named(source, tmp_path, run):
    stage = Usd.Stage.Open(str(source))
    stage.GetAttributeAtPath(TRANSLATE).Set(Gf.Vec3d(0.0), 100.0)
    sheared = Gf.Matrix4d(1.0)
    sheared[0, 1] = 0.5
    stage.GetAttributeAtPath(MATRIX).Set(sheared, 3.0)
    stage.GetRootLayer().Save()
    code, _, err = run("pack", source, "-o", tmp_path / "packed.usda", "--tolerance", TOLERANCE, "--effort", "fast")
    assert code == 0
    assert f"{TRANSLATE} keeps its {N + 1} samples: it moves before or after {ANIMATION} does." in err
    assert f"{MATRIX} keeps its {N} samples: its matrices are not exactly" in err
    assert values(tmp_path / "packed.usda", TRANSLATE) == values(source, TRANSLATE)
    assert set(clip_of(tmp_path / "packed.usda").source.xforms) == {ORIENT}


@pytest.mark.parametrize(
    "name", ["../..:translate", "..:translate", "..:translate x", "no path!:translate", "/Rig:translate", ".."]
)
def test_strange_names_in_a_stream_are_refused(source, tmp_path, name):
    from geomstats_anim.codec import ExtraChannel, pack
    from usd_tools.console.errors import ToolError
    from usd_tools.skel.packed import write_packed

    clip = clip_of(source)
    animation = animation_of(clip)
    channel = ExtraChannel(np.zeros((N, 2)), 0.1)
    stream = pack(type(animation)(**{**vars(animation), "times": clip.codes}), 0.01, channels={name: channel})
    layer = Sdf.Layer.FindOrOpen(str(source))
    write_packed(layer.GetPrimAtPath(ANIMATION), stream, True)
    with pytest.raises(ToolError, match=PACKED):
        clip_of(source)


def test_a_character_that_grows_from_nothing_and_a_face_keep_their_transforms(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=CODES, rotations=random_rotations(N, 3))
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddScaleOp()
    for k in CODES:
        op.Set(Gf.Vec3f(min(k / 5.0, 1.0)), k)
    stage.GetRootLayer().Save()
    code, _, err = run("pack", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--tolerance", 1, "--effort", "fast")
    assert code == 0 and f"/Rig.xformOp:scale keeps its {N} samples: the character has no size where it begins" in err
    stage = make_rig(tmp_path / "face.usda", codes=[0], joints=[], translations=None, scales=None)
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.RemoveProperty("rotations")
    prim.CreateAttribute("blendShapes", Sdf.ValueTypeNames.TokenArray).Set(["smile"])
    weights = prim.CreateAttribute("blendShapeWeights", Sdf.ValueTypeNames.FloatArray)
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for k in CODES:
        weights.Set([float(np.sin(k / 4.0))], float(k))
        op.Set(Gf.Vec3d(k, 0.0, 0.0), k)
    stage.GetRootLayer().Save()
    code, _, err = run("pack", tmp_path / "face.usda", "-o", tmp_path / "out.usda", "--tolerance", 1)
    assert code == 0 and f"{TRANSLATE} keeps its {N} samples: there is no joint to measure errors on" in err


def test_open_stages_are_packed_and_unpacked(source):
    stage = Usd.Stage.Open(str(source))
    op, before = stage.GetAttributeAtPath(TRANSLATE), values(source, TRANSLATE)[1]
    stage.SetEditTarget(stage.GetSessionLayer())
    (packed,) = pack_stage(stage, PackOptions(tolerance=TOLERANCE, effort="fast")).animations
    assert packed.xforms == (f"{SKELETON}.xformOp:transform", TRANSLATE, ORIENT)
    assert op.GetTimeSamples() == [0, N - 1] and packed.errors["centimetres"]["largest"] <= TOLERANCE
    unpack_stage(stage)
    assert op.GetTimeSamples() == CODES
    assert max((op.Get(code) - before[code]).GetLength() for code in CODES) <= TOLERANCE


def test_jumps_and_holds_of_a_transform_survive_and_cost_little(tmp_path, run):
    sizes = {}
    for jump in (0.0, 500.0):
        path = tmp_path / f"in{jump:g}.usda"
        stage = make_rig(path, codes=CODES, rotations=random_rotations(N, 3))
        op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
        for k in CODES:
            op.Set(Gf.Vec3d(jump * (k > 11) + 3.0 * min(k, 18), 0.0, 0.0), k)
        stage.GetRootLayer().Save()
        words = ["--tolerance", TOLERANCE, "--effort", "fast"]
        assert run("pack", path, "-o", tmp_path / "packed.usdc", *words)[0] == 0
        (found,) = find_animations(Usd.Stage.Open(str(tmp_path / "packed.usdc")))
        sizes[jump] = packed_bytes(found.prim)
        run("unpack", tmp_path / "packed.usdc", "-o", tmp_path / "back.usda")
        moved = np.array(values(tmp_path / "back.usda", TRANSLATE)[1])[:, 0]
        np.testing.assert_allclose(moved, [op.Get(k)[0] for k in CODES], atol=TOLERANCE)
    assert sizes[500.0] < sizes[0.0] + 100
