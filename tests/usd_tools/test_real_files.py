"""Every real file goes through every verb, with the result that is written down in `file_table`."""

import json
from pathlib import Path

import numpy as np
import pytest
from composed import CHANNELS, differences, errors_of
from file_table import LETTERS, TABLE
from pxr import Usd, UsdSkel, UsdUtils
from real_files import SHARED, needs_shared, real_file
from rigs import bits, read

from geomstats_anim import rotations as quat
from usd_tools.metrics.attributes import read_metric
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

ANIMATED = [name for name, row in TABLE.items() if row.upsample is None]
TAUGHT = [name for name, row in TABLE.items() if row.learn is None]
OPTIONS = {"upsample": ["--factor", 2], "downsample": ["--rate", 0.3, "--select", "uniform"], "learn": []}
REFUSED = [(verb, name) for verb in OPTIONS for name, row in TABLE.items() if getattr(row, verb)]
THINNED = [name for name, row in TABLE.items() if row.downsample is None]
CLIPS = [name for name in ANIMATED if name.startswith("clips/")] + ["usd/mayausd_HIK_Export.usda"]


def sentence(text, path):
    return text.replace("{}", str(path)).replace("{name}", path.name)


@needs_shared
def test_no_file_is_forgotten():
    found = {str(path.relative_to(SHARED)) for folder in ("clips", "usd") for path in (SHARED / folder).rglob("*.usd*")}
    assert found == set(TABLE)


@pytest.mark.parametrize("name", TABLE)
def test_inspect(name, run, inspected):
    told = inspected(real_file(name))
    found = {}
    for animation in told["animations"]:
        counts = {channel: of["samples"] or "" for channel, of in animation["channels"].items()}
        words = (f"{letter}{counts[channel]}" for letter, channel in LETTERS.items() if channel in counts)
        found[animation["prim"]] = " ".join(words)
    assert found == TABLE[name].animations
    assert told["warnings"] == list(TABLE[name].warnings)
    code, out, err = run("inspect", real_file(name))
    assert (code, "…" in out) == (0, False)
    assert err == "".join(f"warning: {warning}\n" for warning in TABLE[name].warnings)


@pytest.mark.parametrize(("verb", "name"), REFUSED)
def test_refused(tmp_path, verb, name, run):
    words = getattr(TABLE[name], verb)
    code, out, err = run(verb, real_file(name), "-o", tmp_path / "out.usda", *OPTIONS[verb])
    assert (code, out) == (1, "")
    assert err.splitlines()[-1] == f"error: {sentence(words, real_file(name))}"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ANIMATED)
def test_upsample(tmp_path, name, run):
    source, out = real_file(name), tmp_path / "out.usdc"
    report = tmp_path / "report.json"
    words = ["--factor", 2, "--alpha", 4, "--beta", 0.5, "--report", report]
    code, text, err = run("upsample", source, "-o", out, *words)
    told = any("degrees" in warning for warning in TABLE[name].warnings)
    told += sum("SkelBindingAPI" in warning for warning in TABLE[name].warnings)
    assert (code, err.count("\n")) == (0, told)
    counts = [f"{before} -> {2 * before - 1} samples" for before in TABLE[name].samples]
    assert [count in line for count, line in zip(counts, text.splitlines()[:-1], strict=True)] == [True] * len(counts)
    stage = Usd.Stage.Open(str(source))
    for animation in find_animations(stage):
        for channel in CHANNELS:
            codes, values = read(source, channel, animation.path)
            new_codes, new_values = read(out, channel, animation.path)
            place = {c: i for i, c in enumerate(new_codes)}
            assert bits([new_values[place[c]] for c in codes]) == bits(values)
            if channel == "rotations" and codes:
                norms = np.linalg.norm(np.array(new_values)[1::2].astype(np.float64), axis=-1)
                np.testing.assert_allclose(norms, 1.0, atol=1e-6)
    told = json.loads(report.read_text())["animations"]
    transforms = sorted(xform["attribute"] for animation in told for xform in animation["xforms"])
    assert differences(source, out) == transforms == list(TABLE[name].transforms)
    written = Usd.Stage.Open(str(out))
    for path in transforms:
        before, after = stage.GetAttributeAtPath(path), written.GetAttributeAtPath(path)
        for code in before.GetTimeSamples():
            assert after.Get(code) == before.Get(code)
    assert errors_of(out) <= errors_of(source)


@pytest.mark.slow
@pytest.mark.parametrize("name", TAUGHT)
def test_learn(tmp_path, name, run):
    source, out = real_file(name), tmp_path / "out.usdc"
    code, text, err = run("learn", source, "-o", out)
    assert (code, err) == (0, "")
    assert text.count("samples kept as keys") == len(TABLE[name].samples)
    stage = Usd.Stage.Open(str(out))
    for animation in find_animations(stage):
        assert read_metric(animation.prim).joints == read_clip(animation).joints
    assert differences(source, out, written=()) == []
    assert errors_of(out) <= errors_of(source)


@pytest.mark.slow
@pytest.mark.parametrize("name", THINNED)
def test_downsample(tmp_path, name, run):
    source = real_file(name)
    # of the same kind as the source: usdc forgets the sign of zeros
    out = tmp_path / f"out{source.suffix if source.suffix == '.usdc' else '.usda'}"
    code, text, err = run("downsample", source, "-o", out, *OPTIONS["downsample"])
    nowhere = TABLE[name].nowhere
    warnings = [warning for warning in TABLE[name].warnings if "SkelBindingAPI" in warning]
    warnings += [f"{out} references files that cannot be found: {', '.join(nowhere)}."] if nowhere else []
    assert (code, err) == (0, "".join(f"warning: {warning}\n" for warning in warnings))
    for count in TABLE[name].samples:
        assert f": {TABLE[name].kept or max(2, round(0.3 * count))} of {count} samples kept" in text
    stage = Usd.Stage.Open(str(source))
    for animation in find_animations(stage):
        for channel in CHANNELS:
            codes, values = read(source, channel, animation.path)
            kept_codes, kept = read(out, channel, animation.path)
            if kept_codes:
                place = {code: i for i, code in enumerate(codes)}
                assert bits(kept) == bits([values[place[code]] for code in kept_codes])
    assert differences(source, out) == []
    assert errors_of(out) <= errors_of(source)


@needs_shared
@pytest.mark.slow
def test_compare(tmp_path, run):
    out = tmp_path / "out"
    code, _, err = run("compare", SHARED / "usd", "-o", out, "--rates", 0.3, "--schemes", "linear", "slerp")
    results = json.loads((out / "results.json").read_text())
    assert code == 0
    rows = {name: row for name, row in TABLE.items() if name.startswith("usd/")}
    skipped = {name: row.compare for name, row in rows.items() if row.compare is not None}
    told = {file["file"]: file["reason"] for file in results["skipped"]}
    assert told == {Path(name).name: sentence(words, real_file(name)) for name, words in skipped.items()}
    counts = [len(row.samples) for row in rows.values() if row.compare is None]
    assert (len(results["clips"]), len(results["rows"])) == (sum(counts), 4 * sum(counts))
    for row in results["rows"]:
        assert row["error"] is None and (row["q_hyb"] > 0.0 or row["out_of_sample"])
        if row["usd"] is not None:
            source = next(clip["file"] for clip in results["clips"] if clip["clip"] == row["clip"])
            (name,) = (name for name in rows if Path(name).name == source)
            assert differences(real_file(name), out / row["usd"]) == []


@pytest.mark.parametrize("name", CLIPS)
def test_slerp_is_what_usd_shows(tmp_path, name, run):
    out = tmp_path / "out.usda"
    run("upsample", real_file(name), "-o", out, "--factor", 3, "--scheme", "slerp")
    stage, new = Usd.Stage.Open(str(real_file(name))), Usd.Stage.Open(str(out))
    (source,) = find_animations(stage)
    queries = []
    for each in (stage, new):
        skeleton = UsdSkel.Skeleton.Get(each, source.skeletons[0].GetPath())
        queries.append(UsdSkel.Cache().GetSkelQuery(skeleton).GetAnimQuery())
    for code in queries[1].GetJointTransformTimeSamples():
        shown, written = (query.ComputeJointLocalTransformComponents(Usd.TimeCode(code)) for query in queries)
        rotations = [quat.normalize(np.array(each[1], dtype=np.float64)) for each in (shown, written)]
        assert quat.distance(*rotations).max() < 2e-6
        np.testing.assert_allclose(np.array(shown[0]), np.array(written[0]), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["usd/usdwg_CesiumMan.usdz", "usd/usdwg_RiggedFigure.usdz", "clips/sitting.usda"])
@pytest.mark.parametrize("flat", [[], ["--flatten"]])
def test_usdz(tmp_path, name, flat, run):
    out = tmp_path / "out.usdz"
    code, _, err = run("upsample", real_file(name), "-o", out, "--factor", 2, *flat)
    assert (code, err) == (0, "")
    assert errors_of(out) <= errors_of(real_file(name))
    assert UsdUtils.ComputeAllDependencies(str(out))[2] == []


@pytest.mark.parametrize("name", CLIPS)
def test_animation_of_a_clip(name):
    stage = Usd.Stage.Open(str(real_file(name)))
    (source,) = find_animations(stage)
    clip = read_clip(source)
    animation = animation_of(clip)
    codes, values = read(real_file(name), prim=source.path)
    np.testing.assert_allclose(animation.times, np.array(codes) / stage.GetTimeCodesPerSecond(), rtol=1e-15)
    given = quat.normalize(np.array(values, dtype=np.float64))
    assert quat.distance(animation.rotations[:, clip.columns], given).max() < 1e-15
    bones = np.linalg.norm(clip.skeleton.rest_translations[1:], axis=-1)
    assert 0.02 < np.median(bones) < 0.5  # metres, whatever the file's units
