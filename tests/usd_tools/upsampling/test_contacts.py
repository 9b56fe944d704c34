"""Laws of `upsample --contacts`."""

import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom
from rigs import bits, read
from walk_files import write_walk
from walker import FEET, JOINTS, walk

from geomstats_anim import rotations as quat
from geomstats_anim.contacts import find_contacts, skating
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.new_file import ANIMATION, ROOT
from usd_tools.skel.resampling import animation_of


def motion(path):
    stage = Usd.Stage.Open(str(path))
    return animation_of(read_clip(find_animations(stage)[0]))


def skate(path, original):
    contacts = [find_contacts(original, np.array([0.0, 1.0, 0.0]))]
    return skating([motion(path)], [original], contacts).skate


@pytest.fixture
def folder(tmp_path, run):
    """Write a walk of a sixth of its frames, and in-between it with contacts and without."""
    original = write_walk(tmp_path / "in.usda", step=6)
    for name, options in (("plain", ()), ("feet", ("--contacts", "--report", tmp_path / "report.json"))):
        code, out, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / f"{name}.usda", "--factor", 6, *options)
        assert (code, err) == (0, "")
    return tmp_path, original, out


def test_feet_skate_less_and_samples_stay(folder):
    tmp_path, original, _ = folder
    assert skate(tmp_path / "feet.usda", original) < 0.6 * skate(tmp_path / "plain.usda", original)
    for name in ("rotations", "translations"):
        codes, values = read(tmp_path / "in.usda", name, str(ANIMATION))
        plain_codes, plain = read(tmp_path / "plain.usda", name, str(ANIMATION))
        new_codes, new = read(tmp_path / "feet.usda", name, str(ANIMATION))
        assert new_codes == plain_codes
        assert bits([new[new_codes.index(code)] for code in codes]) == bits(values)
        free = [joint for joint in range(len(JOINTS)) if joint not in (0, 1, 2, 3, 5, 6, 7)]
        np.testing.assert_array_equal(np.array(new)[:, free], np.array(plain)[:, free])


def test_what_was_kept_is_said(folder):
    tmp_path, _, out = folder
    assert "contacts: foot_l, toe_l, foot_r, toe_r stay planted" in " ".join(out.split())
    (report,) = json.loads((tmp_path / "report.json").read_text())["animations"]
    contacts = report["contacts"]
    assert contacts["joints"] == [JOINTS[foot] for foot in FEET]
    assert contacts["kept"] >= 8
    assert contacts["left"] == 0
    assert 0.1 < contacts["largest_cm"] < 10.0
    assert 0.1 < contacts["largest_degrees"] < 30.0


@pytest.fixture
def library(tmp_path, run):
    """Learn from walks of other strides."""
    paths = [tmp_path / f"walk_{stride}.usda" for stride in (0.6, 0.8)]
    for path in paths:
        write_walk(path, step=1, seconds=1.2, stride=float(path.stem.split("_")[1]))
    out = tmp_path / "rig.inbetween"
    assert run("learn", *paths, "--purpose", "predict", "--library", "-o", out)[0] == 0
    return out


def test_feet_stay_planted_on_the_curve_of_a_library(folder, library, run):
    tmp_path, original, _ = folder
    arguments = ("upsample", tmp_path / "in.usda", "--factor", 6, "--library", library)
    assert run(*arguments, "-o", tmp_path / "learned.usda")[0] == 0
    report = ("--report", tmp_path / "both.json")
    code, out, err = run(*arguments, "-o", tmp_path / "both.usda", "--contacts", *report)
    assert (code, err) == (0, "")
    words = " ".join(out.split())
    assert "the library rig.inbetween helps" in words
    assert "contacts: foot_l, toe_l, foot_r, toe_r stay planted" in words
    (animation,) = json.loads((tmp_path / "both.json").read_text())["animations"]
    assert animation["scheme"] == "learned"
    assert max(each["share"] for each in animation["library"]["shares"]) > 0.5
    assert animation["contacts"]["kept"] >= 8
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "both.usda"))
    said = layer.customLayerData["geomstats_anim"]["settings"]
    assert (said["contacts"], said["library"]) == (True, "rig.inbetween")
    assert skate(tmp_path / "both.usda", original) < 0.6 * skate(tmp_path / "learned.usda", original)
    codes, values = read(tmp_path / "in.usda", "rotations", str(ANIMATION))
    (new_codes, both), (_, learned), (_, feet) = (
        read(tmp_path / f"{name}.usda", "rotations", str(ANIMATION)) for name in ("both", "learned", "feet")
    )
    assert bits([both[new_codes.index(code)] for code in codes]) == bits(values)
    assert bits(both) != bits(learned) and bits(both) != bits(feet)


def test_units_and_axes_change_nothing(tmp_path, run, folder):
    _, _, _ = folder
    write_walk(tmp_path / "z.usda", step=6, up="Z", metres=0.01)
    assert run("upsample", tmp_path / "z.usda", "-o", tmp_path / "z6.usda", "--factor", 6, "--contacts")[0] == 0
    turns, expected = (motion(tmp_path / name).rotations for name in ("z6.usda", "feet.usda"))
    assert quat.distance(turns[:, 1:], expected[:, 1:]).max() < 2e-3  # where feet are planted, to single precision
    assert np.median(quat.distance(turns[:, 1:], expected[:, 1:])) < 1e-6


def test_feet_that_lift_between_samples_are_not_touched(tmp_path, run):
    write_walk(tmp_path / "in.usda", step=72)  # more than a step apart
    for name, options in (("plain", ()), ("feet", ("--contacts",))):
        run("upsample", tmp_path / "in.usda", "-o", tmp_path / f"{name}.usda", "--factor", 9, *options)
    for name in ("rotations", "translations"):
        plain, feet = (read(tmp_path / f"{each}.usda", name, str(ANIMATION)) for each in ("plain", "feet"))
        assert plain[0] == feet[0]
        assert bits(plain[1]) == bits(feet[1])


def test_what_is_out_of_reach_is_left(tmp_path, run):
    write_walk(tmp_path / "in.usda", step=6)
    arguments = ("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--contacts")
    report = ("--report", tmp_path / "report.json")
    assert run(*arguments, "--contact-reach", 0.0001, *report)[0] == 0
    (animation,) = json.loads((tmp_path / "report.json").read_text())["animations"]
    assert animation["contacts"]["joints"] == []
    assert animation["contacts"]["left"] >= 8


def test_a_reach_without_contacts_is_refused(tmp_path, run):
    write_walk(tmp_path / "in.usda")
    arguments = ("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    code, _, err = run(*arguments, "--contact-reach", 3)
    assert code == 2
    assert "--contact-reach needs --contacts" in err
    code, _, err = run(*arguments, "--contacts", "--contact-reach", -3)
    assert code == 2
    assert "positive" in err


def test_a_cycle_keeps_its_feet_on_the_ground(tmp_path, run):
    write_walk(tmp_path / "in.usda", step=6, seconds=1.0)
    for name, options in (("plain", ()), ("feet", ("--contacts",))):
        code, _, err = run(
            "upsample", tmp_path / "in.usda", "-o", tmp_path / f"{name}.usda", "--factor", 6, "--loop", *options
        )
        assert (code, err) == (0, "")
    original, _ = walk(1.0)
    assert read(tmp_path / "feet.usda", prim=str(ANIMATION))[0] == read(tmp_path / "plain.usda", prim=str(ANIMATION))[0]
    assert skate(tmp_path / "feet.usda", original) < skate(tmp_path / "plain.usda", original)


def test_channels_with_other_samples_are_left_and_named(tmp_path, run):
    write_walk(tmp_path / "in.usda")
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    stage.GetAttributeAtPath(ANIMATION.AppendProperty("translations")).ClearAtTime(8.0)
    stage.Save()
    arguments = ("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--contacts")
    code, out, err = run(*arguments)
    assert code == 0
    assert "have samples at different times; --contacts changes nothing there" in " ".join(err.split())
    assert "contacts: nothing is planted on the ground" in " ".join(out.split())


def test_transforms_that_move_the_character_are_named(tmp_path, run):
    write_walk(tmp_path / "in.usda")
    stage = Usd.Stage.Open(str(tmp_path / "in.usda"))
    op = UsdGeom.Xformable(stage.GetPrimAtPath(ROOT)).AddTranslateOp()
    for code in (0.0, 140.0):
        op.Set(Gf.Vec3d(code, 0.0, 0.0), code)
    stage.Save()
    arguments = ("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--contacts")
    code, _, err = run(*arguments)
    assert code == 0
    assert "transforms move the character; --contacts changes nothing there" in " ".join(err.split())
