"""Styles by hand."""

import numpy as np
from rigs import make_rig, stored_metric

from geomstats_anim import LearnedMetric
from usd_tools.style_controls import parse_style, styled

JOINTS = ["rig:Hips", "rig:Hips/rig:LeftArm", "rig:Hips/rig:LeftArm/rig:LeftHand"]


def test_pattern_matches_path_or_last_part():
    style = parse_style("rig:Left*:alpha=4,beta=.5,invariance=right")
    assert [style.matches(joint) for joint in JOINTS] == [False, True, True]
    assert [parse_style("*/rig:LeftArm/*:alpha=4").matches(joint) for joint in JOINTS] == [False, False, True]
    assert not parse_style("RIG:*:alpha=4").matches(JOINTS[0])


def test_later_styles_win():
    styles = [parse_style(text) for text in ("*:alpha=2,invariance=right", "*Arm:alpha=4", "*Hand:beta=0.5")]
    metric = styled(LearnedMetric.plain(JOINTS, "geodesic"), styles)
    assert metric.parameters.alpha.tolist() == [2, 4, 2]
    assert metric.parameters.beta.tolist() == [1, 1, 0.5]
    assert metric.parameters.invariance == ("right",) * 3
    assert metric.provenance["styles"] == [str(style) for style in styles]


def test_nothing_changes_where_nothing_matches():
    metric = LearnedMetric.plain(JOINTS, "geodesic")
    assert styled(metric, [parse_style("leg:alpha=2")]) is metric


def test_text_round_trip():
    text = "a?b[cd]*:alpha=4,beta=0.5,invariance=right"
    assert str(parse_style(text)) == text
    assert parse_style(str(parse_style(text))) == parse_style(text)


def test_styles_are_written(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    style = ["--alpha", 2, "--invariance", "right", "--joint", "arm:alpha=8,invariance=left"]
    code, out, _ = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, *style)
    assert (code, "identity metric, styled" in out) == (0, True)
    metric = stored_metric(tmp_path / "out.usda")
    np.testing.assert_array_equal(metric.parameters.alpha, [2, 2, 8])
    assert metric.parameters.invariance == ("right", "right", "left")
    assert metric.provenance == {"styles": ["*:alpha=2,invariance=right", "arm:alpha=8,invariance=left"]}
