"""Laws of cycles."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from rigs import ANIMATION, make_rig, random_rotations, read

from geomstats_anim import rotations as quat
from usd_tools.skel import loops

N = 24


def poses(phase, n_frames):
    """Return rotations and translations of a walk of N samples per cycle, from a phase on: the root goes on in x."""
    angle = 2.0 * np.pi * (np.arange(n_frames) + phase) / N
    vectors = np.stack([0.8 * np.sin(angle + k) + 0.3 * np.cos(2 * angle) for k in range(9)], axis=-1)
    moves = np.tile([0.0, 10.0, 0.0], (n_frames, 3, 1))
    moves[:, 0] += np.stack([6.0 * angle + np.sin(angle), np.cos(2 * angle), np.sin(angle)], axis=-1)
    moves[:, 2, 1] += np.sin(angle)
    return quat.exp(vectors.reshape(n_frames, 3, 3)).astype(np.float32), moves.astype(np.float32)


def make_cycle(path, phase=0, closed=True):
    """Write a walk, and a transform above it that travels too."""
    n_frames = N + 1 if closed else N
    rotations, moves = poses(phase, n_frames)
    stage = make_rig(path, range(n_frames), rotations, moves)
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for code in range(n_frames):
        angle = 2.0 * np.pi * (code + phase) / N
        op.Set(Gf.Vec3d(5.0 * angle - np.cos(angle), 0.0, np.sin(angle)), code)
    stage.Save()


def values_of(path):
    """Return the time codes, rotations, translations and root transforms of a file, float64."""
    codes, rotations = read(path)
    stage = Usd.Stage.Open(str(path))
    root = stage.GetPrimAtPath("/Rig").GetAttribute("xformOp:translate")
    assert root.GetTimeSamples() == codes
    turned = quat.normalize(np.array(rotations, dtype=np.float64))
    moved = np.array(read(path, "translations")[1], dtype=np.float64)
    return np.array(codes), turned, moved, np.array([root.Get(code) for code in codes])


@pytest.mark.parametrize("scheme", [["--scheme", "squad"], ["--alpha", 4, "--tension", 1], ["--tension", 2]])
@pytest.mark.parametrize("closed", [True, False])
def test_another_phase_is_the_same_curve(tmp_path, run, scheme, closed):
    shift, factor = 7, 3
    for phase in (0, shift):
        make_cycle(tmp_path / f"in{phase}.usda", phase, closed)
        out = tmp_path / f"out{phase}.usda"
        code, _, err = run("upsample", tmp_path / f"in{phase}.usda", "-o", out, "--factor", factor, "--loop", *scheme)
        assert (code, err) == (0, "")
    codes, turned, moved, placed = values_of(tmp_path / "out0.usda")
    shifted = values_of(tmp_path / f"out{shift}.usda")
    count = N * factor
    assert len(codes) == (count + 1 if closed else count)
    np.testing.assert_allclose(codes, np.arange(len(codes)) / factor, atol=1e-12)
    place = (np.arange(count) + shift * factor) % count
    assert quat.distance(shifted[1][:count], turned[place]).max() < 1e-6
    laps = (np.arange(count) + shift * factor) // count
    travelled = moved[place] + laps[:, None, None] * np.array([[12 * np.pi, 0, 0], [0, 0, 0], [0, 0, 0]])
    # where the first pose is not there, what is travelled until then is foretold from the steps beside it
    np.testing.assert_allclose(shifted[2][:count], travelled, atol=1e-5 if closed else 0.1)
    gone = placed[place] + laps[:, None] * [10 * np.pi, 0, 0]
    np.testing.assert_allclose(shifted[3][:count], gone, atol=1e-6 if closed else 0.1)


def test_without_loop_the_seam_is_an_end(tmp_path, run):
    make_cycle(tmp_path / "in.usda")
    for name, words in (("plain", []), ("loop", ["--loop"])):
        run("upsample", tmp_path / "in.usda", "-o", tmp_path / f"{name}.usda", "--factor", 2, *words)
    plain, loop = (values_of(tmp_path / f"{name}.usda")[1] for name in ("plain", "loop"))
    apart = quat.distance(plain, loop).max(axis=1)
    assert apart[1] > 1e-3 and apart[-2] > 1e-3 and apart[::2].max() < 1e-12
    assert apart[9:-9].max() < 0.02 * apart[1]  # what the seam changes fades by a quarter per sample


def test_resample_fills_the_seam(tmp_path, run):
    make_cycle(tmp_path / "in.usda", closed=False)
    code, _, err = run("resample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--fps", 48, "--loop")
    assert (code, err) == (0, "")
    codes, turned, moved, _ = values_of(tmp_path / "out.usda")
    assert codes.tolist() == (np.arange(2 * N) / 2).tolist()
    truth, places = poses(N - 0.5, 1)
    assert quat.distance(turned[-1], truth[0].astype(float)).max() < 3e-3
    np.testing.assert_allclose(moved[-1], places[0], atol=0.02)
    run("resample", tmp_path / "in.usda", "-o", tmp_path / "slow.usda", "--fps", 12, "--loop", "--antialias")
    assert values_of(tmp_path / "slow.usda")[0].tolist() == list(range(0, N, 2))


def test_inspect_says_by_how_much_a_loop_misses(tmp_path, run, inspected, refuse):
    for closed in (True, False):
        make_cycle(tmp_path / "in.usda", closed=closed)
        (animation,) = inspected(tmp_path / "in.usda")["animations"]
        assert animation["loop"]["closed"] is closed
        assert animation["loop"]["misses_degrees"] < (1e-4 if closed else 3.0)
    rotations, moves = poses(0, N + 1)
    rotations[-1, 1] = quat.multiply(rotations[-1, 1].astype(float), quat.exp(np.radians([0.0, 2.0, 0.0])))
    make_rig(tmp_path / "off.usda", range(N + 1), rotations, moves)
    (animation,) = inspected(tmp_path / "off.usda")["animations"]
    assert animation["loop"]["joint_name"] == "spine"
    assert animation["loop"]["misses_degrees"] == pytest.approx(2.0, abs=1e-3)
    _, _, err = run("upsample", tmp_path / "off.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--loop")
    assert err.startswith(f"warning: {ANIMATION}: joint spine misses a loop by 2.0 degrees")
    make_rig(tmp_path / "half.usda", range(N // 2), rotations[: N // 2], moves[: N // 2])
    assert inspected(tmp_path / "half.usda")["animations"][0]["loop"] is None
    sentence = refuse("upsample", tmp_path / "half.usda", "-o", tmp_path / "x.usda", "--factor", 2, "--loop")
    assert sentence.startswith(f"{ANIMATION} is not a loop: joint ")


def test_turns_in_plain_numpy_are_those_of_the_kernel():
    left, right = quat.normalize(random_rotations(200, 2).astype(np.float64)).swapaxes(0, 1)
    for other in (right, -right, left, -left):
        np.testing.assert_allclose(loops._turns(left, other), quat.difference(left, other), atol=1e-14)
