"""Every sample of a file is read once, whatever a command does with it."""

import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from pxr import Sdf, UsdSkel
from rigs import ANIMATION, make_rig, random_rotations, set_samples


@pytest.mark.parametrize(
    ("verb", "options"),
    [("inspect", []), ("upsample", ["--factor", 3, "--alpha", 2]), ("learn", ["--rate", 0.5])],
)
def test_once(tmp_path, run, monkeypatch, verb, options):
    stage = make_rig(tmp_path / "in.usda", codes=range(12), rotations=random_rotations(12, 3))
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["smile"])
    set_samples(stage, "blendShapeWeights", range(5), np.float32([[[0]], [[1]], [[0]], [[1]], [[0]]]))
    stage.Save()
    del stage
    counts = Counter()
    query = Sdf.Layer.QueryTimeSample

    def counted(layer, path, code):
        counts[str(path)] += 1
        return query(layer, path, code)

    monkeypatch.setattr(Sdf.Layer, "QueryTimeSample", counted)
    out = [] if verb == "inspect" else ["-o", tmp_path / "out.usda"]
    assert run(verb, tmp_path / "in.usda", *out, *options)[0] == 0
    names = {"rotations": 12, "translations": 12, "blendShapeWeights": 5}
    assert counts == {f"{ANIMATION}.{name}": count for name, count in names.items()}


def test_reading_imports_nothing_slow(tmp_path):
    make_rig(tmp_path / "in.usda")
    program = (
        "import sys; from usd_tools import inspect; inspect.main(sys.argv[1:]);"
        "loaded = {'numba', 'scipy', 'geomstats', 'geomstats_anim.learning', 'usd_tools.learning'} & set(sys.modules);"
        "assert not loaded, loaded"
    )
    subprocess.run([sys.executable, "-c", program, tmp_path / "in.usda"], check=True, stdout=subprocess.DEVNULL)
