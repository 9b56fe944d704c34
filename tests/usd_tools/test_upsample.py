"""Laws of upsampled files."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel
from rigs import ANIMATION, JOINTS, SKELETON, bits, make_rig, random_rotations, read, set_samples, stored_metric

from geomstats_anim import SCHEMES, LogStatus, interpolate
from geomstats_anim import rotations as quat
from geomstats_anim.interpolation.curves import Fallback
from geomstats_anim.interpolation.schemes import Slerp
from geomstats_anim.names import OWN_SCHEMES
from usd_tools.console.progress import Progress, ProgressBar
from usd_tools.files.paths import relative_asset_path
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations


@pytest.mark.parametrize("scheme", OWN_SCHEMES)
@pytest.mark.parametrize("how", [["--factor", 3], ["--fps", 60], ["--fps", 100], ["--times", "0.1,1,2.5"]])
def test_source_samples_stay_bit_for_bit(tmp_path, run, scheme, how):
    scales = np.random.default_rng(1).uniform(0.5, 2.0, (4, 3, 3)).astype(np.float16)
    make_rig(tmp_path / "in.usda", scales=scales)
    style = ["--alpha", 4] if scheme.startswith("geodesic") else []
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usdc", "--scheme", scheme, *style, *how)
    assert (code, err) == (0, "")
    for name in ("rotations", "translations", "scales"):
        codes, values = read(tmp_path / "in.usda", name)
        new_codes, new_values = read(tmp_path / "out.usdc", name)
        assert set(codes) < set(new_codes)
        assert bits([new_values[new_codes.index(c)] for c in codes]) == bits(values)


def test_in_betweens_of_slerp_are_those_of_usd(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 5, "--scheme", "slerp")
    source = Usd.Stage.Open(str(tmp_path / "in.usda"))
    attribute = source.GetPrimAtPath(ANIMATION).GetAttribute("rotations")
    codes, values = read(tmp_path / "out.usda")
    shown = np.array([np.array(attribute.Get(code)) for code in codes], dtype=np.float64)
    assert quat.distance(quat.normalize(shown), quat.normalize(np.array(values, dtype=np.float64))).max() < 1e-6


def test_translations_scales_and_weights_are_linear(tmp_path, run):
    scales = np.float16([[[1, 1, 1]], [[2, 1, 1]]])
    stage = make_rig(tmp_path / "in.usda", codes=(0, 8), joints=["a"], scales=scales)
    UsdSkel.Animation.Get(stage, ANIMATION).CreateBlendShapesAttr(["smile", "frown"])
    set_samples(stage, "blendShapeWeights", (0, 8), np.float32([[[0], [1]], [[1], [0]]]))
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 4, "--alpha", 3)
    assert np.array(read(tmp_path / "out.usda", "scales")[1])[:, 0, 0].tolist() == [1.0, 1.25, 1.5, 1.75, 2.0]
    weights = np.array(read(tmp_path / "out.usda", "blendShapeWeights")[1])[:, :, 0]
    assert weights.tolist() == [[0, 1], [0.25, 0.75], [0.5, 0.5], [0.75, 0.25], [1, 0]]
    first, last = np.array(read(tmp_path / "in.usda", "translations")[1])
    middle = np.array(read(tmp_path / "out.usda", "translations")[1])[2]
    np.testing.assert_allclose(middle, (first + last) / 2, rtol=1e-7)


def test_metric_bends_in_betweens_only(tmp_path, run):
    make_rig(tmp_path / "in.usda", rotations=random_rotations(4, 3, size=1.0))
    for name, style in (("flat", []), ("bent", ["--alpha", 4, "--beta", 0.5])):
        run("upsample", tmp_path / "in.usda", "-o", tmp_path / f"{name}.usda", "--factor", 2, *style)
    flat, bent = (np.array(read(tmp_path / f"{name}.usda")[1], dtype=np.float64) for name in ("flat", "bent"))
    difference = quat.distance(quat.normalize(flat), quat.normalize(bent))
    assert difference[::2].max() < 1e-15
    assert difference[1::2].max() > 1e-3


def test_factor_one_adds_nothing_and_twice_is_once(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "one.usda", "--factor", 1)
    assert read(tmp_path / "one.usda")[0] == read(tmp_path / "in.usda")[0]
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "two.usda", "--factor", 2)
    run("upsample", tmp_path / "two.usda", "-o", tmp_path / "again.usda", "--factor", 1)
    assert bits(read(tmp_path / "again.usda")[1]) == bits(read(tmp_path / "two.usda")[1])


@pytest.mark.parametrize("extension", ["usda", "usdc", "usd", "usdz"])
def test_same_input_same_bytes(tmp_path, run, extension):
    make_rig(tmp_path / "in.usda")
    contents = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        out = tmp_path / name / f"out.{extension}"
        assert run("upsample", tmp_path / "in.usda", "-o", out, "--factor", 3, "--alpha", 2)[0] == 0
        contents.append(out.read_bytes())
        (tmp_path / "in.usda").touch()
    assert contents[0] == contents[1]
    assert str(tmp_path).encode() not in contents[0]


def test_holds_stay_holds(tmp_path, run):
    rotations = random_rotations(4, 3)
    rotations[1:3, 1] = rotations[1, 1]
    rotations[2, 1] *= -1.0  # the same rotation
    rotations[1:3, 2] *= np.float32(1.0001)  # not of unit length: stays so
    rotations[2, 2] = rotations[1, 2]
    make_rig(tmp_path / "in.usda", rotations=rotations)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 4, "--alpha", 5)
    dense = np.array(read(tmp_path / "out.usda")[1])
    assert all(frame.tobytes() == rotations[1, 1:].tobytes() for frame in dense[4:8, 1:])


def test_stepped_pairs_are_not_subdivided(tmp_path, run):
    step = Usd.TimeCode.SafeStep()
    codes = [0, 1 - step, 1, 2 - step, 2, 3]
    poses = random_rotations(4, 3)
    make_rig(tmp_path / "in.usda", codes=codes, rotations=poses[[0, 0, 1, 1, 2, 3]], translations=None)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--alpha", 3)
    new_codes, values = read(tmp_path / "out.usda")
    np.testing.assert_allclose(new_codes, [0, 0.5, 1, 1, 1.5, 2, 2, 2.5, 3], atol=1e-6)
    assert bits(values[:3]) == bits([poses[0]] * 3)
    assert bits(values[3:6]) == bits([poses[1]] * 3)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "fps.usda", "--fps", 48)
    assert read(tmp_path / "fps.usda")[0] == pytest.approx(new_codes, abs=1e-8)


def test_a_spline_does_not_take_steps_for_motion(tmp_path, run):
    step = Usd.TimeCode.SafeStep()
    poses = random_rotations(6, 3)
    make_rig(tmp_path / "in.usda", codes=[0, 1, 2 - step, 2, 3, 4], rotations=poses, translations=None)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 4)
    whole = np.array(read(tmp_path / "out.usda")[1])
    for name, codes, part in (("before", [0, 1, 2 - step], poses[:3]), ("after", [2, 3, 4], poses[3:])):
        make_rig(tmp_path / f"{name}.usda", codes=codes, rotations=part, translations=None)
        run("upsample", tmp_path / f"{name}.usda", "-o", tmp_path / f"{name}_out.usda", "--factor", 4)
    parts = [np.array(read(tmp_path / f"{name}_out.usda")[1]) for name in ("before", "after")]
    np.testing.assert_array_equal(whole, np.concatenate(parts))


def test_without_a_metric_it_is_the_plain_spline(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(8), rotations=random_rotations(8, 3))
    code, out, _ = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 4)
    assert code == 0 and "geodesic-spline, identity metric" in out
    metric = stored_metric(tmp_path / "out.usda")
    assert metric.scheme == "geodesic-spline"
    assert (metric.parameters.moments == 1.0).all()
    assert (metric.tension == 1.0).all() and (metric.translation_tension == 1.0).all()
    keys = read_clip(find_animations(Usd.Stage.Open(str(tmp_path / "in.usda")))[0]).keys(("rotations",), slice(None))
    dense = interpolate(keys, np.arange(29) / 4.0 / 24.0, "geodesic-spline").rotations
    found = np.array(read(tmp_path / "out.usda")[1], dtype=np.float64)
    assert quat.distance(quat.normalize(found), dense).max() < 1e-6


def test_another_scheme_does_not_take_over_the_tension(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    run(
        "upsample",
        tmp_path / "in.usda",
        "-o",
        tmp_path / "one.usda",
        "--factor",
        2,
        "--scheme",
        "geodesic",
        "--alpha",
        3,
    )
    run("upsample", tmp_path / "one.usda", "-o", tmp_path / "two.usda", "--factor", 2, "--scheme", "geodesic-spline")
    one, two = stored_metric(tmp_path / "one.usda"), stored_metric(tmp_path / "two.usda")
    assert (one.tension == 0.0).all() and (two.tension == 1.0).all()
    assert (two.parameters.alpha == one.parameters.alpha).all()


def test_value_blocks_stay_where_they_are(tmp_path, run):
    poses = random_rotations(5, 3)
    rotations = [poses[0], poses[1], None, poses[3], poses[4]]
    make_rig(tmp_path / "in.usda", codes=(0, 1, 2, 3, 4), rotations=rotations)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    codes, values = read(tmp_path / "out.usda")
    # From 1 to 2 USD holds the sample before the block; from 2 to 3 there is nothing.
    assert codes == [0, 0.5, 1, 1.5, 2, 3, 3.5, 4]
    assert [value is None for value in values] == [False] * 4 + [True] + [False] * 3
    assert bits(values[2:4]) == bits([poses[1]] * 2)
    assert len(read(tmp_path / "out.usda", "translations")[0]) == 9


def test_channels_with_samples_at_different_times(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda", codes=(0, 2, 4), translations=None)
    moves = np.linspace(0, 1, 18, dtype=np.float32).reshape(2, 3, 3)
    set_samples(stage, "translations", (1, 4), moves)
    stage.Save()
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 1)
    codes, values = read(tmp_path / "out.usda")
    assert codes == read(tmp_path / "out.usda", "translations")[0] == [0, 1, 2, 4]
    source = read(tmp_path / "in.usda")[1]
    assert bits([values[0], values[2], values[3]]) == bits(source)
    translations = read(tmp_path / "out.usda", "translations")[1]
    assert bits(translations[1::2]) == bits(list(moves))
    assert bits(translations[:1]) == bits([moves[0]])
    np.testing.assert_allclose(translations[2], moves[0] + (moves[1] - moves[0]) / 3, rtol=1e-6)


def test_joints_in_any_order_and_subsets(tmp_path, run):
    rotations = random_rotations(4, 3)
    make_rig(tmp_path / "all.usda", rotations=rotations)
    make_rig(tmp_path / "some.usda", rotations=rotations[:, [2, 0]], anim_joints=[JOINTS[2], JOINTS[0]])
    for name in ("all", "some"):
        run("upsample", tmp_path / f"{name}.usda", "-o", tmp_path / f"{name}2.usda", "--factor", 3, "--alpha", 4)
    everything, some = (np.array(read(tmp_path / f"{name}2.usda")[1]) for name in ("all", "some"))
    assert everything[:, [2, 0]].tobytes() == some.tobytes()


def test_joint_that_the_skeleton_does_not_have_and_library(tmp_path, run):
    make_rig(tmp_path / "in.usda", anim_joints=["tail", *JOINTS[:2]])
    assert run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)[0] == 0
    assert len(read(tmp_path / "out.usda")[0]) == 7
    make_rig(tmp_path / "library.usda", bind=False)
    assert run("upsample", tmp_path / "library.usda", "-o", tmp_path / "out2.usda", "--factor", 2)[0] == 0
    assert len(read(tmp_path / "out2.usda")[0]) == 7


def test_sign_flips_stay_at_samples_and_in_betweens_follow_the_left(tmp_path, run):
    rotations = random_rotations(4, 3)
    rotations[2] *= -1.0
    make_rig(tmp_path / "in.usda", rotations=rotations)
    run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 4, "--alpha", 2)
    dense = np.array(read(tmp_path / "out.usda")[1], dtype=np.float64)
    dots = np.einsum("fbi,fbi->fb", dense[1:], dense[:-1])
    flipped = np.flatnonzero((dots < 0.0).all(axis=1))
    assert flipped.tolist() == [7, 11]  # just before samples 2 and 3
    assert (dots[np.setdiff1d(np.arange(12), flipped)] > 0.0).all()


def test_missing_channels_are_written_from_the_rest_pose(tmp_path, run):
    make_rig(tmp_path / "in.usda", translations=None, scales=None)
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert code == 0
    assert err == (
        f"warning: {ANIMATION} has no translations and no scales, so viewers show the rest pose; "
        "written from the rest pose.\n"
    )
    stage = Usd.Stage.Open(str(tmp_path / "out.usda"))
    animation = UsdSkel.Animation.Get(stage, ANIMATION)
    assert np.array(animation.GetTranslationsAttr().Get()).tolist() == [[0, 10, 0]] * 3
    assert np.array(animation.GetScalesAttr().Get()).tolist() == [[1, 1, 1]] * 3
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton.Get(stage, SKELETON))
    shown = np.array(query.ComputeJointLocalTransforms(Usd.TimeCode(0.0)))
    assert not np.allclose(shown, np.array(UsdSkel.Skeleton.Get(stage, SKELETON).GetRestTransformsAttr().Get()))


def test_dry_run_writes_the_report_only(tmp_path, run):
    make_rig(tmp_path / "in.usda")
    before = sorted(path.name for path in tmp_path.iterdir())
    report = tmp_path / "report.json"
    code, out, _ = run("upsample", tmp_path / "in.usda", "--factor", 2, "--dry-run", "--report", report)
    assert (code, out.splitlines()[-1]) == (0, "Dry run: nothing was written.")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*before, "report.json"])
    (animation,) = json.loads(report.read_text())["animations"]
    assert (animation["samples_before"], animation["samples_after"], animation["metric"]) == (4, 7, "identity")
    assert (animation["rate_before"], animation["rate_after"]) == (24, 48)


def test_prim_selects_by_skeleton_animation_or_ancestor(tmp_path, run):
    stage = make_rig(tmp_path / "in.usda")
    Sdf.CopySpec(stage.GetRootLayer(), "/Rig", stage.GetRootLayer(), "/Other")
    stage.Save()
    for prim in ("/Other", "/Other/Skel", "/Other/Anim"):
        _, out, _ = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "--prim", prim)
        assert out.startswith("/Other/Anim: 4 -> 7 samples")
        assert len(read(tmp_path / "out.usda", prim="/Other/Anim")[0]) == 7
        assert len(read(tmp_path / "out.usda")[0]) == 4


def test_verbose_warns_of_wide_steps(tmp_path, run):
    rotations = np.float32([[[0, 0, 0, 1]], [[1, 0, 0, 0.1]]])
    make_rig(tmp_path / "in.usda", codes=(0, 1), joints=["a"], rotations=rotations)
    _, out, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2, "-v")
    assert "joint a turns 168.6 degrees from time code 0 to 1" in err
    assert "rotations: 2 -> 3 samples" in out


def test_scale_of_ancestors_is_divided_out_again(tmp_path, run):
    make_rig(tmp_path / "plain.usda")
    stage = make_rig(tmp_path / "scaled.usda")
    UsdGeom.Xformable(stage.GetPrimAtPath("/Rig")).AddScaleOp().Set((0.013, 0.013, 0.013))
    stage.Save()
    for name in ("plain", "scaled"):
        run("upsample", tmp_path / f"{name}.usda", "-o", tmp_path / f"{name}2.usda", "--factor", 3)
    plain, scaled = (np.array(read(tmp_path / f"{name}2.usda", "translations")[1]) for name in ("plain", "scaled"))
    np.testing.assert_allclose(plain, scaled, rtol=2e-7)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    gaps=st.lists(st.floats(0.01, 50.0), min_size=1, max_size=6),
    factor=st.integers(1, 5),
    blocked=st.sets(st.integers(0, 6)),
    seed=st.integers(0, 1000),
)
def test_any_samples_stay(tmp_path, run, gaps, factor, blocked, seed):
    """Source samples and blocks stay, and nothing appears in a blocked stretch."""
    codes = np.cumsum([0.0, *gaps]).tolist()
    poses = random_rotations(len(codes), 3, seed)
    rotations = [None if k in blocked else pose for k, pose in enumerate(poses)]
    name = tmp_path / f"{seed}_{abs(hash((tuple(gaps), factor, tuple(blocked))))}.usda"
    make_rig(name, codes=codes, rotations=rotations)
    code, _, err = run("upsample", name, "-o", tmp_path / "out.usda", "--factor", factor, "--alpha", 2)
    assert code == 0, err
    new_codes, values = read(tmp_path / "out.usda")
    assert bits([values[new_codes.index(c)] for c in codes]) == bits(rotations)
    for at, value in zip(new_codes, values, strict=True):
        before = max(k for k, c in enumerate(codes) if c <= at)
        if rotations[before] is None and any(rotation is not None for rotation in rotations[:before]):
            assert at == codes[before] and value is None


def test_links_are_not_followed_in_names():
    assert relative_asset_path(Path("/a/b/in.usda"), Path("/a/b/c")) == "../in.usda"
    assert relative_asset_path(Path("/a/b/in.usda"), Path("/a/b")) == "./in.usda"


def test_as_a_command(tmp_path):
    make_rig(tmp_path / "in.usda")
    root = Path(__file__).resolve().parents[2]
    command = [sys.executable, "-m", "usd_tools.upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda"]
    done = subprocess.run([*command, "--factor", "2"], cwd=root, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    slow = "import sys, usd_tools.upsample, usd_tools.inspect; print([m for m in sys.modules if m.split('.')[0] in " \
        "('geomstats', 'matplotlib', 'ray', 'hyperopt')])"  # fmt: skip
    assert subprocess.run([sys.executable, "-c", slow], cwd=root, capture_output=True, text=True).stdout == "[]\n"


class Unlucky(Slerp):
    """A scheme that finds no geodesic for the last joint."""

    def __init__(self, animation, metric=None):
        super().__init__(animation)
        joint, times = animation.skeleton.joints[-1], animation.times
        self.fallbacks = tuple(Fallback(joint, *times[k : k + 2].tolist(), LogStatus.STALLED) for k in (0, 2))


def test_fallbacks_are_named(tmp_path, run, monkeypatch):
    monkeypatch.setitem(SCHEMES, "geodesic", Unlucky)
    make_rig(tmp_path / "in.usda", codes=(10, 11, 12, 13))
    report = tmp_path / "report.json"
    arguments = ("--factor", 2, "--scheme", "geodesic", "--report", report)
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "o.usda", *arguments)
    assert code == 0
    assert err == (
        f"warning: {ANIMATION}: joint arm uses slerp from time code 10 to 11, 12 to 13. {LogStatus.STALLED}\n"
    )
    told = json.loads(report.read_text())
    fallbacks = told["animations"][0]["fallbacks"]
    assert [(each["joint"], each["start"], each["end"], each["status"]) for each in fallbacks] == [
        (JOINTS[2], 10.0, 11.0, "STALLED"),
        (JOINTS[2], 12.0, 13.0, "STALLED"),
    ]
    assert told["warnings"] == [err.removeprefix("warning: ").rstrip()]


def test_progress_shows_late_and_on_a_terminal_only(monkeypatch, capsys):
    for terminal, patience, shows in ((True, 0.0, True), (False, 0.0, False), (True, 100.0, False)):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        monkeypatch.setattr("usd_tools.console.progress.PATIENCE", patience)
        with ProgressBar() as bar:
            Progress(bar, 10.0, "Interpolating").advance(5.0)
            assert (bar._bar is not None) == shows
        assert capsys.readouterr().out == ""


@pytest.mark.parametrize("units", [0.0, float("nan"), -1.0])
def test_units_that_make_no_sense(tmp_path, run, units):
    stage = make_rig(tmp_path / "in.usda")
    stage.SetMetadata("metersPerUnit", units)
    stage.Save()
    code, _, err = run("upsample", tmp_path / "in.usda", "-o", tmp_path / "out.usda", "--factor", 2)
    assert (code, err) == (
        0,
        f"warning: {ANIMATION}: {units:g} metres is not a usable unit; using one metre per unit.\n",
    )
    assert len(read(tmp_path / "out.usda", "translations")[0]) == 7


@pytest.mark.parametrize("verb", ["upsample", "downsample"])
def test_a_skeleton_that_is_nowhere_in_the_world(tmp_path, run, verb):
    stage = make_rig(tmp_path / "in.usda", codes=range(8), rotations=random_rotations(8, 3))
    UsdGeom.Xformable(stage.GetPrimAtPath(SKELETON)).AddTranslateOp().Set(Gf.Vec3d(np.nan, 0, 0))
    stage.Save()
    how = {"upsample": ("--factor", 2), "downsample": ("--keys", 4)}[verb]
    code, _, err = run(verb, tmp_path / "in.usda", "-o", tmp_path / "out.usda", *how)
    assert code == 0 and "Traceback" not in err
