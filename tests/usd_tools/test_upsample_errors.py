"""Bad input: one sentence, an exit code, nothing written, the input untouched."""

import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel
from rigs import ANIMATION, make_rig, random_rotations, set_samples


@pytest.fixture
def refused(refuse):
    """Run upsample and check that it is refused politely; give the sentence."""
    return partial(refuse, "upsample")


@pytest.fixture
def clip(tmp_path):
    """A good file."""
    make_rig(tmp_path / "in.usda")
    return tmp_path / "in.usda"


def test_missing_file(tmp_path, refused):
    assert (
        refused(tmp_path / "no.usda", "-o", tmp_path / "out.usda", "--factor", 2) == "no.usda: there is no such file."
    )


def test_folder(tmp_path, refused):
    sentence = refused(tmp_path, "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == "--out out.usda is a file; name a folder, for IN is a folder or several files."
    sentence = refused(tmp_path, "-o", tmp_path / "out", "--factor", 2)
    assert sentence == f"{tmp_path} contains no file that ends in .usd, .usda, .usdc or .usdz, nor do its subfolders."


def test_not_usd(tmp_path, refused):
    (tmp_path / "notes.txt").write_text("hello")
    sentence = refused(tmp_path / "notes.txt", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == "notes.txt is not a USD file; its name must end in .usd, .usda, .usdc, .usdz."
    for name in ("broken.usda", "broken.usdc", "broken.usd", "broken.usdz", "empty.usda"):
        (tmp_path / name).write_bytes(b"" if name.startswith("empty") else b"PXR-USDC hello")
        sentence = refused(tmp_path / name, "-o", tmp_path / "out.usda", "--factor", 2)
        assert sentence.startswith(f"{name} cannot be read as USD: ")


def test_no_skeletal_animation(tmp_path, refused):
    Usd.Stage.CreateNew(str(tmp_path / "in.usda")).Save()
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == "in.usda has no skeletal animation."


def test_one_sample(tmp_path, refused):
    make_rig(tmp_path / "in.usda", codes=(0,))
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"in.usda has no skeletal animation with at least two samples: {ANIMATION} has 1."


def test_no_joints(tmp_path, refused):
    stage = make_rig(tmp_path / "in.usda")
    stage.GetPrimAtPath(ANIMATION).GetAttribute("joints").Set([])
    set_samples(stage, "rotations", range(4), np.zeros((4, 0, 4), dtype=np.float32))
    for name in ("translations", "scales"):
        stage.GetPrimAtPath(ANIMATION).RemoveProperty(name)
    stage.Save()
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"{ANIMATION} has samples, but no joints; author its joints."


def test_joint_twice(tmp_path, refused):
    make_rig(tmp_path / "in.usda", anim_joints=["hips", "hips"])
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"{ANIMATION}: joint hips is listed twice in joints; repair the file."


def test_values_of_the_wrong_number(tmp_path, refused):
    stage = make_rig(tmp_path / "in.usda")
    set_samples(stage, "rotations", [2], [random_rotations(1, 2)[0]])
    stage.Save()
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"{ANIMATION}: rotations at time code 2 has 2 values for 3 joints; repair the file."


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (np.nan, "rotations has a value that is not a finite number at time code 1"),
        (0.0, "is a quaternion of length 0"),
    ],
)
def test_values_that_are_no_rotations(tmp_path, refused, value, words):
    rotations = random_rotations(4, 3)
    rotations[1, 2] = value
    make_rig(tmp_path / "in.usda", rotations=rotations)
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence.startswith(ANIMATION) and words in sentence


def test_values_of_the_wrong_type(tmp_path, refused):
    make_rig(tmp_path / "in.usda")
    text = (tmp_path / "in.usda").read_text()
    (tmp_path / "in.usda").write_text(text.replace("quatf[] rotations", "quatd[] rotations"))
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"{ANIMATION}: rotations at time code 0 is not of type quatf[]; repair the file."


@pytest.mark.parametrize("prim", ["/Nowhere", "Rig", "not a path"])
def test_unknown_prim(tmp_path, clip, refused, prim):
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2, "--prim", prim)
    assert sentence == f"--prim {prim}: there is no such prim in in.usda; usd_tools.inspect lists the animations."


def test_prim_without_animation(tmp_path, clip, refused):
    stage = Usd.Stage.Open(str(clip))
    stage.DefinePrim("/Other")
    stage.Save()
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2, "--prim", "/Other")
    assert sentence == "--prim /Other has no skeletal animation in in.usda; usd_tools.inspect lists them."


def test_output_folder(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "no" / "out.usda", "--factor", 2)
    assert sentence == "--out no/out.usda: there is no folder no; make it first."
    (tmp_path / "folder.usda").mkdir()
    sentence = refused(clip, "-o", tmp_path / "folder.usda", "--factor", 2)
    assert sentence == "--out folder.usda is a folder; name a file in it."


def test_output_folder_that_may_not_be_written(tmp_path, clip, refused, monkeypatch):
    # Root may write everywhere, so the system's answer is made up.
    monkeypatch.setattr(os, "access", lambda path, mode: mode == os.R_OK)
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"--out out.usda: the folder {tmp_path} cannot be written; choose another."
    (tmp_path / "out.usda").write_text("precious")
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == "--out out.usda is read-only; change its permissions, or choose another name."
    sentence = refused(clip, "--in-place", "--factor", 2)
    assert sentence == "--in-place in.usda is read-only; change its permissions, or choose another name."


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs a folder in which even root makes no files")
def test_output_that_the_system_refuses(clip, refused):
    sentence = refused(clip, "-o", "/proc/out.usda", "--factor", 2)
    assert sentence.startswith("/proc/out.usda cannot be written: ")


def test_output_name(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "out.fbx", "--factor", 2)
    assert sentence == "--out out.fbx: the name must end in .usd, .usda, .usdc, .usdz."
    sentence = refused(clip, "-o", tmp_path / "out.usdc", "--factor", 2, "--usdFormat", "usda")
    assert sentence == "--usdFormat usda needs an --out that ends in .usd, not out.usdc."


def test_output_is_the_input(tmp_path, clip, refused):
    (tmp_path / "link.usda").symlink_to(clip)
    (tmp_path / "sub").mkdir()
    os.link(clip, tmp_path / "hard.usda")
    for name in ("in.usda", "link.usda", "hard.usda", "sub/../in.usda"):
        sentence = refused(clip, "-o", tmp_path / name, "--factor", 2)
        assert sentence == f"--out {name} is the input itself; choose another name, or add --in-place."


def test_output_is_a_file_that_the_input_needs(tmp_path, clip, refused):
    shot = Sdf.Layer.CreateNew(str(tmp_path / "shot.usda"))
    shot.subLayerPaths.append("./in.usda")
    shot.Save()
    sentence = refused(tmp_path / "shot.usda", "-o", clip, "--factor", 2)
    assert sentence == "--out in.usda is a file that shot.usda needs; choose another name."


def test_in_place(tmp_path, clip, refused):
    sentence = refused(clip, "--in-place", "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == "--in-place changes in.usda, but --out is out.usda; leave one of them out."
    sentence = refused(clip, "--in-place", "--fps", 60, "--retime")
    assert sentence == "--retime cannot change a file in place; name another file with --out."
    (tmp_path / "in.usdz").write_bytes(b"")
    sentence = refused(tmp_path / "in.usdz", "--in-place", "--factor", 2)
    assert sentence == "in.usdz is a package and cannot be changed in place; name another file with --out."


@pytest.mark.parametrize("number", ["0", "-1", "nan", "1.5", "two", "1e3"])
def test_factor(tmp_path, clip, refused, number):
    sentence = refused(clip, "-o", tmp_path / "out.usda", f"--factor={number}", exit_code=2)
    assert sentence == f"--factor: must be a whole number of at least 1, not '{number}'."


@pytest.mark.parametrize("option", ["--fps", "--alpha", "--beta"])
@pytest.mark.parametrize("number", ["0", "-1", "nan", "inf", "much"])
def test_positive_numbers(tmp_path, clip, refused, option, number):
    rest = [] if option == "--fps" else ["--factor", 2]
    sentence = refused(clip, "-o", tmp_path / "out.usda", f"{option}={number}", *rest, exit_code=2)
    assert sentence == f"{option}: must be a positive number, not '{number}'."


@pytest.mark.parametrize("times", ["nan", "1,inf", "one", "", "no_such_file.txt"])
def test_times(tmp_path, clip, refused, times):
    sentence = refused(clip, "-o", tmp_path / "out.usda", f"--times={times}", exit_code=2)
    assert sentence == f"--times: must be comma-separated numbers or a file of numbers, not '{times}'."


def test_times_outside(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--times", "1,7")
    assert sentence == f"--times 7 is outside {ANIMATION}, which runs from 0 to 3."


def test_too_much(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 10**9)
    assert sentence == f"--factor would create 1.2e+10 rotations for {ANIMATION}; ask for fewer."


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "one of the arguments --factor --fps --times is required."),
        (["--factor", 2, "--fps", 60], "--fps: not allowed with argument --factor."),
        (["--factor", 2, "--retime"], "--retime needs --fps."),
    ],
)
def test_usage(tmp_path, clip, refused, arguments, sentence):
    assert refused(clip, "-o", tmp_path / "out.usda", *arguments, exit_code=2) == sentence
    assert refused(clip, "--factor", 2, exit_code=2) == "name the output with -o/--out."


def test_joint_styles(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2, "--joint", "leg*:alpha=2")
    assert sentence == "--joint leg* matches no joint; the file has hips, spine, arm."
    for text, words in {
        "arm": "must look like 'PATTERN:alpha=4,beta=.5,invariance=right,tension=0', not 'arm'",
        "arm:alpha=0": "alpha in 'arm:alpha=0' must be a positive number, not '0'",
        "arm:invariance=up": "invariance in 'arm:invariance=up' must be left or right, not 'up'",
        "arm:tension=3": "tension in 'arm:tension=3' must be a number from 0 to 2, not '3'",
        "arm:axes=1 2": "axes in 'arm:axes=1 2' must be three numbers with spaces between them, not '1 2'",
        "arm:gamma=2": "'gamma=2' in 'arm:gamma=2' must set alpha, beta, invariance, tension, translation-tension or "
        "axes",
    }.items():
        sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2, "--joint", text, exit_code=2)
        assert sentence == f"--joint: {words}."


def test_styles_beyond_what_geodesics_are_found_for(tmp_path, clip, refused):
    out = ["-o", tmp_path / "out.usda", "--factor", 2]
    for style in (["--alpha", "1e4", "--beta", "1e-4"], ["--joint", "hips:alpha=1e300"]):
        words = "invalid --alpha, --beta or --joint: The metric of joint 0 has the condition number 1e+"
        assert refused(clip, *out, *style).startswith(f"{ANIMATION}: {words}")


def test_metric(tmp_path, clip, refused):
    out = ["-o", tmp_path / "out.usda", "--factor", 2]
    sentence = refused(clip, *out, "--metric", "stored")
    assert sentence == f"{ANIMATION} stores no metric; leave --metric out, or choose the animation with --prim."
    sentence = refused(clip, *out, "--metric", tmp_path / "no.json")
    assert (
        sentence == "--metric no.json: there is no such file; use stored, identity, learn, a JSON file or a USD file."
    )
    (tmp_path / "bad.json").write_text("{")
    assert refused(clip, *out, "--metric", tmp_path / "bad.json").startswith("--metric bad.json: This is not JSON: ")
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    assert refused(clip, *out, "--metric", tmp_path / "binary.json").startswith("--metric binary.json: ")


def test_stored_metric_that_is_malformed(tmp_path, clip, refused):
    stage = Usd.Stage.Open(str(clip))
    prim = stage.GetPrimAtPath(ANIMATION)
    prim.CreateAttribute("geodesicMetric:alpha", Sdf.ValueTypeNames.DoubleArray).Set([1.0])
    stage.Save()
    sentence = refused(clip, "-o", tmp_path / "out.usda", "--factor", 2)
    assert sentence == f"{ANIMATION}: geodesicMetric:joints is missing; write the whole metric, or remove it."


def test_report(tmp_path, clip, refused):
    out = ["-o", tmp_path / "out.usda", "--factor", 2]
    sentence = refused(clip, *out, "--report", tmp_path / "no" / "r.json")
    assert sentence == "--report no/r.json: there is no folder no; make it first."
    assert refused(clip, *out, "--report", clip) == "--report in.usda is the input or the output; choose another name."


def test_blend_shapes_whose_number_changes_are_left(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["a"])
    set_samples(stage, "blendShapeWeights", (0, 1), [np.float32([[0]]), np.float32([[0], [1]])])
    stage.Save()
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert (code, err) == (
        0,
        f"warning: {ANIMATION}: blendShapeWeights at time code 1 has 2 values for 1 blendShapes; "
        "the weights are left as they are.\n",
    )


def test_missing_layers_are_warned_of(tmp_path, clip, run):
    shot = Sdf.Layer.CreateNew(str(tmp_path / "shot.usda"))
    shot.subLayerPaths = ["./nowhere.usda", "./in.usda"]
    shot.Save()
    code, _, err = run("upsample", tmp_path / "shot.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert code == 0
    assert err.startswith("warning: Could not load sublayer @") and "nowhere.usda@" in err
    assert len(err.splitlines()) == 1 and "0x" not in err
