"""One of several animations that is broken is left as it is; quaternions of no length are fine where nothing moves."""

import numpy as np
import pytest
from pxr import Sdf, Usd
from real_files import needs_shared, real_file
from rigs import ANIMATION, bits, make_rig, random_rotations, read, set_samples

OPTIONS = {"upsample": ["--factor", 2], "downsample": ["--rate", 0.5], "learn": ["--rate", 0.5]}
OTHER = "/Rig/Other"


def make_pair(path, breaks):
    """A rig with two animations, of which the second is broken."""
    stage = make_rig(path, codes=range(12), rotations=random_rotations(12, 3))
    Sdf.CopySpec(stage.GetRootLayer(), ANIMATION, stage.GetRootLayer(), OTHER)
    values = random_rotations(12, 3)
    if breaks == "size":
        set_samples(stage, "rotations", [5], [values[0, :2]], OTHER)
    elif breaks == "length":
        values[5, 1] = 0.0
        set_samples(stage, "rotations", range(12), values, OTHER)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize("verb", OPTIONS)
@pytest.mark.parametrize("breaks", ["size", "length"])
def test_one_that_is_broken_is_left_as_it_is(tmp_path, run, refuse, verb, breaks):
    make_pair(tmp_path / "in.usda", breaks)
    before = read(tmp_path / "in.usda", prim=OTHER)
    code, _, err = run(verb, tmp_path / "in.usda", "-o", tmp_path / "out.usda", *OPTIONS[verb])
    assert code == 0
    assert err.count(OTHER) == 1 and err.count("it is left as it is (--prim chooses animations).") == 1
    after = read(tmp_path / "out.usda", prim=OTHER)
    assert after[0] == before[0] and bits(after[1]) == bits(before[1])
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    done = [stage.GetPrimAtPath(prim).HasAttribute("geodesicMetric:alpha") for prim in (ANIMATION, OTHER)]
    assert done == [True, False]
    sentence = refuse(verb, tmp_path / "in.usda", "-o", tmp_path / "other.usda", "--prim", OTHER, *OPTIONS[verb])
    remedy = {"size": "repair the file.", "length": "usd_tools.repair fills it in."}[breaks]
    assert OTHER in sentence and sentence.endswith(remedy)


@pytest.mark.parametrize("verb", OPTIONS)
def test_quaternions_of_no_length_where_nothing_moves(tmp_path, run, verb):
    values = random_rotations(12, 3)
    values[:, 1] = 0.0
    make_rig(tmp_path / "in.usda", codes=range(12), rotations=values)
    code, _, err = run(verb, tmp_path / "in.usda", "-o", tmp_path / "out.usda", *OPTIONS[verb])
    assert (code, err) == (0, "")
    _, written = read(tmp_path / "out.usda")
    assert (np.array(written)[:, 1] == 0.0).all()


@needs_shared
@pytest.mark.parametrize("verb", OPTIONS)
def test_a_library_of_strangers(tmp_path, run, verb):
    code, _, err = run(
        verb, real_file("strangers/library_one_broken.usda"), "-o", tmp_path / "out.usda", *OPTIONS[verb]
    )
    assert code == 0 and "/Root/Broken: " in err and "--prim" in err
