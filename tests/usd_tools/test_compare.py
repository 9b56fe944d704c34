"""What compare leaves: rows that can be checked against the USD files beside them, and nothing half-made."""

import csv
import json
import shutil
from dataclasses import fields

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSkel
from real_files import real_file
from rigs import ANIMATION, bits, make_rig, random_rotations, read, set_samples, stored_metric
from scipy.spatial.transform import Rotation

from geomstats_anim import SCHEMES, interpolate, quality, uniform_keyframes
from geomstats_anim.names import OWN_SCHEMES
from usd_tools import compare
from usd_tools.comparison import trials as comparison
from usd_tools.comparison.options import CompareOptions, SchemeChoice
from usd_tools.comparison.trials import Row, Trial, all_trials
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

KEYS = (
    "clip rate scheme keys q_loc q_rot q_hyb mean_rotation_deg mean_location_cm max_location_cm bytes_numpy bytes_usdc "
    "seconds_learn seconds_interpolate out_of_sample"
).split()
WORDS = ["--rates", ".25", "--schemes", "constant", "slerp", "geodesic", "geodesic-spline"]
SECONDS = ("seconds_learn", "seconds_interpolate")


def make_clip(path, seed=0, count=24, **rest):
    """A file in which every joint turns about several axes."""
    return make_rig(path, codes=range(count), rotations=random_rotations(count, 3, seed, size=0.4), **rest)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A comparison that is made once for all tests that only look."""
    there = tmp_path_factory.mktemp("compare")
    (there / "clips").mkdir()
    make_clip(there / "clips" / "one.usda")
    assert compare.main([str(there / "clips" / "one.usda"), "-o", str(there / "out"), *WORDS]) == 0
    return there / "out"


@pytest.fixture
def rows(folder):
    return json.loads((folder / "results.json").read_text())["rows"]


def evaluated(path, source):
    """Score a written file against its source with UsdSkel, NumPy and SciPy alone."""
    stage = Usd.Stage.Open(str(source))
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Animation))
    codes = prim.GetAttribute("rotations").GetTimeSamples()
    turns, ends = zip(pose(path, codes), pose(source, codes), strict=True)
    (new, old), (moved, true) = turns, ends
    angles = (Rotation.from_quat(new.reshape(-1, 4)) * Rotation.from_quat(old.reshape(-1, 4)).inv()).magnitude()
    angles = angles.reshape(len(codes), -1)
    start = Rotation.from_quat(np.repeat(old[:1], len(codes), axis=0).reshape(-1, 4))
    turned = (Rotation.from_quat(old.reshape(-1, 4)) * start.inv()).magnitude().reshape(angles.shape)
    distances = np.linalg.norm(moved - true, axis=-1)
    q_loc, q_rot = (distances**2).mean(axis=0).sum(), angles.mean(axis=0).sum()
    return {
        "q_loc": q_loc,
        "q_rot": q_rot,
        "q_hyb": 0.5 * q_loc + 0.5 * q_rot,
        "mean_rotation_deg": np.degrees(angles[:, (turned > 1e-5).any(axis=0)].mean()),
        "mean_location_cm": 100.0 * distances.mean(),
        "max_location_cm": 100.0 * distances.max(),
    }


def pose(path, codes):
    """Local rotations (F, B, 4) and bone ends in metres (F, B, 3), by UsdSkel."""
    stage = Usd.Stage.Open(str(path))
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton))
    cache = UsdSkel.Cache()
    query = cache.GetSkelQuery(UsdSkel.Skeleton(prim))
    parents = np.array(query.GetTopology().GetParentIndices())
    rest = np.array([list(m.ExtractTranslation()) for m in UsdSkel.Skeleton(prim).GetRestTransformsAttr().Get()])
    lengths = prim.GetAttribute("primvars:blender:bone_lengths").Get()
    ends = np.empty_like(rest)
    for joint in range(len(rest)):
        children = rest[parents == joint]
        ends[joint] = children.mean(axis=0) if len(children) else rest[joint]
        own = np.linalg.norm(rest[joint])
        if lengths and not len(children) and own > 0.0:
            ends[joint] *= lengths[joint] / own
    world = np.array(UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(Usd.TimeCode(codes[0])))
    scale = np.cbrt(np.linalg.det(world[:3, :3])) * UsdGeom.GetStageMetersPerUnit(stage)
    turns, places = [], []
    for code in codes:
        local = query.ComputeJointLocalTransforms(code)
        turns.append([[*q.GetImaginary(), q.GetReal()] for q in (m.ExtractRotationQuat() for m in local)])
        skel = np.array(query.ComputeJointSkelTransforms(code))
        places.append(np.einsum("bi,bij->bj", np.c_[ends, np.ones(len(ends))], skel)[:, :3] * scale)
    return np.array(turns), np.array(places)


def test_rows(rows):
    assert [field.name for field in fields(Row)][: len(KEYS)] == KEYS
    assert all(list(row)[: len(KEYS)] == KEYS for row in rows)
    assert all(row["error"] is None for row in rows)
    whole = [(row["clip"], row["rate"], row["scheme"]) for row in rows if not row["out_of_sample"]]
    assert whole == [("one", 0.25, s) for s in WORDS[3:]]
    unseen = [(row["scheme"], row["purpose"]) for row in rows if row["out_of_sample"]]
    learned = [(s, purpose) for s in ("geodesic", "geodesic-spline") for purpose in ("predict", "reconstruct")]
    assert unseen == [("constant", None), ("slerp", None), *learned]
    assert {row["keys"] for row in rows} == {6, 3}
    assert all(row["frames"] == (12 if row["out_of_sample"] else 24) for row in rows)


def test_learned_rows_win_in_sample(rows):
    whole = {(row["clip"], row["rate"], row["scheme"]): row for row in rows if not row["out_of_sample"]}
    for (clip, rate, scheme), row in whole.items():
        if scheme.startswith("geodesic"):
            assert row["q_hyb"] <= whole[clip, rate, "slerp"]["q_hyb"]
            assert row["bytes_numpy"] > whole[clip, rate, "slerp"]["bytes_numpy"]
            assert row["seconds_learn"] > 0.0
        else:
            assert row["seconds_learn"] == 0.0


def test_numbers_are_those_of_the_written_files(folder, rows):
    checked = 0
    for row in rows:
        if row["usd"] is not None:
            found = evaluated(folder / row["usd"], folder.parent / "clips" / f"{row['clip']}.usda")
            for name, value in found.items():
                assert row[name] == pytest.approx(value, rel=1e-5, abs=1e-5), (row["usd"], name)
            checked += 1
    assert checked == 4


def test_written_files_go_over_their_source(folder, rows):
    for row in rows:
        if row["usd"] is None:
            continue
        source = folder.parent / "clips" / f"{row['clip']}.usda"
        layer = Sdf.Layer.FindOrOpen(str(folder / row["usd"]))
        assert list(layer.subLayerPaths) == [f"../../../../clips/{row['clip']}.usda"]
        (codes, new), (wanted, old) = read(folder / row["usd"]), read(source)
        assert codes == wanted
        kept = [a == b for a, b in zip(bits(new), bits(old), strict=True)]
        assert kept[0] and kept[-1] and sum(kept) >= row["keys"]
        metric = stored_metric(folder / row["usd"])
        assert (metric is not None) == row["scheme"].startswith("geodesic")


def test_csv_holds_the_same(folder, rows):
    with open(folder / "results.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert [{name: "" if value is None else str(value) for name, value in row.items()} for row in rows] == table


def test_bytes(folder, rows):
    row = next(row for row in rows if row["scheme"] == "slerp")
    assert row["bytes_numpy"] == 2 * 128 + 4 * (6 * 3 * 4 + 6 * 3 * 3)
    learned = next(row for row in rows if row["scheme"] == "geodesic")
    assert learned["bytes_numpy"] == row["bytes_numpy"] + 3 * 128 + 4 * (3 + 3) + 3
    assert learned["bytes_usdc"] > row["bytes_usdc"] > 500


def test_files(folder):
    names = {path.name for path in folder.iterdir()}
    assert names == {"manifest.json", "figures", "index.html", "results.csv", "results.json", "usd"}
    pictures = {path.name for path in (folder / "figures").iterdir()}
    stems = ["quality", "quality-unseen", *(f"one-{w}" for w in ("overlay", "error", "metric"))]
    assert pictures == {f"{stem}.{suffix}" for stem in stems for suffix in ("png", "svg")}
    assert not [path for path in folder.parent.iterdir() if path.name.startswith(".")]


@pytest.mark.slow
def test_same_input_same_bytes(folder, run):
    again = folder.with_name("again")
    assert run("compare", folder.parent / "clips" / "one.usda", "-o", again, *WORDS)[0] == 0
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(again) for path in again.rglob("*") if path.is_file())
    for file in files:
        if file.name not in ("results.json", "results.csv"):
            assert (folder / file).read_bytes() == (again / file).read_bytes(), file
    first, second = (json.loads((each / "results.json").read_text()) for each in (folder, again))
    for row in (*first["rows"], *second["rows"]):
        for name in SECONDS:
            del row[name]
    assert first == second


def test_tables_on_stdout_and_silence_on_stderr(tmp_path, run):
    make_clip(tmp_path / "in.usda", count=12)
    code, out, err = run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", "--rates", ".4", "--schemes", "slerp")
    assert (code, err) == (0, "")
    assert "in, 12 samples of 3 joints" in out and "slerp" in out and "index.html" in out


def test_failing_cell_is_named_and_the_rest_goes_on(tmp_path, run, monkeypatch):
    class Broken(SCHEMES["slerp"]):
        def __call__(self, times):
            raise RuntimeError("no such luck")

    monkeypatch.setitem(SCHEMES, "linear", Broken)
    make_clip(tmp_path / "in.usda", count=12)
    words = ["--rates", ".4", "--schemes", "linear", "slerp"]
    code, out, err = run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)
    assert code == 0 and "failed" in out
    assert "in at rate 0.4, linear failed: RuntimeError: no such luck" in err
    rows = json.loads((tmp_path / "out" / "results.json").read_text())["rows"]
    assert [row["error"] for row in rows] == 2 * ["RuntimeError: no such luck"] + 2 * [None]
    assert rows[0]["q_hyb"] is None and rows[2]["q_hyb"] > 0.0
    assert "no such luck" in (tmp_path / "out" / "index.html").read_text()


def test_too_few_keys_to_learn_from(tmp_path, run):
    make_clip(tmp_path / "in.usda", count=12)
    words = ["--rates", ".1", "--schemes", "slerp", "geodesic", "geodesic-spline"]
    code, _, _ = run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)
    assert code == 0
    rows = json.loads((tmp_path / "out" / "results.json").read_text())["rows"]
    assert not any(row["error"] for row in rows)
    seen = [row["q_hyb"] for row in rows if not row["out_of_sample"]]
    # one segment can be rebuilt better, but tells nothing of others
    assert max(seen[1:]) < seen[0]
    unseen = {(row["scheme"], row["purpose"]): row["q_hyb"] for row in rows if row["out_of_sample"]}
    assert unseen["geodesic", "predict"] == pytest.approx(unseen["slerp", None], rel=1e-9)


def test_everything_fails_and_there_is_still_a_report(tmp_path, run, monkeypatch):
    def broken(*_):
        raise ValueError("nothing works today.")

    monkeypatch.setattr(comparison, "rebuild", broken)
    make_clip(tmp_path / "in.usda", count=12)
    code, _, err = run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", "--rates", ".4", "--schemes", "slerp")
    assert code == 0 and "in at rate 0.4, slerp failed: nothing works today." in err
    assert "nothing works today." in (tmp_path / "out" / "index.html").read_text()


def test_stretches_between_blocks(tmp_path, run):
    stage = make_clip(tmp_path / "in.usda")
    turns = list(random_rotations(24, 3, size=0.4))
    turns[10] = None
    set_samples(stage, "rotations", range(24), turns)
    stage.GetRootLayer().Save()
    words = ["--rates", ".5", "--schemes", "slerp"]
    assert run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)[0] == 0
    document = json.loads((tmp_path / "out" / "results.json").read_text())
    assert (document["clips"][0]["stretches"], document["clips"][0]["frames"]) == (2, 23)
    codes, values = read(tmp_path / "out" / document["rows"][0]["usd"])
    assert codes == list(range(24)) and values[10] is None
    assert document["rows"][0]["keys"] == 5 + 6


def test_translations_at_other_times_and_y_up(tmp_path, run):
    stage = make_clip(tmp_path / "in.usda", count=12)
    UsdGeom.SetStageUpAxis(stage, "Y")
    attribute = stage.GetPrimAtPath(ANIMATION).GetAttribute("translations")
    attribute.Clear()
    places = np.linspace(0, 9, 27, dtype=np.float32).reshape(3, 3, 3)
    set_samples(stage, "translations", [0.0, 5.5, 11.0], places)
    stage.GetRootLayer().Save()
    words = ["--rates", ".4", "--schemes", "slerp"]
    assert run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)[0] == 0
    row = json.loads((tmp_path / "out" / "results.json").read_text())["rows"][0]
    assert read(tmp_path / "out" / row["usd"], "translations")[0] == list(range(12))
    assert row["q_loc"] == pytest.approx(evaluated(tmp_path / "out" / row["usd"], tmp_path / "in.usda")["q_loc"], 1e-5)


def test_replaces_its_own_folder(tmp_path, run):
    make_clip(tmp_path / "in.usda", count=12)
    words = ["--rates", ".4", "--schemes", "slerp"]
    assert run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)[0] == 0
    words[1] = ".3"
    assert run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)[0] == 0
    assert [path.name for path in (tmp_path / "out" / "usd" / "in").iterdir()] == ["0.3"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.usda", "out"]


def test_clips_of_the_same_name(tmp_path, run):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        make_clip(tmp_path / name / "walk.usda", count=12)
    words = ["--rates", ".4", "--schemes", "slerp"]
    assert run("compare", tmp_path / "a", tmp_path / "b", "-o", tmp_path / "out", *words)[0] == 0
    assert sorted(path.name for path in (tmp_path / "out" / "usd").iterdir()) == ["walk", "walk-2"]


def test_cells_put_what_is_unseen_beside_what_is_seen():
    slerp, geodesic = SchemeChoice.parse("slerp"), SchemeChoice.parse("geodesic:spd")
    assert all_trials(["walk"], [0.3], [slerp, geodesic]) == [
        Trial("walk", 0.3, slerp, None, False),
        Trial("walk", 0.3, slerp, None, True),
        Trial("walk", 0.3, geodesic, "reconstruct", False),
        Trial("walk", 0.3, geodesic, "predict", True),
        Trial("walk", 0.3, geodesic, "reconstruct", True),
    ]
    assert (geodesic.word, geodesic.scheme, geodesic.family) == ("geodesic:spd", "geodesic", "spd")
    assert SchemeChoice.parse("geodesic:diagonal").word == "geodesic"


@pytest.mark.slow
def test_ray_gives_the_same(tmp_path, run):
    pytest.importorskip("ray")
    make_clip(tmp_path / "in.usda")
    words = ["--rates", ".3", "--schemes", "slerp", "geodesic"]
    found = []
    for name, more in (("one", []), ("two", ["--cpus", 2])):
        assert run("compare", tmp_path / "in.usda", "-o", tmp_path / name, *words, *more)[0] == 0
        found.append(json.loads((tmp_path / name / "results.json").read_text())["rows"])
    for row in (*found[0], *found[1]):
        for name in SECONDS:
            del row[name]
    assert found[0] == found[1]
    assert (tmp_path / "one" / "index.html").read_bytes() == (tmp_path / "two" / "index.html").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("names", [("sitting", "punching"), ("sitting", "pitching")])
def test_real_clips_are_those_of_the_written_files(tmp_path, names, run):
    clips = [real_file(f"clips/{name}.usda") for name in names]
    paths = {clip.stem: shutil.copy(clip, tmp_path) for clip in clips}
    schemes = [*OWN_SCHEMES, "geodesic:spd"]
    assert run("compare", *paths.values(), "-o", tmp_path / "out", "--rates", ".2", "--schemes", *schemes)[0] == 0
    for row in json.loads((tmp_path / "out" / "results.json").read_text())["rows"]:
        if row["usd"] is not None:
            found = evaluated(tmp_path / "out" / row["usd"], paths[row["clip"]])
            for name, value in found.items():
                assert row[name] == pytest.approx(value, rel=1e-5, abs=1e-5), (row["usd"], name)


def test_the_plain_spline_stands_beside_what_is_learned(tmp_path, run):
    """It is what upsample does without a metric: nothing is learned, and the whole scheme is no worse in sample."""
    make_clip(tmp_path / "in.usda", count=24)
    assert SchemeChoice.parse("geodesic-spline:plain") in CompareOptions().schemes
    words = ["--rates", ".3", "--schemes", "geodesic-spline:plain", "geodesic-spline"]
    assert run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)[0] == 0
    rows = json.loads((tmp_path / "out" / "results.json").read_text())["rows"]
    plain, learned = ([row for row in rows if row["scheme"] == word and not row["out_of_sample"]] for word in words[3:])
    assert (plain[0]["family"], plain[0]["purpose"], plain[0]["seconds_learn"]) == (None, None, 0.0)
    assert learned[0]["q_hyb"] <= plain[0]["q_hyb"]
    (source,) = find_animations(Usd.Stage.Open(str(tmp_path / "in.usda")))
    truth = animation_of(read_clip(source))
    keys = truth.at_frames(uniform_keyframes(truth.n_frames, 0.3))
    assert plain[0]["q_hyb"] == pytest.approx(quality(interpolate(keys, truth.times), truth), rel=1e-9)
