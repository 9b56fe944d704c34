"""Style as data: metrics are shown, set, copied, exported and imported, and no sample changes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel
from rigs import ANIMATION, JOINTS, bits, make_rig, read, some_metric, stored_metric

from geomstats_anim import LearnedMetric
from usd_tools.console.errors import ToolError, UsageError
from usd_tools.editing.edits import Mirror, PinKey, UseScheme
from usd_tools.editing.presets import write_preset
from usd_tools.metric import MetricOptions, export_metric, set_metric, set_metric_stage, show_metric, show_metric_stage
from usd_tools.metrics.attributes import write_metric
from usd_tools.upsampling.joint_styles import Style


@pytest.fixture
def rig(tmp_path):
    make_rig(tmp_path / "in.usda")
    return tmp_path / "in.usda"


@pytest.fixture
def learned(tmp_path):
    """A file that stores a metric, with axes and provenance."""
    stage = make_rig(tmp_path / "learned.usda")
    write_metric(stage.GetRootLayer().GetPrimAtPath(ANIMATION), some_metric(axes=True))
    stage.Save()
    return tmp_path / "learned.usda"


def test_set_stores_a_style_and_no_samples(tmp_path, run, rig):
    out = tmp_path / "style.usda"
    code, said, err = run("metric", "set", rig, "-o", out, "--joint", "arm:alpha=4,tension=.5", "--beta", ".5")
    assert (code, err) == (0, "") and said.endswith(f"Wrote {out}.\n")
    metric = stored_metric(out)
    assert metric.parameters.alpha.tolist() == [1.0, 1.0, 4.0]
    assert metric.parameters.beta.tolist() == [0.5] * 3
    assert metric.tension.tolist() == [1.0, 1.0, 0.5]
    assert not Sdf.Layer.FindOrOpen(str(out)).ListAllTimeSamples()
    for name in ("rotations", "translations"):
        assert bits(read(out, name)[1]) == bits(read(rig, name)[1])


def test_set_keeps_what_is_not_named(tmp_path, run, learned):
    assert run("metric", "set", learned, "-o", tmp_path / "out.usda", "--joint", "arm:beta=2")[0] == 0
    before, after = some_metric(axes=True), stored_metric(tmp_path / "out.usda")
    np.testing.assert_array_equal(after.parameters.alpha, before.parameters.alpha)
    np.testing.assert_array_equal(after.parameters.axes, before.parameters.axes)
    assert after.parameters.beta.tolist() == [*before.parameters.beta[:2], 2.0]
    assert after.provenance["source"] == "walk.usda" and after.quality == ""


def test_upsample_finds_what_is_set(tmp_path, run, rig):
    styled = ["--joint", "*:alpha=3,axes=0 0 45", "--scheme", "geodesic"]
    assert run("metric", "set", rig, "-o", tmp_path / "style.usda", *styled)[0] == 0
    assert run("upsample", tmp_path / "style.usda", "-o", tmp_path / "a.usda", "--factor", 3)[0] == 0
    assert run("upsample", rig, "-o", tmp_path / "b.usda", "--factor", 3, *styled)[0] == 0
    assert bits(read(tmp_path / "a.usda")[1]) == bits(read(tmp_path / "b.usda")[1])


def test_in_place(run, rig):
    samples = bits(read(rig)[1])
    assert run("metric", "set", rig, "--in-place", "--alpha", 2)[0] == 0
    assert stored_metric(rig).parameters.alpha.tolist() == [2.0] * 3 and bits(read(rig)[1]) == samples


def test_export_and_import_lose_nothing(tmp_path, run, rig, learned):
    assert run("metric", "export", learned, "-o", tmp_path / "m.json")[0] == 0
    assert (tmp_path / "m.json").read_text() == some_metric(axes=True).to_json()
    assert run("metric", "import", rig, tmp_path / "m.json", "-o", tmp_path / "out.usda")[0] == 0
    assert stored_metric(tmp_path / "out.usda").to_json() == some_metric(axes=True).to_json()


def test_copy_matches_by_name(tmp_path, run, learned):
    joints = ["other", "other/x", *JOINTS[::-1]]
    make_rig(tmp_path / "to.usda", joints=[*JOINTS, *joints[:2]], anim_joints=joints)
    code, _, err = run("metric", "copy", learned, tmp_path / "to.usda", "-o", tmp_path / "out.usda")
    assert code == 0 and "the metric has no entry for joints other, x; using the identity there." in err
    expected, _ = some_metric(axes=True).for_joints(joints)
    assert stored_metric(tmp_path / "out.usda").to_json() == expected.to_json()


def test_upsample_takes_the_metric_of_another_usd_file(tmp_path, run, rig, learned):
    code, said, _ = run("upsample", rig, "-o", tmp_path / "out.usda", "--factor", 2, "--metric", learned)
    assert code == 0 and "geodesic, learned.usda metric" in said
    assert stored_metric(tmp_path / "out.usda").to_json() == some_metric(axes=True).to_json()


@pytest.mark.parametrize(("name", "tension"), [("slerp", 0.0), ("smooth", 1.0), ("soft", 2.0), ("snappy", 0.3)])
def test_presets(tmp_path, run, learned, name, tension):
    options = ["--preset", name, "--joint", "arm:alpha=2"]
    assert run("metric", "set", learned, "-o", tmp_path / "out.usda", *options)[0] == 0
    metric = stored_metric(tmp_path / "out.usda")
    assert metric.tension.tolist() == metric.translation_tension.tolist() == [tension] * 3
    assert metric.parameters.alpha.tolist() == [1.0, 1.0, 2.0] and set(metric.parameters.invariance) == {"left"}
    assert not np.any(metric.parameters.axes)
    assert metric.scheme == ("geodesic" if name == "slerp" else "geodesic-spline")


def test_presets_of_the_user(tmp_path, run, refuse):
    joints = ["hand_l", "hand_r"]
    make_rig(tmp_path / "in.usda", joints=joints)
    write_preset(tmp_path / "p.json", [UseScheme("geodesic"), Style("hand_l", alpha=5.0), Mirror("hand_l")])
    words = ["metric", "set", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--preset", tmp_path / "p.json"]
    assert run(*words)[0] == 0
    assert stored_metric(tmp_path / "out.usda").parameters.alpha.tolist() == [5.0, 5.0]
    write_preset(tmp_path / "p.json", [PinKey(1.0)])
    assert "chooses keys, which a metric does not have" in refuse(*words)
    assert refuse(*words[:-1], "sot", exit_code=2).endswith("not 'sot'; did you mean soft?")


def test_show_has_a_row_for_each_joint_with_a_style(run, learned, rig):
    code, out, _ = run("metric", "show", learned)
    metric = some_metric(axes=True)
    lines = [line for line in out.splitlines() if "│" in line]
    assert code == 0 and len(lines) == 3
    for line, alpha, side in zip(lines, metric.parameters.alpha, metric.parameters.invariance, strict=True):
        assert f" {alpha:.4g} " in line and f" {side} " in line
    assert run("metric", "show", rig)[1] == f"{ANIMATION}: no metric is stored.\n"
    shown = json.loads(run("metric", "show", learned, "--json")[1])["animations"][0]
    assert LearnedMetric.from_json(json.dumps(shown["metric"])).to_json() == metric.to_json()
    assert shown["problems"] == []


def test_show_says_what_is_wrong(run, learned):
    stage = Usd.Stage.Open(str(learned))
    stage.GetPrimAtPath(ANIMATION).GetAttribute("geodesicMetric:alpha").Set([1.0])
    stage.Save()
    code, out, _ = run("metric", "show", learned)
    assert code == 0 and out.splitlines() == [
        f"{ANIMATION}: the metric cannot be read.",
        f"{ANIMATION}: geodesicMetric:alpha has 1 values for 3 joints.",
    ]


def test_an_open_stage_stores_it_in_the_edit_target(rig):
    stage = Usd.Stage.Open(str(rig))
    stage.SetEditTarget(stage.GetSessionLayer())
    result = set_metric_stage(stage, MetricOptions(alpha=4.0))
    assert result.output == stage.GetSessionLayer().GetDisplayName() and not stage.GetRootLayer().dirty
    (shown,) = show_metric_stage(stage).animations
    assert shown.metric.to_json() == result.animations[0].metric.to_json()


def test_a_folder(tmp_path, run, rig):
    (tmp_path / "walks").mkdir()
    rig.rename(tmp_path / "walks" / "a.usda")
    make_rig(tmp_path / "walks" / "b.usda")
    code, out, _ = run("metric", "set", tmp_path / "walks", "-o", tmp_path / "out", "--alpha", 3)
    assert code == 0 and "a.usda: metric of 1 animation" in out
    for name in ("a.usda", "b.usda"):
        assert stored_metric(tmp_path / "out" / name).parameters.alpha.tolist() == [3.0] * 3


def test_what_is_refused(tmp_path, refuse, rig, learned):
    out = ["-o", tmp_path / "out.usda"]
    assert refuse("metric", "set", rig, *out, exit_code=2).startswith("name what to set: --preset")
    assert "usd_tools.learn stores what it learns" in refuse(
        "metric", "set", rig, *out, "--metric", "learn", exit_code=2
    )
    assert refuse("metric", "set", rig, "--alpha", 2, exit_code=2) == "name the output with -o/--out."
    assert "leg matches no joint" in refuse("metric", "set", rig, *out, "--preset", "soft", "--joint", "leg:alpha=2")
    slerp = refuse("metric", "set", rig, *out, "--scheme", "slerp", "--alpha", 2)
    assert slerp.endswith(
        "the scheme slerp has no metric; leave out --alpha, or use --scheme geodesic or geodesic-spline."
    )
    tension = refuse("metric", "set", rig, *out, "--preset", "slerp", "--tension", 1)
    assert "the scheme geodesic has no tension" in tension
    assert "stores no metric" in refuse("metric", "copy", rig, learned, *out)
    assert "stores no metric" in refuse("metric", "export", rig, "-o", tmp_path / "m.json")
    assert "must end in .json" in refuse("metric", "export", learned, "-o", tmp_path / "m.usda")
    assert "is where the metric comes from" in refuse("metric", "copy", learned, rig, "-o", learned)
    assert refuse("metric", "sho", rig, exit_code=2).endswith("not 'sho'; did you mean show?")
    assert refuse("metric", "set", rig, "--jont", "x", exit_code=2) == "unknown option --jont; did you mean --joint?"


def test_different_metrics_of_one_file_are_not_mixed_up(tmp_path, run, refuse, learned):
    stage = Usd.Stage.Open(str(learned))
    UsdSkel.Animation.Define(stage, "/Other").CreateJointsAttr(JOINTS)
    layer = stage.GetRootLayer()
    write_metric(layer.GetPrimAtPath("/Other"), replace(some_metric(), quality="loc"))
    stage.Save()
    export = ["metric", "export", learned, "-o", tmp_path / "m.json"]
    assert refuse(*export).endswith("stores 2 metrics; choose one with --prim.")
    assert "stores 2 metrics; write one to a JSON file" in refuse(
        "metric", "copy", learned, learned, "-o", tmp_path / "out.usda"
    )
    assert run(*export, "--prim", "/Other")[0] == 0
    assert LearnedMetric.from_json((tmp_path / "m.json").read_text()).quality == "loc"


def test_functions_print_nothing_and_raise(tmp_path, capsys, rig, learned):
    set_metric(rig, tmp_path / "out.usda", MetricOptions(metric=learned))
    export_metric(tmp_path / "out.usda", tmp_path / "m.json")
    (shown,) = show_metric(tmp_path / "out.usda").animations
    assert shown.metric.to_json() == some_metric(axes=True).to_json()
    with pytest.raises(ToolError, match="there is no such prim"):
        show_metric(rig, prim=["/None"])
    with pytest.raises(UsageError, match="--preset must be slerp, smooth, soft, snappy or a JSON file"):
        set_metric(rig, tmp_path / "x.usda", MetricOptions(preset="hard"))
    assert capsys.readouterr() == ("", "")
