"""`learn --library` and `upsample --library`, as their users run them."""

import hashlib
import json

import numpy as np
import pytest
from gait_files import write
from gaits import gait
from pxr import Usd, UsdGeom, UsdSkel

from geomstats_anim.learning.library.storage import load_library
from usd_tools import learn, upsample
from usd_tools.libraries.help import help_sentence
from usd_tools.metrics.attributes import read_metric

LEARN = ["--purpose", "predict", "--library"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Hold a library of four gaits, and the keys of another."""
    folder = tmp_path_factory.mktemp("library")
    clips = [str(write(folder / f"walk_{seed}.usdc", gait(seed, 60))) for seed in range(1, 5)]
    assert learn.main([*clips, *LEARN, "-o", str(folder / "rig.inbetween")]) == 0
    write(folder / "keys.usdc", gait(100, 81), step=8)
    return folder


def test_the_layer_names_the_file_and_the_shares(folder, tmp_path, capsys):
    out, report = tmp_path / "dense.usda", tmp_path / "report.json"
    library = ["--library", str(folder / "rig.inbetween")]
    assert (
        upsample.main([str(folder / "keys.usdc"), "-o", str(out), "--factor", "8", *library, "--report", str(report)])
        == 0
    )
    printed = capsys.readouterr().out
    assert "the library rig.inbetween helps, for motions like those in it: torso" in printed
    (animation,) = json.loads(report.read_text())["animations"]
    used = animation["library"]
    assert animation["scheme"] == "learned"
    assert used["sha256"] == hashlib.sha256((folder / "rig.inbetween").read_bytes()).hexdigest()
    assert {(each["part"], each["joint"]) for each in used["shares"]} == {
        ("torso", "hips"), ("arm", "arm_L"), ("arm", "arm_R"), ("leg", "thigh_L"), ("leg", "thigh_R")
    }  # fmt: skip
    assert max(each["share"] for each in used["shares"]) > 0.5
    stage = Usd.Stage.Open(str(out))
    metric = read_metric(stage.GetPrimAtPath("/Rig/Anim"))
    assert metric.scheme == "learned"
    assert dict(metric.provenance["library"]) == used


def test_it_is_nearer_to_the_clip_than_the_spline_and_keeps_its_keys(folder, tmp_path):
    errors = {}
    for name, options in (("spline", []), ("learned", ["--library", str(folder / "rig.inbetween")])):
        out = tmp_path / f"{name}.usda"
        assert upsample.main([str(folder / "keys.usdc"), "-o", str(out), "--factor", "8", *options]) == 0
        stages = [Usd.Stage.Open(str(path)) for path in (out, folder / "keys.usdc")]
        motion, source = (UsdSkel.Animation(each.GetPrimAtPath("/Rig/Anim")).GetRotationsAttr() for each in stages)
        assert all(motion.Get(code) == source.Get(code) for code in range(0, 81, 8))
        got = np.array([motion.Get(code) for code in range(81)], dtype=np.float64)
        dots = np.clip(abs((got * gait(100, 81).rotations).sum(axis=-1)), 0.0, 1.0)
        errors[name] = np.arccos(dots).mean()
    assert errors["learned"] < 0.75 * errors["spline"]


def test_a_layer_made_with_a_library_needs_it_again(folder, tmp_path, capsys):
    first, second = tmp_path / "first.usda", tmp_path / "second.usda"
    library = ["--library", str(folder / "rig.inbetween")]
    assert upsample.main([str(folder / "keys.usdc"), "-o", str(first), "--factor", "2", *library]) == 0
    assert upsample.main([str(first), "-o", str(second), "--factor", "2"]) == 1
    assert "needs the library rig.inbetween; give it as --library" in capsys.readouterr().err
    assert upsample.main([str(first), "-o", str(second), "--factor", "2", "--scheme", "geodesic-spline"]) == 0
    stage = Usd.Stage.Open(str(second))
    metric = read_metric(stage.GetPrimAtPath("/Rig/Anim"))
    assert metric.scheme == "geodesic-spline" and "library" not in metric.provenance
    assert (metric.tension == 1.0).all()


def test_what_was_learned_from_is_named(folder):
    library = load_library((folder / "rig.inbetween").read_bytes())
    assert list(library.provenance["files"]) == [f"walk_{seed}.usdc" for seed in range(1, 5)]
    sums = [hashlib.sha256((folder / f"walk_{seed}.usdc").read_bytes()).hexdigest() for seed in range(1, 5)]
    assert list(library.provenance["sha256"]) == sums


def test_too_few_keys_are_splined_in_words(folder, tmp_path, capsys):
    write(tmp_path / "few.usdc", gait(100, 25), step=8)
    out = [str(tmp_path / "few.usdc"), "-o", str(tmp_path / "out.usda"), "--factor", "8"]
    assert upsample.main([*out, "--library", str(folder / "rig.inbetween")]) == 0
    assert "the library rig.inbetween does not help this clip; the spline is used." in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--scheme", "learned"], 2, "--scheme learned needs --library FILE"),
        (["--scheme", "slerp", "--library", "RIG"], 2, "--library is for --scheme learned, not slerp"),
        (["--library", "nowhere.inbetween"], 1, "there is no such file; make one with usd_tools.learn"),
        (["--library", "KEYS"], 1, "no library of in-betweens"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(folder, tmp_path, capsys, options, code, words):
    files = {"RIG": str(folder / "rig.inbetween"), "KEYS": str(folder / "keys.usdc")}
    out = tmp_path / "out.usda"
    arguments = [str(folder / "keys.usdc"), "-o", str(out), "--factor", "2", *(files.get(o, o) for o in options)]
    try:
        assert upsample.main(arguments) == code
    except SystemExit as error:
        assert error.code == code
    assert words in " ".join(capsys.readouterr().err.split())
    assert not out.exists()


def test_another_rig_and_another_axis_are_refused(folder, tmp_path, capsys):
    write(tmp_path / "z.usdc", gait(100, 81), up=UsdGeom.Tokens.z, step=8)
    library = ["--library", str(folder / "rig.inbetween")]
    assert upsample.main([str(tmp_path / "z.usdc"), "-o", str(tmp_path / "o.usda"), "--factor", "2", *library]) == 1
    assert "another axis is up" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--library", "-o", "x.inbetween"], 2, "--library needs --purpose predict"),
        ([*LEARN, "-o", "x.usda"], 2, "--library needs an --out that ends in .inbetween"),
        ([*LEARN, "-o", "x.inbetween", "--kind", "rot"], 2, "--kind is for a metric"),
        ([*LEARN, "-o", "x.inbetween", "--address", "127.0.0.1:1"], 1, "no Ray cluster at 127.0.0.1:1"),
    ],
)
def test_options_of_learn_that_do_not_go_together_are_refused(
    folder, tmp_path, capsys, options, code, words, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    try:
        assert learn.main([str(folder / "walk_1.usdc"), *options]) == code
    except SystemExit as error:
        assert error.code == code
    assert words in " ".join(capsys.readouterr().err.split())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_workers_make_the_same_bytes(folder, tmp_path):
    pytest.importorskip("ray")
    clips = [str(folder / f"walk_{seed}.usdc") for seed in range(1, 5)]
    assert learn.main([*clips, *LEARN, "--cpus", "2", "-o", str(tmp_path / "rig.inbetween")]) == 0
    assert (tmp_path / "rig.inbetween").read_bytes() == (folder / "rig.inbetween").read_bytes()


def test_shares_are_said_to_two_decimals():
    shares = [("torso", 0.0), ("arm", 1.0), ("arm", 0.8), ("leg", 0.076), ("leg", 0.0758)]
    library = {"file": "rig.inbetween", "shares": [{"part": part, "share": share} for part, share in shares]}
    assert help_sentence(library).endswith(": torso 0, arms 1 and .8, legs .08.")
