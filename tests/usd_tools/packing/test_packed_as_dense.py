"""Every verb reads a packed file as it reads the file that `unpack` makes of it."""

import json

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from rigs import ANIMATION, bits, make_rig, random_rotations, read

from usd_tools.editing import EditSession
from usd_tools.learning.files import read_clips
from usd_tools.pack import PackOptions, pack
from usd_tools.unpack import unpack

N = 20
ROOT = "/Rig.xformOp:translate"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A packed file and the unpacked one, under one name in two folders, for names are in what is written."""
    folder = tmp_path_factory.mktemp("dense")
    stage = make_rig(folder / "in.usda", codes=range(N), rotations=random_rotations(N, 3))
    op = UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddTranslateOp()
    for code in range(N):
        op.Set(Gf.Vec3d(3.0 * code, 0.0, 0.0), code)
    stage.GetRootLayer().Save()
    found = [folder / name / "clip.usdc" for name in ("packed", "dense")]
    for path in found:
        path.parent.mkdir()
    pack(folder / "in.usda", found[0], PackOptions(tolerance=1.0, effort="fast"))
    unpack(found[0], found[1])
    return found


def samples(path):
    """All samples of the animation, and of the transform above it."""
    stage = Usd.Stage.Open(str(path))
    op = stage.GetAttributeAtPath(ROOT)
    moved = [(code, op.Get(code)) for code in op.GetTimeSamples()]
    channels = [read(path, name) for name in ("rotations", "translations")]
    return [(codes, bits(values)) for codes, values in channels], moved


@pytest.mark.parametrize(
    "words",
    [
        ["upsample", "--factor", 3],
        ["upsample", "--fps", 60, "--no-xforms", "--flatten"],
        ["resample", "--fps", 17],
        ["downsample", "--keys", 6, "--scheme", "slerp"],
        ["unpack"],
    ],
    ids=str,
)
def test_what_is_written_is_the_same(files, tmp_path, run, words):
    verb, *options = words
    found = []
    for k, path in enumerate(files[: 1 if verb == "unpack" else 2]):
        assert run(verb, path, "-o", tmp_path / f"{k}.usda", *options)[0] == 0
        found.append(samples(tmp_path / f"{k}.usda"))
    assert (found[0] == found[1]) if len(found) > 1 else (found[0] == samples(files[1]))


def test_metrics_are_learned_and_set_on_packed_files(files, tmp_path, run):
    for words in (
        ["learn", "--rate", 0.4, "--scheme", "geodesic"],
        ["metric", "set", "--alpha", 2],
    ):
        metrics = []
        for k, path in enumerate(files):
            verb, *options = words
            action = [options.pop(0)] if verb == "metric" else []
            out = tmp_path / f"{verb}{k}.usda"
            assert run(verb, *action, path, "-o", out, *options)[0] == 0
            stage = Usd.Stage.Open(str(out))
            prim = stage.GetPrimAtPath(ANIMATION)
            metrics.append([list(prim.GetAttribute(f"geodesicMetric:{name}").Get()) for name in ("alpha", "beta")])
            assert read_clips(out, (), None)[0].codes.tolist() == list(range(N))  # packed, or not: as before
        assert metrics[0] == metrics[1]


def test_bvh_is_the_same(files, tmp_path, run):
    texts = []
    for k, path in enumerate(files):
        assert run("to_bvh", path, "-o", tmp_path / f"{k}.bvh")[0] == 0
        texts.append((tmp_path / f"{k}.bvh").read_text())
    assert texts[0] == texts[1]


def test_inspect_tells_the_same(files, inspected):
    described = [inspected(path)["animations"] for path in files]
    assert described[0][0].pop("packed_bytes") > 0
    described[1][0].pop("packed_bytes", None)
    for (animation,) in described:
        for channel in animation["channels"].values():
            channel.pop("from")
    assert described[0] == described[1]


@pytest.mark.slow
def test_compare_measures_the_same(files, tmp_path, run):
    scores = []
    for k, path in enumerate(files):
        code = run("compare", path, "-o", tmp_path / str(k), "--rates", 0.4, "--schemes", "slerp")[0]
        assert code == 0
        rows = json.loads((tmp_path / str(k) / "results.json").read_text())["rows"]
        scores.append([(row["out_of_sample"], row["q_hyb"], row["max_location_cm"]) for row in rows])
    assert scores[0] == scores[1]


def test_sessions_are_the_same(files):
    sessions = [EditSession.open(path) for path in files]
    for name in ("original", "ours"):
        poses = [session.poses(name) for session in sessions]
        assert np.array_equal(*poses)
