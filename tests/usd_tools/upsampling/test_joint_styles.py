"""Styles by hand."""

import json

import numpy as np
import pytest
from rigs import make_rig, read, stored_metric

from geomstats_anim import SCHEMES, LearnedMetric
from geomstats_anim.names import WITH_METRIC
from usd_tools.upsampling.joint_styles import parse_style, styled

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


def test_tensions_and_axes():
    texts = ("*:tension=0.5,translation-tension=2", "*Arm:alpha=3,tension=0,axes=0 0 90", "*Hand:alpha=2")
    styles = [parse_style(text) for text in texts]
    assert tuple(map(str, styles)) == texts
    metric = styled(LearnedMetric.plain(JOINTS, "geodesic-spline"), styles)
    assert metric.tension.tolist() == [0.5, 0.0, 0.5] and metric.translation_tension.tolist() == [2.0] * 3
    np.testing.assert_allclose(metric.parameters.axes, [[0, 0, 0], [0, 0, np.pi / 2], [0, 0, 0]])
    # Z of a joint whose second axis has turned to the first
    np.testing.assert_allclose(metric.parameters.matrices[1], np.diag([3.0, 1.0, 1.0]), atol=1e-12)
    assert styled(LearnedMetric.plain(JOINTS, "geodesic-spline"), styles[:1]).parameters.axes is None


def test_tension_of_zero_is_geodesic_and_of_one_joint_is_its_own(tmp_path, run, refuse):
    make_rig(tmp_path / "in.usda", codes=range(6))
    source = ["upsample", tmp_path / "in.usda", "--factor", 2, "-o"]
    run(*source, tmp_path / "plain.usda")
    run(*source, tmp_path / "geodesic.usda", "--scheme", "geodesic")
    run(*source, tmp_path / "zero.usda", "--tension", 0, "--translation-tension", 0)
    run(*source, tmp_path / "arm.usda", "--joint", "arm:tension=0")
    plain, geodesic, zero, arm = (
        np.array(read(tmp_path / f"{name}.usda")[1]) for name in ("plain", "geodesic", "zero", "arm")
    )
    np.testing.assert_array_equal(zero, geodesic)
    np.testing.assert_array_equal(arm[:, :2], plain[:, :2])
    np.testing.assert_array_equal(arm[:, 2], geodesic[:, 2])
    assert np.abs(plain - geodesic).max() > 1e-3
    straight, curved = (np.array(read(tmp_path / f"{n}.usda", "translations")[1]) for n in ("zero", "plain"))
    np.testing.assert_allclose(straight[1::2], 0.5 * (straight[:-1:2] + straight[2::2]), rtol=1e-6)
    assert stored_metric(tmp_path / "arm.usda").tension.tolist() == [1.0, 1.0, 0.0]
    for options in (["--tension", 1], ["--joint", "arm:translation-tension=1"]):
        sentence = refuse(*source, tmp_path / "o.usda", "--scheme", "geodesic", *options)
        assert sentence == (
            "/Rig/Anim: the scheme geodesic has no tension; leave out tensions, or use --scheme geodesic-spline."
        )
    assert refuse(*source, tmp_path / "o.usda", "--scheme", "slerp", "--tension", 0).startswith(
        "/Rig/Anim: the scheme slerp has no metric; leave out --tension"
    )


def test_styles_are_written(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    style = ["--alpha", 2, "--invariance", "right", "--joint", "arm:alpha=8,invariance=left"]
    code, out, _ = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, *style)
    assert code == 0 and "custom metric: alpha 2, invariance right; arm alpha 8, invariance left\n" in out
    metric = stored_metric(tmp_path / "out.usda")
    np.testing.assert_array_equal(metric.parameters.alpha, [2, 2, 8])
    assert metric.parameters.invariance == ("right", "right", "left")
    assert metric.provenance == {"styles": ["*:alpha=2,invariance=right", "arm:alpha=8,invariance=left"]}


@pytest.mark.parametrize("scheme", [scheme for scheme in SCHEMES if scheme not in WITH_METRIC])
def test_schemes_without_metric_take_no_styles(tmp_path, run, refuse, scheme):
    make_rig(tmp_path / "in.usda")
    upsample = ("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--scheme", scheme)
    for options in (["--alpha", 3], ["--invariance", "left", "--joint", "arm:beta=2"], ["--metric", "identity"]):
        assert refuse(*upsample, *options) == (
            f"/Rig/Anim: the scheme {scheme} has no metric; leave out {', '.join(options[::2])}, or use --scheme "
            "geodesic or geodesic-spline."
        )
    code, out, err = run(*upsample, "-v", "--report", tmp_path / "report.json")
    assert (code, err) == (0, "") and f"; {scheme}\n" in out
    assert not {"metric", "alpha"} & set(out.replace(",", " ").split())
    (animation,) = json.loads((tmp_path / "report.json").read_text())["animations"]
    assert (animation["scheme"], animation["metric"], animation["metric_summary"]) == (scheme, None, None)


def test_schemes_without_metric_and_stored_ones(tmp_path, run, refuse):
    """A metric that is there may go unused; a scheme that is stored may have none."""
    make_rig(tmp_path / "in.usda")
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "styled.usda", "--factor", 2, "--alpha", 3)
    slerped = ("-o", tmp_path / "slerped.usda", "--factor", 2, "--scheme", "slerp")
    code, out, err = run("upsample", tmp_path / "styled.usda", *slerped)
    assert (code, err) == (0, "") and "; slerp\n" in out
    again = ("upsample", tmp_path / "slerped.usda", "-o", tmp_path / "again.usda", "--factor", 2)
    assert refuse(*again, "--alpha", 3).startswith("/Rig/Anim: the scheme slerp has no metric; leave out --alpha")
    assert run(*again, "--metric", "stored")[0] == 0
