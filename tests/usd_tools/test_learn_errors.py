"""Bad input to learn: one sentence, an exit code, nothing written, the input untouched."""

import os
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd
from rigs import ANIMATION, make_rig, random_rotations, set_samples


@pytest.fixture
def refused(refuse):
    """Run learn and check that it is refused politely; give the sentence."""
    return partial(refuse, "learn")


@pytest.fixture
def clip(tmp_path):
    """A good file."""
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=random_rotations(20, 3))
    return tmp_path / "in.usda"


@pytest.fixture(params=["out.usda", "out.json"])
def out(request, tmp_path):
    """Both kinds of output."""
    return ["-o", tmp_path / request.param]


def test_one_segment(clip, out, refused):
    sentence = refused(clip, *out, "--rate", 0.1)
    assert sentence == "--rate 0.1 keeps 2 of the 20 samples of in.usda, which is one segment; use at least 0.15."


def test_every_sample_a_key(clip, out, refused):
    sentence = refused(clip, *out, "--rate", 0.99)
    assert sentence == "--rate 0.99 keeps all 20 samples of in.usda; use a smaller --rate."


def test_no_motion(tmp_path, out, refused):
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=np.repeat(random_rotations(1, 3), 20, axis=0))
    sentence = refused(tmp_path / "in.usda", *out)
    assert sentence == f"in.usda: no joint of {ANIMATION} turns, so there is nothing to learn."


@pytest.mark.parametrize("count", [2, 3])
def test_few_samples(tmp_path, out, refused, count):
    make_rig(tmp_path / "in.usda", codes=range(count))
    sentence = refused(tmp_path / "in.usda", *out)
    assert sentence == f"in.usda: {ANIMATION} has {count} samples, too few to learn from; at least 4 are needed."


def test_few_samples_between_blocks(tmp_path, out, refused):
    poses = list(random_rotations(6, 3))
    poses[2] = None
    make_rig(tmp_path / "in.usda", codes=range(6), rotations=poses)
    sentence = refused(tmp_path / "in.usda", *out)
    assert sentence.startswith(f"in.usda: {ANIMATION} has 3 samples between value blocks, steps and cuts, too few")


def test_no_sampled_rotations(tmp_path, out, refused):
    make_rig(tmp_path / "in.usda", codes=(0,), translations=None)
    sentence = refused(tmp_path / "in.usda", *out)
    assert sentence == f"in.usda: {ANIMATION} has no animated rotations, so there is nothing to learn."


def test_not_a_number(tmp_path, out, refused):
    rotations = random_rotations(20, 3)
    rotations[7, 1] = np.nan
    make_rig(tmp_path / "in.usda", codes=range(20), rotations=rotations)
    sentence = refused(tmp_path / "in.usda", *out)
    words = "rotations has a value that is not a finite number at time code 7; usd_tools.repair fills it in."
    assert sentence == f"in.usda: {ANIMATION}: {words}"


def test_other_rigs(tmp_path, clip, refused, run):
    joints = ["hips", "hips/spine"]
    make_rig(tmp_path / "less.usda", codes=range(20), rotations=random_rotations(20, 2), joints=joints)
    make_rig(tmp_path / "dog.usda", codes=range(20), rotations=random_rotations(20, 2), joints=["tail", "tail/tip"])
    sentence = refused(clip, tmp_path / "less.usda", "-o", tmp_path / "o.json")
    assert sentence == (
        "less.usda has a different rig than in.usda: it lacks 1 of 3 joints, such as arm; "
        "leave it out, or add --skip-mismatched."
    )
    sentence = refused(clip, tmp_path / "dog.usda", "-o", tmp_path / "o.json")
    assert sentence.startswith("dog.usda has no joint in common with in.usda; ")
    everything = [clip, tmp_path / "less.usda", tmp_path / "dog.usda"]
    code, _, err = run("learn", *everything, "-o", tmp_path / "o.json", "--skip-mismatched")
    assert (code, err.count("warning: skipped: ")) == (0, 2)


def test_corpus_of_nothing(tmp_path, refused):
    (tmp_path / "folder").mkdir()
    sentence = refused(tmp_path / "folder", "-o", tmp_path / "o.json")
    assert sentence == "folder contains no USD file, nor do its subfolders."
    for name in ("a.usda", "b.usda"):
        (tmp_path / "folder" / name).write_text("hello")
    sentence = refused(tmp_path / "folder", "-o", tmp_path / "o.json")
    assert sentence == "None of the 2 files has an animation to learn from; see the warnings."


def test_several_files_make_no_layer(tmp_path, clip, refused):
    for inputs in ([clip, clip], [tmp_path]):
        sentence = refused(*inputs, "-o", tmp_path / "o.usda")
        assert sentence == (
            "--out o.usda extends one file; to learn one metric from several files, use an --out that ends in .json."
        )


def test_unknown_prim(tmp_path, clip, out, refused):
    sentence = refused(clip, *out, "--prim", "/Nowhere")
    assert sentence.startswith("--prim /Nowhere: there is no such prim in in.usda; ")


def test_output(tmp_path, clip, out, refused, monkeypatch):
    name = out[1].name
    sentence = refused(clip, "-o", tmp_path / "no" / name)
    assert sentence == f"--out no/{name}: there is no folder no; make it first."
    sentence = refused(clip, *out, "--report", clip)
    assert sentence in (
        "--report in.usda is the input or the output; choose another name.",
        "--report in.usda is an input; choose another name.",
    )
    monkeypatch.setattr(os, "access", lambda path, mode: mode == os.R_OK)
    sentence = refused(clip, *out)
    assert sentence == f"--out {name}: the folder {tmp_path} cannot be written; choose another."


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs a folder in which even root makes no files")
def test_output_that_the_system_refuses(clip, refused):
    assert refused(clip, "-o", "/proc/out.json").startswith("/proc/out.json cannot be written: ")


def test_output_name(tmp_path, clip, refused):
    sentence = refused(clip, "-o", tmp_path / "out.fbx")
    assert sentence == "--out out.fbx: the name must end in .usd, .usda, .usdc, .usdz, .json."
    sentence = refused(clip, "-o", clip)
    assert sentence == "--out in.usda is the input itself; choose another name, or add --in-place."
    sentence = refused(clip, "-o", tmp_path / "out.json", "--flatten")
    assert sentence == "--flatten needs a USD file, but --out is out.json; leave one of them out."


@pytest.mark.parametrize("rate", ["0", "1", "-0.1", "nan", "30%"])
def test_rate(clip, out, refused, rate):
    sentence = refused(clip, *out, f"--rate={rate}", exit_code=2)
    assert sentence == f"--rate: must be a number above 0 and below 1, not '{rate}'."


@pytest.mark.parametrize("option", ["--trials", "--cpus", "--seed"])
def test_whole_numbers(clip, out, refused, option):
    sentence = refused(clip, *out, f"{option}=-1", exit_code=2)
    assert sentence == f"{option}: must be a whole number of at least {0 if option == '--seed' else 1}, not '-1'."


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--trials", 5], "--trials goes with --search tpe or tpe-joint."),
        (["--folder", "f", "--search", "tpe"], "--folder goes with --search tpe-joint."),
        (["--wandb", "p"], "--wandb goes with --search tpe-joint."),
        (
            ["--search", "tpe-joint", "--folder", "f", "--purpose", "predict"],
            "--folder and --resume hold one search, but --purpose predict runs several.",
        ),
        (["--folder", "f", "--resume", "g"], "--resume: not allowed with argument --folder."),
    ],
)
def test_usage(clip, out, refused, arguments, sentence):
    assert refused(clip, *out, *arguments, exit_code=2) == sentence
    assert refused(clip, exit_code=2) == "name the output with -o/--out."


@pytest.mark.parametrize("search", ["tpe", "tpe-joint"])
def test_tpe_without_its_extra(clip, out, refused, monkeypatch, search):
    monkeypatch.setitem(sys.modules, "hyperopt", None)
    sentence = refused(clip, *out, "--search", search)
    assert sentence == "This needs hyperopt, which is not installed; run: pip install 'geomstats-anim[tune]'"


def test_no_cluster(clip, out, refused):
    pytest.importorskip("ray")
    sentence = refused(clip, *out, "--search", "tpe-joint", "--address", "127.0.0.1:1")
    assert sentence.startswith("There is no Ray cluster at 127.0.0.1:1 (")


def test_nothing_to_resume(tmp_path, clip, out, refused):
    pytest.importorskip("ray")
    sentence = refused(clip, *out, "--search", "tpe-joint", "--resume", tmp_path / "nowhere")
    assert sentence.startswith("nowhere holds no search to resume")


def test_one_folder_for_two_searches(tmp_path, clip, refused):
    stage = Usd.Stage.Open(str(clip))
    stage.DefinePrim("/Rig/Other", "SkelAnimation").GetAttribute("joints").Set(["hips"])
    set_samples(stage, "rotations", range(20), random_rotations(20, 1), "/Rig/Other")
    stage.Save()
    sentence = refused(clip, "-o", tmp_path / "o.usda", "--search", "tpe-joint", "--folder", tmp_path / "f")
    assert sentence == "A folder holds one search, but in.usda has 2 animations; choose one with --prim."


def test_upsample_learns_for_its_scheme_only(tmp_path, clip, refuse):
    sentence = refuse(
        "upsample", clip, "-o", tmp_path / "o.usda", "--factor", 2, "--metric", "learn", "--scheme", "linear"
    )
    assert sentence == "--metric learn needs --scheme geodesic or geodesic-spline, not linear."


def test_no_cluster_for_one_clip(tmp_path, clip, refuse):
    sentence = refuse("learn", clip, "-o", tmp_path / "o.usda", "--address", "127.0.0.1:1")
    assert sentence.startswith("There is no Ray cluster at 127.0.0.1:1")


def test_workers_for_one_clip_are_not_used(tmp_path, clip, run):
    code, _, err = run("learn", clip, "-o", tmp_path / "o.usda", "--cpus", 2)
    assert code == 0
    assert err == "warning: --cpus is for several clips; in.usda is learned in this process.\n"
