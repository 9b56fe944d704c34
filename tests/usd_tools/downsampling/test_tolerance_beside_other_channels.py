"""A tolerance holds for the motion as a whole, also where a channel that is not thinned has a part in it."""

import json

import numpy as np
import pytest
from rigs import make_rig
from scipy.spatial.transform import Rotation

COUNT, TOLERANCE, BLOCK = 60, 0.1, 40


@pytest.mark.parametrize("seed", range(3))
def test_bones_that_grow_after_the_first_sample(tmp_path, run, seed):
    rng = np.random.default_rng(seed)
    time = np.arange(COUNT)[:, None, None] / 10.0
    turns = 0.5 * np.sin(time * rng.uniform(0.5, 1.5, (1, 3, 3)) + rng.uniform(0.0, 6.0, (1, 3, 3)))
    rotations = list(Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(COUNT, 3, 4).astype(np.float32))
    rotations[BLOCK] = None  # so that translations, which have no block, are kept whole
    bones = np.tile(np.float32([0.0, 1.0, 0.0]), (COUNT, 3, 1))
    bones *= np.where(np.arange(COUNT) < 1, 10.0, 20.0).astype(np.float32)[:, None, None]
    make_rig(tmp_path / "in.usda", codes=range(COUNT), rotations=rotations, translations=bones)
    report = tmp_path / "report.json"
    words = ["--tolerance", TOLERANCE, "--report", report]
    code, _, err = run("downsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", *words)
    assert code == 0, err
    assert "translations change and are kept whole" in err
    (animation,) = json.loads(report.read_text())["animations"]
    assert 0.0 < animation["rebuilt"]["centimetres"]["largest"] <= TOLERANCE
