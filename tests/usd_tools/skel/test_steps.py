"""Steps: two samples nearer than a millisecond are a jump, unless everything is that near; nothing moves across."""

import json

import numpy as np
import pytest
from rigs import make_rig, random_rotations, read, set_samples

SCHEMES = ("slerp", "squad", "geodesic", "geodesic-spline")


def upsampled(run, folder, *words):
    code, _, err = run("upsample", folder / "in.usda", "-o", folder / "out.usda", *words)
    assert code == 0, err
    return read(folder / "out.usda")


def poses(count, seed=0):
    return random_rotations(count, 3, seed, size=0.8)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_what_is_before_a_step_does_not_know_what_is_after(tmp_path, run, scheme):
    codes = [0, 1, 2, 2 + 1e-4, 3, 4, 5]
    outputs = []
    for seed in (1, 2):
        after = np.concatenate([poses(3), poses(4, seed)])
        make_rig(tmp_path / "in.usda", codes=codes, rotations=after, translations=None)
        times, values = upsampled(run, tmp_path, "--scheme", scheme, "--factor", 4)
        outputs.append((np.array(times), np.array(values)))
    (times, one), (_, two) = outputs
    before, later = times <= 2.0, times > 2.0
    assert before.sum() == 9
    np.testing.assert_array_equal(one[before], two[before])
    assert np.abs(one[later] - two[later]).max() > 0.1


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_recording_of_two_thousand_a_second_is_motion(tmp_path, run, scheme):
    codes = np.arange(6) * 24.0 / 2000.0
    make_rig(tmp_path / "in.usda", codes=codes, rotations=poses(6), translations=None)
    times, values = upsampled(run, tmp_path, "--scheme", scheme, "--factor", 2)
    assert len(times) == 11
    moved = np.abs(np.diff(np.array(values), axis=0)).max(axis=(1, 2))
    assert (moved > 1e-3).all()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_pair_of_five_milliseconds_is_motion(tmp_path, run, scheme):
    codes = [0.0, 1.0, 2.0, 2.0 + 0.005 * 24.0, 3.0, 4.0]
    make_rig(tmp_path / "in.usda", codes=codes, rotations=poses(6), translations=None)
    times, _ = upsampled(run, tmp_path, "--scheme", scheme, "--factor", 2)
    assert len(times) == 11


def test_learn_cuts_at_steps_as_it_does_at_value_blocks(tmp_path, run):
    step = 1e-4
    count = 24
    found = []
    for name, codes, blocked in (
        ("steps", [*range(12), *(11 + step + k for k in range(12))], False),
        ("blocks", [*range(12), 11.5, *(11 + step + k for k in range(1, 13))], True),
    ):
        turns = list(random_rotations(count, 3, size=0.4))
        if blocked:
            turns.insert(12, None)
        at_rest = np.tile(np.float32([0.0, 10.0, 0.0]), (len(codes), 3, 1))
        stage = make_rig(
            tmp_path / f"{name}.usda", codes=codes, rotations=random_rotations(len(codes), 3), translations=at_rest
        )
        set_samples(stage, "rotations", codes, turns)
        stage.GetRootLayer().Save()
        report = tmp_path / f"{name}.json"
        code, _, err = run("learn", tmp_path / f"{name}.usda", "-o", tmp_path / f"{name}_out.usda", "--report", report)
        assert code == 0, err
        found.append(json.loads(report.read_text())["metrics"][0])
    steps, blocks = found
    assert steps["animations"][0]["stretches"] == blocks["animations"][0]["stretches"] == 2
    assert [joint["alpha"] for joint in steps["joints"]] == pytest.approx([j["alpha"] for j in blocks["joints"]])
