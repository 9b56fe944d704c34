"""Input that downsample refuses, and sparse files that upsample does."""

import pytest
from pxr import Usd, Vt
from rigs import ANIMATION, make_rig, random_rotations


@pytest.fixture
def clip(tmp_path):
    """Forty samples of three joints that all move."""
    make_rig(tmp_path / "in.usda", codes=range(40), rotations=random_rotations(40, 3, size=0.8))
    return tmp_path / "in.usda"


@pytest.fixture
def refused(refuse):
    """Run downsample and check that it is refused politely; give the sentence."""
    return lambda *arguments, **more: refuse("downsample", *arguments, **more)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["--keys", "1"],
            f"{ANIMATION} cannot be downsampled with these options: --keys is 1, but 2 of 40 samples must stay",
        ),
        (["--keys", "41"], f"{ANIMATION} cannot be downsampled with these options: --keys is 41, but 2 of 40"),
        (["--keys", "3", "--keep", "5,6"], "--keys is 3, but 4 of 40 samples must stay"),
        (["--rate", ".3", "--keep", "5.5"], "--keep 5.5 is not the time code of a sample"),
        (["--keep-only", "5,5.5"], "--keep-only 5.5 is not the time code of a sample"),
        (["--rate", ".3", "--keep", "source"], "does not store the time codes of its source"),
        (["--rate", ".3", "--prim", "/Nowhere"], "--prim /Nowhere: there is no such prim"),
        (["--rate", ".3", "--picture", "{}/kept.gif"], "the name must end in .png, .svg, .pdf"),
        (["--rate", ".3", "--picture", "{}/no/kept.png"], "there is no folder"),
        (["--rate", ".3", "--report", "{}/in.usda"], "is the input or the output"),
    ],
)
def test_refusals(tmp_path, clip, refused, arguments, sentence):
    words = [word.format(tmp_path) for word in arguments]
    assert sentence in refused(clip, "-o", tmp_path / "out.usda", *words)


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["--rate", "1.5"],
        ["--rate", ".3", "--keys", "4"],
        ["--tolerance", "0"],
        ["--tolerance", "1", "--kind", "rot"],
        ["--rate", ".3", "--select", "uniform", "--keep", "4"],
        ["--keep-only", "4", "--rate", ".3"],
        ["--keep-only", "4", "--keep", "5"],
        ["--keep-only", "4", "--select", "uniform"],
        ["--rate", ".3", "--scheme", "squad", "--family", "spd"],
    ],
)
def test_usage(tmp_path, clip, refused, arguments):
    refused(clip, "-o", tmp_path / "out.usda", *arguments, exit_code=2)


def test_nothing_to_choose_from(tmp_path, refused):
    make_rig(tmp_path / "in.usda", codes=(0,))
    sentence = refused(tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--rate", ".3")
    assert sentence == "in.usda has no skeletal animation with at least two samples."


def test_times_source_needs_a_sparse_file(tmp_path, clip, refuse):
    sentence = refuse("upsample", clip, "-o", tmp_path / "out.usda", "--times", "source")
    assert "does not store the time codes of its source" in sentence


def test_broken_source_time_codes(tmp_path, clip, run, refuse):
    assert run("downsample", clip, "-o", tmp_path / "sparse.usda", "--keys", "6", "--scheme", "slerp")[0] == 0
    stage = Usd.Stage.Open(str(tmp_path / "sparse.usda"))
    stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:sourceTimeCodes").Set(Vt.DoubleArray([3.0, 1.0]))
    stage.GetRootLayer().Save()
    sentence = refuse("upsample", tmp_path / "sparse.usda", "-o", tmp_path / "out.usda", "--times", "source")
    assert "must hold increasing numbers" in sentence
