"""What inspect tells."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel
from real_files import needs_shared, real_file
from rigs import ANIMATION, SKELETON, make_rig, random_rotations, set_samples


def test_json(tmp_path, inspected):
    rotations = random_rotations(4, 3)
    rotations[2:, 1] *= -1.0
    rotations[3, 2] *= 2.0
    rotations[0, 0], rotations[1:, 0] = [0, 0, 0, 1], [0, 1, 0, 0.1]
    make_rig(tmp_path / "in.usda", codes=(10, 11, 12, 13), rotations=rotations, rate=30)
    told = inspected(tmp_path / "in.usda")
    assert (told["file"], told["layers"], told["up_axis"], told["meters_per_unit"]) == (
        "in.usda",
        ["in.usda"],
        "Z",
        0.01,
    )
    assert (told["time_codes_per_second"], told["frames_per_second"], told["start_time_code"]) == (30, None, None)
    skeleton = {"prim": SKELETON, "joints": 3, "animation": ANIMATION, "instance": False}
    # every joint rests 10 cm above its parent, and is bound 10 cm above the ground
    assert told["skeletons"] == [{**skeleton, "size": pytest.approx(0.2), "joints_off_bind_pose": 2}]
    (animation,) = told["animations"]
    assert (animation["prim"], animation["skeletons"], animation["joints"]) == (ANIMATION, [SKELETON], 3)
    assert (animation["samples"], animation["codes"], animation["samples_per_second"]) == (4, [10, 13], 30)
    np.testing.assert_allclose(animation["seconds"], [1 / 3, 13 / 30])
    assert animation["evenly_spaced"] is True
    step = animation["largest_step"]
    assert (step["joint"], step["start"], step["end"]) == ("hips", 10, 11)
    np.testing.assert_allclose(step["degrees"], 2 * np.degrees(np.arctan2(1, 0.1)), rtol=1e-6)
    assert animation["wide_steps"] == [step]
    assert (animation["sign_flips"], animation["not_unit_quaternions"]) == (1, 4)
    assert animation["channels"]["rotations"] == {"samples": 4, "value_blocks": 0, "held_gaps": 0, "from": "in.usda"}
    assert animation["channels"]["scales"]["samples"] == 0
    assert animation["metric"] is None
    assert "168.6 degrees" in told["warnings"][0]


def test_holds_steps_blocks_and_shapes(tmp_path, inspected):
    poses = random_rotations(3, 3)
    step = Usd.TimeCode.SafeStep()
    codes = (0, 1 - step, 1, 2, 3, 4)
    stage = make_rig(
        tmp_path / "in.usda", codes=codes, rotations=[poses[0], poses[0], poses[1], None, poses[2], poses[2]],
        translations=None,
    )  # fmt: skip
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["smile"])
    set_samples(stage, "blendShapeWeights", (0, 4), np.float32([[[0]], [[1]]]))
    stage.Save()
    (animation,) = inspected(tmp_path / "in.usda")["animations"]
    assert animation["stepped_pairs"] == 1
    assert animation["blend_shapes"] == 1
    assert animation["channels"]["rotations"] == {"samples": 6, "value_blocks": 1, "held_gaps": 2, "from": "in.usda"}
    assert animation["channels"]["blendShapeWeights"]["samples"] == 2


def test_table_loses_nothing_when_piped(tmp_path, run):
    long_name = "a_very_long_name_of_a_joint_" * 8
    make_rig(tmp_path / "in.usda", joints=[long_name, f"{long_name}/[red]{long_name}"])
    code, out, _ = run("inspect", tmp_path / "in.usda")
    assert code == 0
    assert long_name in out and "…" not in out
    for words in (f"Skeleton {SKELETON}", f"Animation {ANIMATION}", "24 samples per second", "stored metric"):
        assert words in out


def test_stored_metric_is_told(tmp_path, run, inspected):
    make_rig(tmp_path / "in.usda")
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--alpha", 4)
    (animation,) = inspected(tmp_path / "out.usda")["animations"]
    assert animation["metric"]["summary"] == (
        "geodesic-spline, 3 joints (3 left, 0 right), diagonal, alpha 4, beta 1, tension 1"
    )
    assert animation["metric"]["provenance"] == {"styles": ["*:alpha=4"]}


def test_malformed_animations_are_told_and_not_fatal(tmp_path, run, inspected):
    stage = make_rig(tmp_path / "in.usda")
    set_samples(stage, "rotations", [2], [random_rotations(1, 2)[0]])
    stage.Save()
    (animation,) = inspected(tmp_path / "in.usda")["animations"]
    assert animation["error"].endswith("has 2 values for 3 joints; repair the file.")
    assert run("inspect", tmp_path / "in.usda")[0] == 0


def test_library_and_binding_without_its_schema(tmp_path, inspected):
    stage = make_rig(tmp_path / "in.usda", bind=False)
    stage.GetPrimAtPath(SKELETON).CreateRelationship("skel:animationSource").SetTargets([ANIMATION])
    stage.Save()
    told = inspected(tmp_path / "in.usda")
    assert told["animations"][0]["skeletons"] == []
    assert told["warnings"] == [
        f"{SKELETON} has skel:animationSource {ANIMATION}, but SkelBindingAPI is not applied, so USD ignores it."
    ]


def test_errors(tmp_path, run):
    assert run("inspect", tmp_path / "no.usda") == (1, "", f"error: {tmp_path}/no.usda: there is no such file.\n")
    (tmp_path / "x.usda").write_text("hello")
    code, out, err = run("inspect", tmp_path / "x.usda")
    assert (code, out, err.count("error: ")) == (1, "", 1)
    Usd.Stage.CreateNew(str(tmp_path / "empty.usda")).Save()
    code, out, _ = run("inspect", tmp_path / "empty.usda")
    assert (code, "No skeletal animation." in out) == (0, True)


def test_output_that_nobody_reads_to_the_end(tmp_path):
    make_rig(tmp_path / "in.usda")
    command = f"{sys.executable} -m usd_tools.inspect {tmp_path / 'in.usda'} | true"
    done = subprocess.run(command, shell=True, cwd=Path(__file__).resolve().parents[2], capture_output=True, text=True)
    assert done.stderr == ""


def test_layers_are_in_order(tmp_path, inspected):
    """OpenUSD lists the layers of a stage in any order."""
    names = [f"{letter}.usda" for letter in "hgfedcba"]
    for name in names:
        make_rig(tmp_path / name)
    stage = Usd.Stage.CreateNew(str(tmp_path / "z.usda"))
    stage.GetRootLayer().subLayerPaths = [f"./{name}" for name in names]
    stage.Save()
    assert inspected(tmp_path / "z.usda")["layers"] == ["z.usda", *sorted(names)]


def test_a_range_that_misses_all_samples(tmp_path, inspected):
    stage = make_rig(tmp_path / "in.usda", codes=range(10, 14))
    sentence = "/Rig/Anim: the stage's range, 4800 to 4800, misses all samples, which are at 10 to 13; correct "
    for start, end, is_told in ((4800, 4800, True), (0, 9, True), (13, 20, False), (0, 100, False)):
        stage.SetStartTimeCode(start)
        stage.SetEndTimeCode(end)
        stage.Save()
        warnings = inspected(tmp_path / "in.usda")["warnings"]
        assert len(warnings) == is_told
        assert start != 4800 or warnings[0] == f"{sentence}startTimeCode and endTimeCode."


@pytest.mark.parametrize("names", [["Bip 1", "Bip 1/arm"], ["hips", "hips/arm.L"]])
def test_names_that_are_no_paths(tmp_path, run, inspected, names):
    make_rig(tmp_path / "in.usda", rotations=random_rotations(4, 2), joints=names)
    warnings = inspected(tmp_path / "in.usda")["warnings"]
    told = [warning for warning in warnings if "cannot be paths" in warning]
    bad = next(name for name in names if " " in name or "." in name)
    assert len(told) == 1 and told[0].startswith(SKELETON) and repr(bad) in told[0]
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert code == 0 and err.count(told[0]) == 1 and "Ill-formed" not in err


@needs_shared
@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("range_4800_4800", "/Root/Anim: the stage's range, 4800 to 4800, misses all samples, which are at 20 to 160"),
        ("names_with_spaces", "/Root/Skel: 2 joint names with spaces or dots, such as 'Bip001 Pelvis', cannot be"),
    ],
)
def test_what_to_beware_of_in_files_of_strangers(inspected, name, told):
    (warning,) = inspected(real_file(f"strangers/{name}.usda"))["warnings"]
    assert warning.startswith(told)


@pytest.mark.parametrize(("metres_per_unit", "is_doubtful"), [(0.01, False), (1.0, False), (1e-4, True), (10.0, True)])
def test_sizes_that_are_doubtful(tmp_path, inspected, metres_per_unit, is_doubtful):
    stage = make_rig(tmp_path / "in.usda")
    UsdGeom.SetStageMetersPerUnit(stage, metres_per_unit)
    stage.Save()
    told = inspected(tmp_path / "in.usda")
    assert told["skeletons"][0]["size"] == pytest.approx(20.0 * metres_per_unit)
    assert any("check metersPerUnit" in warning for warning in told["warnings"]) == is_doubtful


def test_the_table_names_the_joint_of_the_largest_step_by_its_short_name(tmp_path, run, inspected):
    turn = np.tile([0.0, 0.0, 0.0, 1.0], (2, 3, 1))
    turn[1, 2] = [np.sin(0.2), 0.0, 0.0, np.cos(0.2)]
    make_rig(tmp_path / "in.usda", codes=range(2), rotations=turn)
    (animation,) = inspected(tmp_path / "in.usda")["animations"]
    assert (animation["largest_step"]["joint"], animation["largest_step_joint"]) == ("hips/spine/arm", "arm")
    _, out, _ = run("inspect", tmp_path / "in.usda")
    assert "joint arm, time code 0 to 1" in out and "hips/spine/arm" not in out
