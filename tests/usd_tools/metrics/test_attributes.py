"""The metric travels in a USD file without loss."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from pxr import Sdf, Usd, Vt
from rigs import ANIMATION, JOINTS, SKELETON, make_rig, some_metric, stored_metric

from geomstats_anim import LearnedMetric, MetricParameters
from usd_tools.console.errors import ToolError
from usd_tools.metrics.attributes import read_metric, summary, write_metric
from usd_tools.metrics.strings import METRIC_JSON, SUMMARY


@pytest.mark.parametrize("axes", [False, True])
@pytest.mark.parametrize("extension", ["usda", "usdc"])
def test_round_trip(tmp_path, axes, extension):
    metric = some_metric(axes)
    layer = Sdf.Layer.CreateNew(str(tmp_path / f"metric.{extension}"))
    write_metric(Sdf.CreatePrimInLayer(layer, ANIMATION), metric)
    layer.Save()
    del layer
    stage = Usd.Stage.Open(str(tmp_path / f"metric.{extension}"))
    again = read_metric(stage.GetPrimAtPath(ANIMATION))
    assert again.to_json() == metric.to_json()
    assert stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:axes").HasAuthoredValue() == axes
    entries = stage.GetPrimAtPath(ANIMATION).GetCustomDataByKey("geodesicMetric")
    assert json.loads(entries["provenance"])["source"] == "walk.usda"


def test_a_metric_without_translation_tension_gets_the_usual(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    layer = stage.GetRootLayer()
    write_metric(Sdf.CreatePrimInLayer(layer, ANIMATION), replace(some_metric(), scheme="geodesic-spline"))
    stage.GetPrimAtPath(ANIMATION).RemoveProperty("geodesicMetric:translationTension")
    assert (read_metric(stage.GetPrimAtPath(ANIMATION)).translation_tension == 1.0).all()


def test_no_metric(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    assert read_metric(stage.GetPrimAtPath(ANIMATION)) is None


def test_a_stronger_metric_hides_a_weaker_one_altogether(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "in.usda"))
    write_metric(layer.GetPrimAtPath(ANIMATION), some_metric(axes=True))
    layer.Save()
    for flat in ([], ["--flatten"]):
        out = tmp_path / f"out{len(flat)}.usda"
        run("upsample", tmp_path / "in.usda", "-o", out, "--factor", 2, "--metric", "identity", *flat)
        stage = Usd.Stage.Open(str(out))
        metric = read_metric(stage.GetPrimAtPath(ANIMATION))
        assert metric.parameters.axes is None
        assert (metric.quality, metric.provenance) == ("", {})


def test_entries_of_a_weaker_metric_do_not_show_through_at_any_depth(tmp_path):
    for name, entries in (("weak", {"a": 1, "deep": {"b": 2, "c": 3}}), ("strong", {"deep": {"c": 4}})):
        layer = Sdf.Layer.CreateNew(str(tmp_path / f"{name}.usda"))
        layer.subLayerPaths = ["./weak.usda"] if name == "strong" else []
        write_metric(Sdf.CreatePrimInLayer(layer, ANIMATION), replace(some_metric(), provenance=entries))
        layer.Save()
    stage = Usd.Stage.Open(str(tmp_path / "strong.usda"))
    assert read_metric(stage.GetPrimAtPath(ANIMATION)).provenance == {"deep": {"c": 4}}


def test_stored_metric_is_used_and_written(tmp_path, run):
    metric = some_metric(joints=[*JOINTS[:2], "elsewhere"])
    make_rig(tmp_path / "in.usda")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "in.usda"))
    write_metric(layer.GetPrimAtPath(ANIMATION), metric)
    layer.Save()
    code, out, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert (code, "geodesic, stored metric" in out) == (0, True)
    assert err == (f"warning: {ANIMATION}: the metric has no entry for joint arm; using the identity there.\n")
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    written = read_metric(stage.GetPrimAtPath(ANIMATION))
    assert written.to_json() == metric.for_joints(JOINTS)[0].to_json()
    for path in (SKELETON, "/Rig"):
        texts = [stage.GetPrimAtPath(path).GetAttribute(name).Get() for name in (METRIC_JSON, SUMMARY)]
        assert LearnedMetric.from_json(texts[0]).to_json() == written.to_json() and texts[1] == summary(written)


def test_metric_from_a_file_matches_by_name(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    metric = some_metric(joints=JOINTS[::-1])
    (tmp_path / "metric.json").write_text(metric.to_json())
    arguments = ["--factor", 2, "--metric", tmp_path / "metric.json", "--scheme", "geodesic"]
    code, out, _ = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", *arguments)
    assert (code, "geodesic, metric.json metric" in out) == (0, True)
    written = stored_metric(tmp_path / "out.usda")
    assert written.parameters.alpha.tolist() == metric.parameters.alpha[::-1].tolist()
    assert str(tmp_path) not in (tmp_path / "out.usda").read_text()
    (tmp_path / "other.json").write_text(some_metric(joints=["x"]).to_json())
    arguments[3] = tmp_path / "other.json"
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out2.usda", *arguments)
    assert code == 1 and err.endswith("has an entry for no joint of this file, which has hips, spine, arm.\n")


def test_a_metric_that_couples_joints_is_refused_and_nothing_is_written(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    metric = replace(some_metric(), coupling=np.full((len(JOINTS), 3, 1), 0.1))
    (tmp_path / "metric.json").write_text(metric.to_json())
    arguments = ["-o", tmp_path / "out.usda", "--factor", 2, "--metric", tmp_path / "metric.json"]
    code, _, err = run("upsample", tmp_path / "in.usda", *arguments)
    assert code == 1 and "the metric couples joints, which only Python can use" in err
    assert not (tmp_path / "out.usda").exists()
    with pytest.raises(ToolError, match="couples joints"):
        write_metric(Sdf.CreatePrimInLayer(stage.GetRootLayer(), ANIMATION), metric)


@pytest.mark.parametrize(
    ("attribute", "value", "words"),
    [
        ("alpha", [1.0], "geodesicMetric:alpha has 1 values for 3 joints."),
        ("alpha", [1.0, -1.0, 1.0], "the stored metric is invalid: alpha of joint 1 is -1.0"),
        ("version", 7, "geodesicMetric:version is 7, but this program reads 1; update it."),
        ("invariance", ["left", "up", "left"], "the stored metric is invalid: invariance of joint 1 is 'up'"),
        ("beta", None, "geodesicMetric:beta is missing; write the whole metric, or remove it."),
        ("joints", ["a", "a", "b"], "the stored metric is invalid: Joint names must be unique"),
    ],
)
def test_malformed(tmp_path, attribute, value, words):
    stage = make_rig(tmp_path / "in.usda")
    prim = stage.GetPrimAtPath(ANIMATION)
    write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), some_metric())
    found = prim.GetAttribute(f"geodesicMetric:{attribute}")
    found.Clear() if value is None else found.Set(value)
    with pytest.raises(ToolError) as error:
        read_metric(prim)
    assert str(error.value).startswith(ANIMATION) and words in str(error.value)


def test_wrong_type(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    prim = stage.GetPrimAtPath(ANIMATION)
    write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), some_metric())
    prim.RemoveProperty("geodesicMetric:alpha")
    spec = stage.GetRootLayer().GetPrimAtPath(ANIMATION)  # a stage makes the attribute with the schema's type
    Sdf.AttributeSpec(spec, "geodesicMetric:alpha", Sdf.ValueTypeNames.FloatArray).default = Vt.FloatArray([1, 1, 1])
    with pytest.raises(ToolError, match="geodesicMetric:alpha has type float\\[\\]; it must have type double\\[\\]"):
        read_metric(prim)


@pytest.mark.parametrize("entries", [{"entries": 3}, {"entries": Vt.StringArray(["gone"])}, {"by_joint": 1.0, "x": 2}])
def test_provenance_that_somebody_has_edited(tmp_path, run, entries):
    stage = make_rig(tmp_path / "in.usda")
    spec = stage.GetRootLayer().GetPrimAtPath(ANIMATION)
    write_metric(spec, some_metric())
    spec.customData = {"geodesicMetric": {**entries, "styles": 5}}
    stage.Save()
    code, _, err = run("inspect", tmp_path / "in.usda")
    assert (code, err) == (0, "")
    out = ["-o", tmp_path / "out.usda", "--factor", 2, "--alpha", 3]
    assert run("upsample", tmp_path / "in.usda", *out)[0] == 0
    assert stored_metric(tmp_path / "out.usda").provenance["styles"] == ["*:alpha=3"]
    for value, words in (
        (Sdf.AssetPath("a.usda"), "provenance of its customData has a type that metrics do not use; remove it."),
        ("[]", "provenance of its customData is not a JSON object; remove it."),
        ("{", "This is not JSON: "),
        ("[" * 1000, "This JSON is nested more than 32 levels deep."),
        ('{"seed": 1e999}', "which is not a finite number."),
    ):
        spec.customData = {"geodesicMetric": {"provenance": value}}
        with pytest.raises(ToolError, match=f"the stored metric is invalid: .*{re.escape(words)}"):
            read_metric(stage.GetPrimAtPath(ANIMATION))


LOSSLESS = {
    "seed": None,
    "trials": 2**63 - 1,
    "least": -(2**63),
    "whole": 1.0,
    "mixed": [1, 2.5, "x", None, True, {"deep": []}],
    "empty": {},
    "dotted:key.name": "\u202e\n\x1b",
}


def test_provenance_round_trips_without_loss(tmp_path):
    stage = make_rig(tmp_path / "in.usda")
    metric = LearnedMetric(tuple(JOINTS), MetricParameters.identity(3), quality="hyb", provenance=LOSSLESS)
    for name in ("a.usda", "a.usdc"):
        write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), metric)
        stage.GetRootLayer().Export(str(tmp_path / name))
        found = stored_metric(tmp_path / name)
        assert json.dumps(found.provenance) == json.dumps(LOSSLESS)  # 1.0 is not 1 there
        assert found.to_json() == metric.to_json()


def test_provenance_of_a_weaker_layer_does_not_show_through(tmp_path):
    make_rig(tmp_path / "weak.usda")
    for name, provenance in (("weak.usda", {"old": 1, "both": {"a": 1}}), ("strong.usda", {"both": {"b": 2}})):
        layer = Sdf.Layer.FindOrOpen(str(tmp_path / name)) or Sdf.Layer.CreateNew(str(tmp_path / name))
        spec = layer.GetPrimAtPath(ANIMATION) or Sdf.CreatePrimInLayer(layer, ANIMATION)
        metric = LearnedMetric(tuple(JOINTS), MetricParameters.identity(3), provenance=provenance)
        write_metric(spec, metric)
        if name == "strong.usda":
            layer.subLayerPaths = ["./weak.usda"]
        layer.Save()
    assert stored_metric(tmp_path / "strong.usda").provenance == {"both": {"b": 2}}


@pytest.mark.parametrize("number", [2**63, -(2**63) - 1, 10**400])
def test_integers_of_more_than_64_bits_are_refused(tmp_path, refuse, number):
    with pytest.raises(ValueError, match="provenance has a value that JSON cannot store: .* has more than 64 bits"):
        LearnedMetric(("a",), MetricParameters.identity(1), provenance={"seed": [number]})
    make_rig(tmp_path / "in.usda")
    text = LearnedMetric(tuple(JOINTS), MetricParameters.identity(3), provenance={"seed": 7}).to_json()
    (tmp_path / "m.json").write_text(text.replace('"seed": 7', f'"seed": {number}'))
    out = ("-o", tmp_path / "out.usda", "--factor", 2, "--metric", tmp_path / "m.json")
    assert "has more than 64 bits" in refuse("upsample", tmp_path / "in.usda", *out)
    if number > 0:
        seed = ("learn", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--seed", number)
        assert refuse(*seed, exit_code=2).startswith("--seed: must be below 2^63, not ")
